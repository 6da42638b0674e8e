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
    material, _ = linked(bpy, "ShaderNodeTexMagic")
    for name in "ABC":
        add_cube(bpy, name, material)
    got = export(bpy)
    assert colors(got) == [[0.8, 0.2, 0.1]]
    assert len(got.warnings) == 1
    assert "material 'M'" in got.warnings[0]
    assert "Magic Texture" in got.warnings[0]


def test_a_texture_at_two_inputs_warns_once(bpy: Any) -> None:
    add_camera(bpy)
    material, texture = linked(bpy, "ShaderNodeTexMagic")
    shader = material.node_tree.nodes["Diffuse BSDF"]
    material.node_tree.links.new(texture.outputs[0], shader.inputs["Normal"])
    add_cube(bpy, "Cube", material)
    assert len(export(bpy).warnings) == 1


def test_a_bump_map_of_a_pattern_warns(bpy: Any) -> None:
    add_camera(bpy)
    material = new_material(bpy, "M", "ShaderNodeBsdfGlass", Roughness=0.0)
    tree = material.node_tree
    bump, pattern = tree.nodes.new("ShaderNodeBump"), tree.nodes.new("ShaderNodeTexChecker")
    tree.links.new(bump.outputs[0], tree.nodes["Glass BSDF"].inputs["Normal"])
    add_cube(bpy, "Cube", material)
    assert export(bpy).warnings == (), "a constant height is flat"
    tree.links.new(pattern.outputs["Fac"], bump.inputs["Height"])
    (warning,) = export(bpy).warnings
    assert "'Checker Texture'" in warning
    assert "'Height'" in warning


def group_of(bpy: Any, name: str, *, color: tuple[float, ...]) -> Any:
    """A node group with the input Tint and a diffuse shader of that colour."""
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    tree.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    tree.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = color
    tree.links.new(start.outputs["Tint"], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], end.inputs["Shader"])
    return tree


def test_groups_are_followed_in_and_out(bpy: Any) -> None:
    """One group twice: each use has its own colour, linked or typed in."""
    add_camera(bpy)
    inner = group_of(bpy, "Inner", color=RED)
    material = new_material(bpy, "M")
    tree = material.node_tree
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.inputs[0].default_value = 0.25
    rgb = tree.nodes.new("ShaderNodeRGB")
    rgb.outputs[0].default_value = (0.0, 1.0, 0.0, 1.0)
    for place in (1, 2):
        group = tree.nodes.new("ShaderNodeGroup")
        group.node_tree = inner
        group.inputs["Tint"].default_value = (1.0, 0.0, 0.0, 1.0)
        tree.links.new(group.outputs[0], mix.inputs[place])
    tree.links.new(rgb.outputs[0], group.inputs["Tint"])
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    add_cube(bpy, "Cube", material)
    got = export(bpy)
    assert colors(got) == [[0.75, 0.25, 0.0]]
    assert got.warnings == ()


def test_a_group_in_a_group(bpy: Any) -> None:
    add_camera(bpy)
    inner = group_of(bpy, "Inner", color=RED)
    outer = bpy.data.node_groups.new("Outer", "ShaderNodeTree")
    outer.interface.new_socket("Paint", in_out="INPUT", socket_type="NodeSocketColor")
    outer.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    start, end = outer.nodes.new("NodeGroupInput"), outer.nodes.new("NodeGroupOutput")
    group = outer.nodes.new("ShaderNodeGroup")
    group.node_tree = inner
    outer.links.new(start.outputs["Paint"], group.inputs["Tint"])
    outer.links.new(group.outputs[0], end.inputs["Shader"])
    material = new_material(bpy, "M")
    tree = material.node_tree
    use = tree.nodes.new("ShaderNodeGroup")
    use.node_tree = outer
    use.inputs["Paint"].default_value = (0.25, 0.5, 0.75, 1.0)
    tree.links.new(use.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    add_cube(bpy, "Cube", material)
    assert colors(export(bpy)) == [[0.25, 0.5, 0.75]]


def test_muted_nodes_are_passed_through(bpy: Any) -> None:
    add_camera(bpy)
    material, gamma = linked(bpy, "ShaderNodeGamma")
    gamma.inputs["Color"].default_value = (0.5, 0.6, 0.7, 1.0)
    gamma.mute = True
    add_cube(bpy, "Cube", material)
    got = export(bpy)
    assert colors(got) == [[0.5, 0.6, 0.7]]
    assert got.warnings == ()


def test_a_checker_is_the_mean_of_its_colours(bpy: Any) -> None:
    add_camera(bpy)
    material = new_material(bpy, "Squares", "ShaderNodeBsdfDiffuse")
    tree = material.node_tree
    checker = tree.nodes.new("ShaderNodeTexChecker")
    checker.inputs["Color1"].default_value = (0.2, 0.4, 0.6, 1)
    checker.inputs["Color2"].default_value = (0.4, 0.0, 0.2, 1)
    shader = next(node for node in tree.nodes if node.type == "BSDF_DIFFUSE")
    tree.links.new(checker.outputs["Color"], shader.inputs["Color"])
    add_cube(bpy, "Cube", material)
    got = export(bpy)
    assert got.lobes_of("Squares")[0]["weight"] == pytest.approx((0.3, 0.2, 0.4))
    assert len(got.warnings) == 1 and "mean of its colours" in got.warnings[0]
