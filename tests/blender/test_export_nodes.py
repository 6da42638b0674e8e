"""Links between nodes: constants are followed, everything else warns once."""

from __future__ import annotations

from typing import Any

import pytest

from tests.blender.support import Exported, add_camera, add_cube, export, new_material

DIFFUSE = 0
RED = (0.8, 0.2, 0.1, 1.0)


def colors(got: Exported) -> list[list[float]]:
    """Weights of the diffuse lobes of material M."""
    lobes = got.lobes_of("M")
    assert all(lobe["model"] == DIFFUSE for lobe in lobes)
    return [[round(float(v), 5) for v in lobe["weight"]] for lobe in lobes]


def linked(bpy: Any, node: str, output: int | str = 0, through_reroute: bool = False) -> Any:
    """Material M: a diffuse shader whose colour is linked to a new ``node``."""
    material = new_material(bpy, "M", "ShaderNodeBsdfDiffuse", Color=RED)
    tree = material.node_tree
    source = tree.nodes.new(node)
    socket = source.outputs[output]
    if through_reroute:
        for _ in range(2):
            reroute = tree.nodes.new("NodeReroute")
            tree.links.new(socket, reroute.inputs[0])
            socket = reroute.outputs[0]
    tree.links.new(socket, tree.nodes["Diffuse BSDF"].inputs["Color"])
    return material, source


@pytest.mark.parametrize("through_reroute", [False, True])
def test_rgb_node_is_a_constant(bpy: Any, through_reroute: bool) -> None:
    add_camera(bpy)
    material, rgb = linked(bpy, "ShaderNodeRGB", through_reroute=through_reroute)
    rgb.outputs[0].default_value = (0.1, 0.2, 0.3, 1.0)
    add_cube(bpy, "Cube", material)
    got = export(bpy)
    assert colors(got) == [[0.1, 0.2, 0.3]]
    assert got.warnings == ()


def test_value_node_at_a_colour_is_grey(bpy: Any) -> None:
    add_camera(bpy)
    material, value = linked(bpy, "ShaderNodeValue")
    value.outputs[0].default_value = 0.25
    add_cube(bpy, "Cube", material)
    assert colors(export(bpy)) == [[0.25] * 3]


def test_texture_warns_once_and_the_inputs_value_is_used(bpy: Any) -> None:
    add_camera(bpy)
    material, _ = linked(bpy, "ShaderNodeTexChecker")
    for name in "ABC":
        add_cube(bpy, name, material)
    got = export(bpy)
    assert colors(got) == [[0.8, 0.2, 0.1]]
    assert len(got.warnings) == 1
    assert "material 'M'" in got.warnings[0]
    assert "Checker Texture" in got.warnings[0]


def test_a_texture_at_two_inputs_warns_once(bpy: Any) -> None:
    add_camera(bpy)
    material, texture = linked(bpy, "ShaderNodeTexChecker")
    shader = material.node_tree.nodes["Diffuse BSDF"]
    material.node_tree.links.new(texture.outputs[0], shader.inputs["Normal"])
    add_cube(bpy, "Cube", material)
    assert len(export(bpy).warnings) == 1


def test_a_bump_map_warns(bpy: Any) -> None:
    add_camera(bpy)
    material = new_material(bpy, "M", "ShaderNodeBsdfGlass", Roughness=0.0)
    tree = material.node_tree
    bump = tree.nodes.new("ShaderNodeBump")
    tree.links.new(bump.outputs[0], tree.nodes["Glass BSDF"].inputs["Normal"])
    add_cube(bpy, "Cube", material)
    (warning,) = export(bpy).warnings
    assert "'Bump'" in warning
    assert "'Normal'" in warning


def test_muted_nodes_are_passed_through(bpy: Any) -> None:
    add_camera(bpy)
    material, gamma = linked(bpy, "ShaderNodeGamma")
    gamma.inputs["Color"].default_value = (0.5, 0.6, 0.7, 1.0)
    gamma.mute = True
    add_cube(bpy, "Cube", material)
    got = export(bpy)
    assert colors(got) == [[0.5, 0.6, 0.7]]
    assert got.warnings == ()
