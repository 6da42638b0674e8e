"""Texture lookups against Cycles: a glowing square with a picture, pixel by pixel."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blender.support import add_camera, add_mesh, export, new_material, read_exr, save_exr
from tests.blender.test_export_images import picture

WIDTH, HEIGHT = 60, 45
#: Coordinates at the left, right, lower and upper border of the view: over all borders.
VIEW = (-0.817, 1.923, -1.307, 1.731)


def noise(width: int = 7, height: int = 5, opaque: bool = False) -> np.ndarray:
    pixels = np.random.default_rng(3).integers(0, 256, (height, width, 4)) / 255
    pixels[0, 0, 3] = 0.0
    if opaque:
        pixels[..., 3] = 1.0
    return pixels


def scene_of(bpy: Any, image: Any, alpha: str = "", **node_values: Any) -> Any:
    """A camera that sees a square that glows like ``image``, and nothing else."""
    camera = add_camera(bpy)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.0
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = WIDTH, HEIGHT
    render.resolution_percentage = 100
    material = new_material(bpy, "M", "ShaderNodeEmission")
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    for key, value in node_values.items():
        setattr(node, key, value)
    emission = tree.nodes["Emission"]
    tree.links.new(
        node.outputs["Alpha" if alpha == "shown" else "Color"], emission.inputs["Color"]
    )
    if alpha == "used":  # a link that changes nothing but how the colour is read
        math = tree.nodes.new("ShaderNodeMath")
        math.operation = "GREATER_THAN"
        math.inputs[1].default_value = -1.0
        tree.links.new(node.outputs["Alpha"], math.inputs[0])
        tree.links.new(math.outputs[0], emission.inputs["Strength"])
    x, y = 1.0, HEIGHT / WIDTH
    square = ([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)], [(0, 1, 2, 3)])
    obj = add_mesh(bpy, "Square", square, material, uv=True)
    left, right, low, high = VIEW
    corners = [left, low, right, low, right, high, left, high]
    obj.data.uv_layers[0].uv.foreach_set("vector", np.array(corners, np.float32))
    return material


def in_cycles(bpy: Any, path: Path) -> np.ndarray:
    """The picture (HEIGHT, WIDTH, 3) of one sample in the middle of each pixel."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.filter_width = 0.01
    scene.render.use_persistent_data = False
    save_exr(bpy, path)
    bpy.ops.render.render(write_still=True)
    scene.render.engine = "PHOTONMAP"
    layers = read_exr(path)
    return next(v for k, v in layers.items() if k.endswith("Combined"))[..., :3]


def looked_up(bpy: Any) -> np.ndarray:
    """The same by our kernels, from the exported tables."""
    from photon_map.core.textures.sampling import sample_uv
    from photon_map.core.textures.shading import shading_tables

    got = export(bpy)
    shading = shading_tables(got.scene)
    (row,) = got.closures_of("M")
    emission = row["emission"]
    left, right, low, high = VIEW
    picture = np.zeros((HEIGHT, WIDTH, 3))
    for y in range(HEIGHT):
        for x in range(WIDTH):
            s = left + (x + 0.5) / WIDTH * (right - left)
            t = low + (y + 0.5) / HEIGHT * (high - low)
            color = sample_uv(shading, int(emission["texture"]), s, t)
            alpha = emission["channel"] == 1
            picture[y, x] = color[3] if alpha else color[:3]
    return picture


def assert_alike(bpy: Any, tmp_path: Path, closest: bool = False) -> None:
    ours, theirs = looked_up(bpy), in_cycles(bpy, tmp_path / "cycles.exr")
    off = np.abs(ours - theirs) > 2e-3 + 0.01 * np.abs(theirs)
    # The samples lie up to 0.005 pixels off the middles: closest lookups may fall to the
    # other side of a border there, and steep slopes show it.
    allowed = 0.02 if closest else 0.002
    worst = np.unravel_index(np.abs(ours - theirs).argmax(), ours.shape)
    assert off.any(axis=2).mean() <= allowed, (worst, ours[worst[:2]], theirs[worst[:2]])


@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP", "MIRROR"])
@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
def test_extension_and_interpolation(
    bpy: Any, tmp_path: Path, extension: str, interpolation: str
) -> None:
    image = picture(bpy, pixels=noise(opaque=True))
    scene_of(bpy, image, extension=extension, interpolation=interpolation)
    assert_alike(bpy, tmp_path, closest=interpolation == "Closest")


