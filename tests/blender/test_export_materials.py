"""Shader nodes to lobes: every supported node, and a warning for every other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from photon_map.core.scene.tables import ClosureKind, Model
from tests.blender.support import Exported, add_camera, add_cube, export, new_material

DIFFUSE, PHONG, CONDUCTOR, DIELECTRIC, REFRACTION = range(5)
RED = (0.8, 0.2, 0.1, 1.0)


def exported_material(bpy: Any, node: str, **inputs: Any) -> Exported:
    add_camera(bpy)
    add_cube(bpy, "Cube", new_material(bpy, "M", node, **inputs))
    return export(bpy)


def lobes(got: Exported) -> list[tuple[int, list[float]]]:
    return [(int(b["model"]), np.round(b["weight"], 5).tolist()) for b in got.lobes_of("M")]


def test_diffuse(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfDiffuse", Color=RED)
    assert lobes(got) == [(DIFFUSE, [0.8, 0.2, 0.1])]
    assert got.warnings == ()


def test_smooth_glossy_is_a_mirror(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfGlossy", Color=RED, Roughness=0.0)
    assert lobes(got) == [(CONDUCTOR, [0.8, 0.2, 0.1])]
    assert got.warnings == ()


def test_rough_glossy_is_worked_out_at_the_hit(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfGlossy", Color=RED, Roughness=0.3)
    (row,) = got.closures_of("M")
    assert lobes(got) == []
    assert row["kind"] == ClosureKind.GLOSSY
    assert row["color"]["value"] == pytest.approx(RED[:3])
    assert row["roughness"]["value"][0] == pytest.approx(0.3)
    assert row["distribution"] == 1
    assert got.warnings == ()


def test_the_threshold_of_smoothness(bpy: Any) -> None:
    add_camera(bpy)
    for node, model in (("Glossy", CONDUCTOR), ("Glass", DIELECTRIC)):
        sharp = new_material(bpy, f"Sharp{node}", f"ShaderNodeBsdf{node}", Roughness=0.009)
        rough = new_material(bpy, f"Rough{node}", f"ShaderNodeBsdf{node}", Roughness=0.011)
        add_cube(bpy, sharp.name, sharp)
        add_cube(bpy, rough.name, rough)
        got = export(bpy)
        assert got.lobes_of(f"Sharp{node}")[0]["model"] == model
        assert not got.closures_of(f"Sharp{node}")
        assert not got.lobes_of(f"Rough{node}")
        assert len(got.closures_of(f"Rough{node}")) == 1


def test_glass(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfGlass", Color=RED, Roughness=0.0, IOR=1.52)
    (lobe,) = got.lobes_of("M")
    assert lobe["model"] == DIELECTRIC
    assert lobe["ior"] == pytest.approx(1.52)
    assert lobe["weight"] == pytest.approx([0.8, 0.2, 0.1])
    assert got.warnings == ()


def test_rough_glass_knows_its_medium(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfGlass", Roughness=0.4, IOR=1.4)
    (row,) = got.closures_of("M")
    assert row["kind"] == ClosureKind.GLASS
    assert row["ior"] == pytest.approx(1.4)
    assert got.material("M")["ior"] == pytest.approx(1.4)
    assert got.warnings == ()


def test_refraction(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfRefraction", Color=RED, Roughness=0.0, IOR=1.3)
    (lobe,) = got.lobes_of("M")
    assert lobe["model"] == REFRACTION
    assert lobe["ior"] == pytest.approx(1.3)


def test_emission(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeEmission", Color=RED, Strength=5.0)
    assert lobes(got) == []
    assert got.emission_of("M") == pytest.approx([4.0, 1.0, 0.5])


def test_negative_emission_is_none(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeEmission", Strength=-1.0)
    assert not got.emission_of("M").any()
    assert "negative" in got.warnings[0]


@pytest.mark.parametrize(
    ("node", "kind", "values"),
    [
        ("ShaderNodeBsdfDiffuse", ClosureKind.DIFFUSE, {"Roughness": 0.5}),
        ("ShaderNodeBsdfRefraction", ClosureKind.REFRACTION, {"Roughness": 0.5}),
        ("ShaderNodeBsdfSheen", ClosureKind.SHEEN, {}),
    ],
)
def test_nodes_that_become_closures(
    bpy: Any, node: str, kind: ClosureKind, values: dict[str, float]
) -> None:
    got = exported_material(bpy, node, Color=RED, **values)
    (row,) = got.closures_of("M")
    assert row["kind"] == kind
    assert row["color"]["value"] == pytest.approx(RED[:3])
    assert row["roughness"]["value"][0] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("node", "model"), [("Transparent", Model.TRANSPARENT), ("Translucent", Model.TRANSLUCENT)]
)
def test_nodes_that_become_lobes(bpy: Any, node: str, model: Model) -> None:
    got = exported_material(bpy, f"ShaderNodeBsdf{node}", Color=RED)
    assert lobes(got) == [(model, [0.8, 0.2, 0.1])]
    assert got.material("M")["passes"] == (model == Model.TRANSPARENT)
    assert got.warnings == ()


def test_metal_by_its_colours_and_by_its_index(bpy: Any) -> None:
    if bpy.app.version < (5, 0, 0):
        pytest.skip("there is no Metallic BSDF yet")
    got = exported_material(
        bpy, "ShaderNodeBsdfMetallic", Base_Color=RED, Edge_Tint=(0.5, 0.25, 1.0, 1.0)
    )
    (row,) = got.closures_of("M")
    assert row["kind"] == ClosureKind.METALLIC
    assert row["color"]["value"] == pytest.approx(RED[:3])
    assert row["specular_tint"] == pytest.approx([0.5, 0.25, 1.0])
    node = bpy.data.materials["M"].node_tree.nodes["Metallic BSDF"]
    node.fresnel_type = "PHYSICAL_CONDUCTOR"
    node.inputs["IOR"].default_value = (1.5, 0.2, 1.0)
    node.inputs["Extinction"].default_value = (0.0, 3.9, 0.0)
    (row,) = export(bpy).closures_of("M")
    silver = ((0.2 - 1) ** 2 + 3.9**2) / ((0.2 + 1) ** 2 + 3.9**2)
    assert row["color"]["value"] == pytest.approx([0.04, silver, 0.0], abs=1e-6)


def mixed(bpy: Any, kind: str, *shaders: tuple[str, dict[str, Any]]) -> Any:
    """Material M: ``kind`` of the shaders; returns the material and the mixing node."""
    material = new_material(bpy, "M")
    tree = material.node_tree
    mix = tree.nodes.new(kind)
    sockets = [socket for socket in mix.inputs if socket.type == "SHADER"]
    for (node, inputs), socket in zip(shaders, sockets, strict=True):
        shader = tree.nodes.new(node)
        for key, value in inputs.items():
            shader.inputs[key].default_value = value
        tree.links.new(shader.outputs[0], socket)
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    return material, mix


WHITE_DIFFUSE = ("ShaderNodeBsdfDiffuse", {"Color": (1.0, 1.0, 1.0, 1.0)})
MIRROR = ("ShaderNodeBsdfGlossy", {"Color": (1.0, 1.0, 1.0, 1.0), "Roughness": 0.0})


def test_mix_shader(bpy: Any) -> None:
    add_camera(bpy)
    material, mix = mixed(bpy, "ShaderNodeMixShader", WHITE_DIFFUSE, MIRROR)
    mix.inputs[0].default_value = 0.25
    add_cube(bpy, "Cube", material)
    assert lobes(export(bpy)) == [(DIFFUSE, [0.75] * 3), (CONDUCTOR, [0.25] * 3)]


def test_mix_with_emission_and_with_nothing(bpy: Any) -> None:
    add_camera(bpy)
    glow = ("ShaderNodeEmission", {"Strength": 8.0})
    material, mix = mixed(bpy, "ShaderNodeMixShader", glow, WHITE_DIFFUSE)
    material.node_tree.links.remove(mix.inputs[2].links[0])
    mix.inputs[0].default_value = 0.25
    add_cube(bpy, "Cube", material)
    got = export(bpy)
    assert lobes(got) == []
    assert got.emission_of("M") == pytest.approx([6.0] * 3)


def test_add_shader(bpy: Any) -> None:
    add_camera(bpy)
    glow = ("ShaderNodeEmission", {"Strength": 2.0})
    material, _ = mixed(bpy, "ShaderNodeAddShader", WHITE_DIFFUSE, glow)
    add_cube(bpy, "Cube", material)
    got = export(bpy)
    assert lobes(got) == [(DIFFUSE, [1.0] * 3)]
    assert got.emission_of("M") == pytest.approx([2.0] * 3)


def test_nested_mixes_of_one_node_stay_small(bpy: Any) -> None:
    """40 mixes of a node with itself are one lobe, not 2^40."""
    add_camera(bpy)
    material, mix = mixed(bpy, "ShaderNodeMixShader", WHITE_DIFFUSE, WHITE_DIFFUSE)
    tree = material.node_tree
    for _ in range(40):
        outer = tree.nodes.new("ShaderNodeMixShader")
        tree.links.new(mix.outputs[0], outer.inputs[1])
        tree.links.new(mix.outputs[0], outer.inputs[2])
        mix = outer
    tree.links.new(mix.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    add_cube(bpy, "Cube", material)
    assert lobes(export(bpy)) == [(DIFFUSE, [1.0] * 3)]


def test_unsupported_shader_is_grey_and_named_once(bpy: Any) -> None:
    add_camera(bpy)
    toon = new_material(bpy, "M", "ShaderNodeBsdfToon")
    for name in "AB":
        add_cube(bpy, name, toon)
    got = export(bpy)
    assert lobes(got) == [(DIFFUSE, [0.8] * 3)]
    assert len(got.warnings) == 1
    assert "material 'M'" in got.warnings[0]
    assert "Toon BSDF" in got.warnings[0]


def test_an_output_without_surface_is_black(bpy: Any) -> None:
    add_camera(bpy)
    add_cube(bpy, "Cube", new_material(bpy, "M"))
    got = export(bpy)
    assert lobes(got) == []
    assert not got.emission_of("M").any()


def test_the_active_output_counts(bpy: Any) -> None:
    add_camera(bpy)
    material = new_material(bpy, "M", "ShaderNodeBsdfDiffuse", Color=RED)
    tree = material.node_tree
    second = tree.nodes.new("ShaderNodeOutputMaterial")
    mirror = tree.nodes.new("ShaderNodeBsdfGlossy")
    mirror.inputs["Roughness"].default_value = 0.0
    tree.links.new(mirror.outputs[0], second.inputs["Surface"])
    second.is_active_output = True
    add_cube(bpy, "Cube", material)
    assert lobes(export(bpy))[0][0] == CONDUCTOR


def test_volume_and_displacement_warn(bpy: Any) -> None:
    add_camera(bpy)
    material = new_material(bpy, "M", "ShaderNodeBsdfDiffuse")
    tree = material.node_tree
    output = tree.nodes["Material Output"]
    tree.links.new(
        tree.nodes.new("ShaderNodeVolumeAbsorption").outputs[0], output.inputs["Volume"]
    )
    tree.links.new(
        tree.nodes.new("ShaderNodeDisplacement").outputs[0], output.inputs["Displacement"]
    )
    add_cube(bpy, "Cube", material)
    warnings = export(bpy).warnings
    assert [("volume" in w, "displacement" in w) for w in warnings] == [
        (False, True),
        (True, False),
    ]


def test_absorption_inside_glass(bpy: Any) -> None:
    """The volume's coefficient is (1 - colour) x density, as in Cycles."""
    add_camera(bpy)
    material = new_material(bpy, "M", "ShaderNodeBsdfGlass", Roughness=0.0)
    tree = material.node_tree
    volume = tree.nodes.new("ShaderNodeVolumeAbsorption")
    volume.inputs["Color"].default_value = (0.9, 0.5, 1.0, 1.0)
    volume.inputs["Density"].default_value = 20.0
    output = tree.nodes["Material Output"]
    tree.links.new(volume.outputs[0], output.inputs["Volume"])
    add_cube(bpy, "Cube", material)
    got = export(bpy)
    assert got.material("M")["absorption"] == pytest.approx([2.0, 10.0, 0.0], abs=1e-5)
    assert got.warnings == ()
    added = tree.nodes.new("ShaderNodeAddShader")
    for socket in added.inputs:
        tree.links.new(volume.outputs[0], socket)
    tree.links.new(added.outputs[0], output.inputs["Volume"])
    assert export(bpy).material("M")["absorption"] == pytest.approx([4, 20, 0], abs=1e-5)
    fog = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(fog.outputs[0], output.inputs["Volume"])
    got = export(bpy)
    assert not got.material("M")["absorption"].any()
    assert "Volume Scatter" in got.warnings[0]


