"""The world: one colour, or a picture all around."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tests.blender.support import add_camera, export


def set_world(bpy: Any) -> Any:
    world = bpy.data.worlds.new("W")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    bpy.context.scene.world = world
    return world


def test_world_background(bpy: Any) -> None:
    add_camera(bpy)
    world = set_world(bpy)
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    background.inputs["Strength"].default_value = 10.0
    got = export(bpy)
    assert got.scene.world == pytest.approx([1.0, 2.0, 3.0])
    assert got.warnings == ()
    bpy.context.scene.world = None
    assert not export(bpy).scene.world.any()


def test_world_texture_warns(bpy: Any) -> None:
    add_camera(bpy)
    world = set_world(bpy)
    tree = world.node_tree
    sky = tree.nodes.new("ShaderNodeTexChecker")
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])
    got = export(bpy)
    assert len(got.warnings) == 1
    assert "world 'W'" in got.warnings[0]


def test_world_without_nodes(bpy: Any) -> None:
    if bpy.app.version >= (5, 0, 0):
        pytest.skip("worlds always have nodes from 5.0 on")
    add_camera(bpy)
    world = set_world(bpy)
    world.use_nodes = False
    world.color = (0.1, 0.2, 0.3)
    assert export(bpy).scene.world == pytest.approx([0.1, 0.2, 0.3])


def add_picture(bpy: Any, strength: float = 2.0, **values: Any) -> tuple[Any, np.ndarray]:
    """An environment texture of 16 x 8 random texels before the background."""
    world = set_world(bpy)
    tree = world.node_tree
    image = bpy.data.images.new("Sky", 16, 8, float_buffer=True)
    texels = np.random.default_rng(1).random((8, 16, 4)).astype(np.float32)
    image.pixels.foreach_set(texels.ravel())
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    for name, value in values.items():
        setattr(node, name, value)
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = strength
    tree.links.new(node.outputs["Color"], background.inputs["Color"])
    return node, texels[..., :3]


def add_mapping(node: Any, kind: str = "POINT", **values: Any) -> None:
    tree = node.id_data
    mapping, source = tree.nodes.new("ShaderNodeMapping"), tree.nodes.new("ShaderNodeTexCoord")
    mapping.vector_type = kind
    for name, value in values.items():
        mapping.inputs[name].default_value = value
    tree.links.new(source.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], node.inputs["Vector"])


def test_environment_texture(bpy: Any) -> None:
    add_camera(bpy)
    _, texels = add_picture(bpy)
    got = export(bpy)
    assert all("no faces" in text or "no light" in text for text in got.warnings)
    assert got.scene.world == pytest.approx([2.0] * 3)
    np.testing.assert_allclose(got.scene.world_map, texels, rtol=1e-6)
    assert got.scene.world_rotation == pytest.approx(np.eye(3))


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE"])
def test_a_turned_environment(bpy: Any, kind: str) -> None:
    add_camera(bpy)
    node, texels = add_picture(bpy)
    add_mapping(node, kind, Rotation=(0.0, 0.0, 0.5))
    got = export(bpy).scene
    c, s = math.cos(0.5), math.sin(0.5) * (1 if kind == "POINT" else -1)
    expected = np.array([(c, -s, 0), (s, c, 0), (0, 0, 1)])
    assert got.world_rotation == pytest.approx(expected, abs=1e-6)
    np.testing.assert_allclose(got.world_map, texels, rtol=1e-6)


def test_what_is_no_turn_is_drawn_anew(bpy: Any) -> None:
    add_camera(bpy)
    node, texels = add_picture(bpy)
    add_mapping(node, Scale=(1.0, 2.0, 1.0))
    got = export(bpy).scene
    assert got.world_map.shape == (256, 512, 3)
    assert got.world_rotation == pytest.approx(np.eye(3))
    # Along +x, where the stretch does nothing, in the middle of the picture.
    np.testing.assert_allclose(
        got.world_map[128, 256], texels[3:5, 7:9].mean(axis=(0, 1)), atol=0.02
    )
    node.projection = "MIRROR_BALL"
    assert export(bpy).scene.world_map.shape == (256, 512, 3)


def test_byte_pictures_are_made_linear(bpy: Any) -> None:
    add_camera(bpy)
    node, _ = add_picture(bpy)
    node.image = bpy.data.images.new("Bytes", 4, 2)
    node.image.pixels.foreach_set(np.full(32, 0.5, np.float32))
    value = export(bpy).scene.world_map[0, 0, 0]
    assert value == pytest.approx(((round(0.5 * 255) / 255 + 0.055) / 1.055) ** 2.4, rel=1e-3)


def test_a_missing_picture_is_magenta(bpy: Any) -> None:
    add_camera(bpy)
    node, _ = add_picture(bpy)
    node.image = None
    got = export(bpy)
    assert got.scene.world == pytest.approx([2.0, 0.0, 2.0])
    assert "world 'W'" in got.warnings[0] and "missing" in got.warnings[0]


def test_mixed_with_a_colour(bpy: Any) -> None:
    add_camera(bpy)
    node, texels = add_picture(bpy)
    tree = node.id_data
    mix, flat = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBackground")
    flat.inputs["Color"].default_value = (0.5, 0.5, 1.0, 1.0)
    mix.inputs[0].default_value = 0.25
    output = tree.get_output_node("CYCLES")
    tree.links.new(tree.nodes["Background"].outputs[0], mix.inputs[1])
    tree.links.new(flat.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    got = export(bpy).scene
    expected = 0.75 * 2.0 * texels + 0.25 * np.array([0.5, 0.5, 1.0])
    np.testing.assert_allclose(got.world * got.world_map, expected, rtol=1e-5)