@pytest.mark.parametrize("alpha", ["", "used", "shown"])
@pytest.mark.parametrize("mode", ["STRAIGHT", "CHANNEL_PACKED", "NONE", "PREMUL"])
@pytest.mark.parametrize("source", ["generated", "file", "packed"])
def test_alpha(bpy: Any, tmp_path: Path, alpha: str, mode: str, source: str) -> None:
    if mode == "PREMUL" and bpy.app.version < (5, 2, 0):
        pytest.skip("Cycles multiplied premultiplied bytes by alpha again before 5.2")
    pixels = noise()
    if mode == "PREMUL":  # colours no larger than alpha, and alphas that stay colours
        pixels[..., 3] = np.maximum(pixels[..., 3], 0.25)
        pixels[..., :3] *= pixels[..., 3:]
    image = picture(bpy, pixels=pixels)
    if source != "generated":
        image.filepath_raw, image.file_format = str(tmp_path / "p.png"), "PNG"
        image.save()
        image = bpy.data.images.load(str(tmp_path / "p.png"))
    if source == "packed":
        image.pack()
    image.alpha_mode = mode
    scene_of(bpy, image, alpha)
    assert_alike(bpy, tmp_path)


@pytest.mark.parametrize("space", ["sRGB", "Non-Color", "Linear Rec.709", "Linear Rec.2020"])
@pytest.mark.parametrize("alpha", ["", "used"])
def test_colour_spaces_of_bytes(bpy: Any, tmp_path: Path, space: str, alpha: str) -> None:
    scene_of(bpy, picture(bpy, pixels=noise(opaque=not alpha), space=space), alpha)
    assert_alike(bpy, tmp_path)


@pytest.mark.parametrize("alpha", ["", "used"])
@pytest.mark.parametrize("mode", ["STRAIGHT", "CHANNEL_PACKED"])
@pytest.mark.parametrize("space", ["Linear Rec.709", "Non-Color"])
def test_float_images(bpy: Any, tmp_path: Path, alpha: str, mode: str, space: str) -> None:
    if (space, mode) == ("Linear Rec.709", "STRAIGHT") and bpy.app.version < (5, 2, 0):
        pytest.skip("Cycles took straight EXR files for premultiplied ones before 5.2")
    pixels = noise()
    pixels[..., :3] *= 8
    image = picture(bpy, pixels=pixels, float_buffer=True)
    image.filepath_raw, image.file_format = str(tmp_path / "p.exr"), "OPEN_EXR"
    image.save()
    image = bpy.data.images.load(str(tmp_path / "p.exr"))
    image.colorspace_settings.name, image.alpha_mode = space, mode
    scene_of(bpy, image, alpha)
    assert_alike(bpy, tmp_path)


def test_sixteen_bits(bpy: Any, tmp_path: Path) -> None:
    image = picture(bpy, pixels=noise(40, 40, opaque=True), float_buffer=True)
    settings = bpy.context.scene.render.image_settings
    settings.file_format, settings.color_depth, settings.color_mode = "PNG", "16", "RGB"
    image.save_render(str(tmp_path / "p.png"))
    image = bpy.data.images.load(str(tmp_path / "p.png"))
    assert image.is_float
    scene_of(bpy, image)
    assert_alike(bpy, tmp_path, closest=True)


def test_missing(bpy: Any, tmp_path: Path) -> None:
    scene_of(bpy, None)
    assert_alike(bpy, tmp_path)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR"])
def test_mapping(bpy: Any, tmp_path: Path, kind: str) -> None:
    material = scene_of(bpy, picture(bpy, pixels=noise(opaque=True)))
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeMapping")
    node.vector_type = kind
    for name, value in (
        ("Location", (0.25, -0.5, 0.125)),
        ("Rotation", (0.3, -0.4, 0.7)),
        ("Scale", (0.75, 1.5, 0.5)),
    ):
        if name in node.inputs and node.inputs[name].enabled:
            node.inputs[name].default_value = value
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinates.outputs["UV"], node.inputs["Vector"])
    tree.links.new(node.outputs[0], tree.nodes["Image Texture"].inputs["Vector"])
    shown = looked_up(bpy)
    theirs = in_cycles(bpy, tmp_path / "cycles.exr")
    assert (np.abs(shown - theirs).max(axis=2) > 5e-3).mean() < 0.01
