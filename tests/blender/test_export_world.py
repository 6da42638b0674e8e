"""The world's uniform radiance."""

from __future__ import annotations

from typing import Any

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