def test_priority_of_overlapping_bodies(bpy: Any) -> None:
    add_camera(bpy)
    material = new_material(bpy, "M", "ShaderNodeBsdfGlass", Roughness=0.0)
    add_cube(bpy, "Cube", material)
    assert export(bpy).material("M")["priority"] == 0
    material.photon_map.priority = 3
    assert export(bpy).material("M")["priority"] == 3


def test_a_rough_mix_keeps_its_factors(bpy: Any) -> None:
    add_camera(bpy)
    rough = ("ShaderNodeBsdfGlossy", {"Roughness": 0.5})
    material, mix = mixed(bpy, "ShaderNodeMixShader", WHITE_DIFFUSE, rough)
    mix.inputs[0].default_value = 0.25
    add_cube(bpy, "Cube", material)
    first, second = export(bpy).closures_of("M")
    assert [first["kind"], second["kind"]] == [ClosureKind.DIFFUSE, ClosureKind.GLOSSY]
    for row, weight in ((first, 0.75), (second, 0.25)):
        assert row["factor_count"] == 1
        assert row["factors"][0]["param"]["value"][0] == weight


def test_without_nodes_the_viewport_colour_counts(bpy: Any) -> None:
    if bpy.app.version >= (5, 0, 0):
        pytest.skip("materials always have nodes from 5.0 on")
    add_camera(bpy)
    material = bpy.data.materials.new("M")
    material.diffuse_color = RED
    add_cube(bpy, "Cube", material)
    assert lobes(export(bpy)) == [(DIFFUSE, [0.8, 0.2, 0.1])]


def test_a_colour_above_one_is_limited(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfDiffuse", Color=(2.0, 0.5, -1.0, 1.0))
    assert lobes(got) == [(DIFFUSE, [1.0, 0.5, 0.0])]
    assert len(got.warnings) == 1
