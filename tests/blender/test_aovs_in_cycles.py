"""Shader AOVs beside those of Cycles on the same scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blender.support import (
    SQUARE,
    add_camera,
    add_mesh,
    export,
    headless_render,
    new_material,
    read_exr,
    save_exr,
)


def add_output(tree: Any, name: str, **values: Any) -> Any:
    node = tree.nodes.new("ShaderNodeOutputAOV")
    node.aov_name = name
    for socket, value in values.items():
        node.inputs[socket].default_value = value
    return node


def add_aov(bpy: Any, name: str, kind: str) -> None:
    aov = bpy.context.view_layer.aovs.add()
    aov.name, aov.type = name, kind


def picture_node(bpy: Any, tree: Any) -> Any:
    image = bpy.data.images.new("Ramp", 8, 8, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.ones((8, 8, 4), np.float32)
    pixels[..., 0], pixels[..., 1] = np.linspace(0.1, 0.9, 8), np.linspace(0.2, 0.6, 8)[:, None]
    image.pixels.foreach_set(pixels.ravel())
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    return node


def build(bpy: Any) -> None:
    """A floor with a picture, and over it veils, glass, a mirror and one without a value."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 64, 20
    add_camera(bpy, (0.0, 0.0, 8.0))
    floor = new_material(bpy, "Floor", "ShaderNodeBsdfDiffuse")
    tree = floor.node_tree
    picture = picture_node(bpy, tree)
    tint, number = add_output(tree, "tint"), add_output(tree, "number")
    apart = tree.nodes.new("ShaderNodeSeparateColor")
    product = tree.nodes.new("ShaderNodeMath")
    product.operation = "MULTIPLY"
    product.inputs[1].default_value = -4.0
    tree.links.new(picture.outputs["Color"], tint.inputs["Color"])
    tree.links.new(picture.outputs["Color"], apart.inputs["Color"])
    tree.links.new(apart.outputs["Green"], product.inputs[0])
    tree.links.new(product.outputs["Value"], number.inputs["Value"])
    add_mesh(bpy, "Floor", SQUARE, floor, uv=True).scale = (3.0, 1.0, 1.0)
    plain = "ShaderNodeBsdfPrincipled"
    kinds = (
        ("Thin", plain, {"Alpha": 0.3}), ("Thick", plain, {"Alpha": 0.7}),
        ("Glass", "ShaderNodeBsdfGlass", {"Roughness": 0.0}), ("Bare", plain, {}),
        ("Mirror", "ShaderNodeBsdfGlossy", {"Roughness": 0.0}),
    )  # fmt: skip
    for k, (name, node, values) in enumerate(kinds):
        material = new_material(bpy, name, node, **values)
        if name not in ("Glass", "Bare"):
            add_output(material.node_tree, "tint", Color=(0.9, 0.1 * k, 0.3, 0.5))
            add_output(material.node_tree, "number", Value=7.0 - k)
        sheet = add_mesh(bpy, name, SQUARE, material)
        sheet.location, sheet.scale = (1.1 * (k - 2), 0.0, 1.0), (0.4, 0.5, 1.0)
    inside_group(bpy)
    held = new_material(bpy, "Held", "ShaderNodeBsdfDiffuse")
    add_output(held.node_tree, "tint", Color=(0.6, 0.7, 0.8, 1.0))
    hole = add_mesh(bpy, "Held", SQUARE, held)
    hole.location, hole.scale, hole.is_holdout = (0.0, -0.85, 0.5), (3.0, 0.1, 1.0), True
    world = new_world(bpy)
    add_output(world.node_tree, "number", Value=3.0)
    for name, kind in (("tint", "COLOR"), ("number", "VALUE"), ("nobody's", "COLOR")):
        add_aov(bpy, name, kind)


def new_world(bpy: Any) -> Any:
    world = bpy.data.worlds.new("Sky")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    bpy.context.scene.world = world
    return world


def inside_group(bpy: Any) -> None:
    """A material whose value comes through the input of a group that has the output node."""
    group = bpy.data.node_groups.new("Tells", "ShaderNodeTree")
    group.interface.new_socket("Told", in_out="INPUT", socket_type="NodeSocketColor")
    entry = group.nodes.new("NodeGroupInput")
    output = add_output(group, "tint")
    group.links.new(entry.outputs["Told"], output.inputs["Color"])
    material = new_material(bpy, "Grouped", "ShaderNodeBsdfDiffuse")
    node = material.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.inputs["Told"].default_value = (0.25, 0.5, 0.75, 1.0)
    sheet = add_mesh(bpy, "Grouped", SQUARE, material)
    sheet.location, sheet.scale = (0.0, 0.8, 0.5), (3.0, 0.2, 1.0)


