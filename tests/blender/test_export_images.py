"""Images: every way that Blender holds them, to texels as Cycles stores them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from photon_map.core.scene.tables import ImageKind
from tests.blender.support import Exported, add_camera, add_mesh, export, new_material

#: 3 x 2 texels, straight alpha; all different.
PIXELS = np.linspace(0, 1, 24).reshape(2, 3, 4)
BYTES = np.rint(PIXELS * 255)


def picture(bpy: Any, name: str = "P", pixels: np.ndarray = PIXELS, **values: Any) -> Any:
    """A generated image of ``pixels`` (H, W, 4), the bottom row first."""
    height, width = pixels.shape[:2]
    options = {k: values.pop(k) for k in ("alpha", "float_buffer", "is_data") if k in values}
    image = bpy.data.images.new(name, width, height, **{"alpha": True, **options})
    space = values.pop("space", None)
    if space:
        image.colorspace_settings.name = space
    for key, value in values.items():
        setattr(image, key, value)
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    image.update()
    return image


def textured(bpy: Any, image: Any, **node_values: Any) -> Any:
    """Material M with ``image`` as colour of its diffuse shader on a square with UVs."""
    material = new_material(bpy, "M", "ShaderNodeBsdfDiffuse")
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    for key, value in node_values.items():
        setattr(node, key, value)
    tree.links.new(node.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    add_mesh(bpy, "Square", uv=True, material=material)
    return material


def texels(got: Exported, k: int = 0) -> tuple[int, np.ndarray]:
    """Kind and texels (H, W, 4) of image ``k``."""
    image = got.scene.images[k]
    floats = image["kind"] in (ImageKind.FLOATS, ImageKind.SRGB_FLOATS)
    table = got.scene.texels32 if floats else got.scene.texels8
    count = image["width"] * image["height"]
    stored = table[image["start"] :][:count]
    return int(image["kind"]), stored.reshape(image["height"], image["width"], 4)


def exported(bpy: Any, image: Any, **node_values: Any) -> Exported:
    add_camera(bpy)
    textured(bpy, image, **node_values)
    return export(bpy)


def associated(pixels: np.ndarray) -> np.ndarray:
    return np.concatenate([pixels[..., :3] * pixels[..., 3:], pixels[..., 3:]], axis=2)


def test_generated_bytes(bpy: Any) -> None:
    got = exported(bpy, picture(bpy))
    kind, stored = texels(got)
    assert kind == ImageKind.SRGB_BYTES
    assert stored.dtype == np.uint8
    assert np.abs(stored - associated(BYTES / 255) * 255).max() <= 1
    assert got.warnings == ()


@pytest.mark.parametrize("mode", ["NONE", "CHANNEL_PACKED", "STRAIGHT", "PREMUL"])
def test_alpha_modes(bpy: Any, mode: str) -> None:
    got = exported(bpy, picture(bpy, alpha_mode=mode))
    _, stored = texels(got)
    expected = BYTES.copy()
    if mode == "NONE":
        expected[..., 3] = 255
    if mode == "STRAIGHT":
        expected = associated(BYTES / 255) * 255
    assert np.abs(stored - expected).max() <= 1


def test_data_is_left_as_it_is(bpy: Any) -> None:
    kind, stored = texels(exported(bpy, picture(bpy, space="Non-Color")))
    assert kind == ImageKind.BYTES
    assert (stored == BYTES).all()


def test_linear_bytes(bpy: Any) -> None:
    kind, stored = texels(exported(bpy, picture(bpy, space="Linear Rec.709")))
    assert kind == ImageKind.BYTES
    assert np.abs(stored - associated(BYTES / 255) * 255).max() <= 1


def test_floats_are_scene_linear(bpy: Any) -> None:
    pixels = PIXELS * 5
    pixels[..., 3] = 1
    kind, stored = texels(exported(bpy, picture(bpy, pixels=pixels, float_buffer=True)))
    assert kind == ImageKind.FLOATS
    assert stored == pytest.approx(pixels, rel=1e-6)


def test_other_primaries_go_through_blenders_conversion(bpy: Any) -> None:
    """White stays white; a saturated green of Rec. 2020 leaves the range of Rec. 709."""
    pixels = np.array([[[1.0, 1.0, 1.0, 1.0], [0.0, 1.0, 0.0, 1.0]]])
    got = exported(bpy, picture(bpy, pixels=pixels, space="Linear Rec.2020"))
    kind, stored = texels(got)
    assert kind == ImageKind.FLOATS
    assert stored[0, 0] == pytest.approx([1, 1, 1, 1], abs=1e-3)
    assert stored[0, 1, :3] == pytest.approx([-0.5876, 1.1329, -0.1006], abs=1e-3)
    assert got.warnings == ()


def test_unknown_spaces_are_srgb_with_a_warning(bpy: Any) -> None:
    got = exported(bpy, picture(bpy, space="AgX Log"))
    assert texels(got)[0] == ImageKind.SRGB_BYTES
    (warning,) = got.warnings
    assert "'AgX Log'" in warning
    assert "'P'" in warning
    assert "material 'M'" in warning


@pytest.mark.parametrize("packed", [False, True])
def test_files_and_packed_files(bpy: Any, tmp_path: Path, packed: bool) -> None:
    source = picture(bpy)
    source.filepath_raw, source.file_format = str(tmp_path / "p.png"), "PNG"
    source.save()
    image = bpy.data.images.load(str(tmp_path / "p.png"))
    if packed:
        image.pack()
        (tmp_path / "p.png").unlink()
    kind, stored = texels(exported(bpy, image))
    assert kind == ImageKind.SRGB_BYTES
    assert np.abs(stored - associated(BYTES / 255) * 255).max() <= 1


def test_a_file_of_floats(bpy: Any, tmp_path: Path) -> None:
    """Blender decodes them when it loads them; Cycles mixes what is in the file."""
    pixels = PIXELS * 7
    pixels[..., 3] = 1
    source = picture(bpy, pixels=pixels, float_buffer=True)
    source.filepath_raw, source.file_format = str(tmp_path / "p.exr"), "OPEN_EXR"
    source.save()
    image = bpy.data.images.load(str(tmp_path / "p.exr"))
    image.colorspace_settings.name = "Linear Rec.709"
    kind, linear = texels(exported(bpy, image))
    assert kind == ImageKind.FLOATS
    image.colorspace_settings.name = "sRGB"
    kind, encoded = texels(export(bpy))
    assert kind == ImageKind.SRGB_FLOATS
    assert encoded == pytest.approx(linear, rel=1e-3, abs=1e-6), "the numbers of the file"


def test_a_missing_file_is_magenta_and_named_once(bpy: Any, tmp_path: Path) -> None:
    source = picture(bpy)
    source.filepath_raw, source.file_format = str(tmp_path / "gone.png"), "PNG"
    source.save()
    image = bpy.data.images.load(str(tmp_path / "gone.png"))
    (tmp_path / "gone.png").unlink()
    image.reload()
    add_camera(bpy)
    material = textured(bpy, image)
    add_mesh(bpy, "Again", uv=True, material=material)
    got = export(bpy)
    assert texels(got)[1].tolist() == [[[1, 0, 1, 1]]]
    (warning,) = got.warnings
    assert "material 'M'" in warning
    assert "'gone.png'" in warning
    assert "magenta" in warning


def test_no_image_is_magenta(bpy: Any) -> None:
    got = exported(bpy, None)
    assert texels(got)[1].tolist() == [[[1, 0, 1, 1]]]
    (warning,) = got.warnings
    assert "Image Texture" in warning


def test_one_texel_and_many(bpy: Any) -> None:
    one = np.array([[[0.25, 0.5, 1.0, 1.0]]])
    assert texels(exported(bpy, picture(bpy, pixels=one)))[1].tolist() == [
        [[64, 128, 255, 255]]
    ]
    generator = np.random.default_rng(1)
    many = generator.integers(0, 256, (1024, 2048, 4)) / 255
    many[..., 3] = 1
    bpy.data.materials["M"].node_tree.nodes["Image Texture"].image = picture(bpy, "Many", many)
    got = export(bpy)
    assert (texels(got)[1] == np.rint(many * 255)).all()


def test_an_image_stands_once_however_often_it_is_used(bpy: Any) -> None:
    image = picture(bpy)
    add_camera(bpy)
    material = textured(bpy, image)
    tree = material.node_tree
    second = tree.nodes.new("ShaderNodeTexImage")
    second.image = image
    second.extension = "CLIP"
    tree.links.new(second.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Roughness"])
    got = export(bpy)
    assert len(got.scene.images) == 1
    assert len(got.scene.textures) == 2


@pytest.mark.parametrize("source", ["TILED", "SEQUENCE"])
def test_tiles_and_sequences_warn(bpy: Any, tmp_path: Path, source: str) -> None:
    saved = picture(bpy)
    name = {"TILED": "p.1001.png", "SEQUENCE": "p0001.png"}[source]
    saved.filepath_raw, saved.file_format = str(tmp_path / name), "PNG"
    saved.save()
    image = bpy.data.images.load(str(tmp_path / name))
    image.source = source
    warnings = exported(bpy, image).warnings
    assert "not supported yet" in warnings[0]
    assert f"'{name}'" in warnings[0]