def rendered(bpy: Any, engine: str, folder: Path) -> dict[str, np.ndarray]:
    bpy.context.scene.render.engine = engine
    save_exr(bpy, folder / f"{engine}.exr")
    headless_render(bpy)
    return {k.split(".")[1]: v for k, v in read_exr(folder / f"{engine}.exr").items()}


def test_they_are_those_of_cycles(bpy: Any, tmp_path: Path) -> None:
    import addon_utils

    build(bpy)
    addon_utils.enable("cycles")
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.use_denoising = 256, False
    scene.cycles.use_adaptive_sampling = False
    scene.photon_map.passes = 64
    cycles, ours = (rendered(bpy, engine, tmp_path) for engine in ("CYCLES", "PHOTONMAP"))
    for name, channels in (("tint", 4), ("number", 1), ("nobody's", 4)):
        assert ours[name].shape == cycles[name].shape == (20, 64, channels)
        gap = np.abs(ours[name] - cycles[name]).max(axis=2)
        # Both are means over places of a pixel: they differ by noise at the edges of things,
        # and Cycles' by that of its choice to go through the thin veil or not.
        assert np.percentile(gap, 75) < 0.02 * max(1.0, np.abs(cycles[name]).max())
        assert ours[name].mean() == pytest.approx(cycles[name].mean(), rel=0.01, abs=1e-6)
    assert np.ptp(ours["tint"][..., 0]) > 0.8
    assert ours["number"].min() < -2.0 and ours["number"].max() > 5.0
    # What is behind the thin veil adds up with it, in both.
    assert ours["tint"][..., 3].max() == pytest.approx(1.7, abs=0.01)
    assert cycles["tint"][..., 3].max() == pytest.approx(1.7, abs=0.12)


def test_what_cannot_be_read_is_the_inputs_own_with_one_warning(bpy: Any) -> None:
    add_camera(bpy)
    material = new_material(bpy, "Wood", "ShaderNodeBsdfDiffuse")
    noise = material.node_tree.nodes.new("ShaderNodeTexNoise")
    output = add_output(material.node_tree, "tint", Color=(0.1, 0.2, 0.3, 1.0))
    material.node_tree.links.new(noise.outputs["Color"], output.inputs["Color"])
    add_output(material.node_tree, "unlisted", Value=3.0)
    for k in range(2):
        add_mesh(bpy, f"Plank {k}", SQUARE, material)
    before = export(bpy)
    assert (before.warnings, before.scene.aov_names) == ((), ())
    add_aov(bpy, "tint", "COLOR")
    exported = export(bpy)
    assert exported.settings.aovs == ("tint",)
    assert exported.scene.aov_names == ("tint",)
    assert exported.scene.aovs["param"]["value"][0, 0] == pytest.approx([0.1, 0.2, 0.3])
    assert len(exported.warnings) == 1
    assert "material 'Wood': node 'Noise Texture' at input 'Color'" in exported.warnings[0]


def test_two_outputs_of_one_name_and_a_picture_of_the_world_are_told(bpy: Any) -> None:
    add_camera(bpy)
    material = new_material(bpy, "Twice", "ShaderNodeBsdfDiffuse")
    for value in (1.0, 2.0):
        add_output(material.node_tree, "number", Value=value)
    add_mesh(bpy, "Sheet", SQUARE, material)
    world = new_world(bpy)
    sky = add_output(world.node_tree, "number", Value=1.5)
    picture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    world.node_tree.links.new(picture.outputs["Color"], sky.inputs["Value"])
    add_aov(bpy, "number", "VALUE")
    exported = export(bpy)
    assert exported.scene.aovs["param"]["value"][0, 0, 0] == 1.0
    assert exported.scene.world_aovs["param"]["value"][0, 0] == 1.5
    assert sorted(exported.warnings) == [
        "material 'Twice' has several outputs for AOV 'number', the first one counts",
        "world 'Sky': node 'Environment Texture' at input 'Value' of 'AOV Output' is not "
        "supported yet; the input's own value is used",
    ]
