"""Shader nodes to lobes: every supported node, and a warning for every other."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

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


def test_rough_glossy_is_a_phong_lobe_with_a_warning(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfGlossy", Color=RED, Roughness=0.3)
    (lobe,) = got.lobes_of("M")
    assert lobe["model"] == PHONG
    assert lobe["exponent"] == pytest.approx(2 / 0.3**4 - 2, rel=1e-5)
    assert len(got.warnings) == 1
    assert "'M'" in got.warnings[0]


def test_the_threshold_of_smoothness(bpy: Any) -> None:
    add_camera(bpy)
    smooth = new_material(bpy, "Smooth", "ShaderNodeBsdfGlossy", Roughness=0.029)
    rough = new_material(bpy, "Rough", "ShaderNodeBsdfGlossy", Roughness=0.031)
    full = new_material(bpy, "Full", "ShaderNodeBsdfGlossy", Roughness=1.0)
    for material in (smooth, rough, full):
        add_cube(bpy, material.name, material)
    got = export(bpy)
    assert got.lobes_of("Smooth")[0]["model"] == CONDUCTOR
    assert got.lobes_of("Rough")[0]["model"] == PHONG
    assert got.lobes_of("Full")[0]["exponent"] == 0.0


def test_glass(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfGlass", Color=RED, Roughness=0.0, IOR=1.52)
    (lobe,) = got.lobes_of("M")
    assert lobe["model"] == DIELECTRIC
    assert lobe["ior"] == pytest.approx(1.52)
    assert lobe["weight"] == pytest.approx([0.8, 0.2, 0.1])
    assert got.warnings == ()


def test_rough_glass_is_smooth_with_a_warning(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfGlass", Roughness=0.4)
    assert [model for model, _ in lobes(got)] == [DIELECTRIC]
    assert got.warnings == ("rough glass is rendered smooth in: material 'M'",)


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


def test_principled_dielectric(bpy: Any) -> None:
    got = exported_material(
        bpy, "ShaderNodeBsdfPrincipled", Base_Color=RED, Roughness=0.0, IOR=1.5
    )
    f0 = 0.04
    (model_a, weight_a), (model_b, weight_b) = lobes(got)
    assert (model_a, model_b) == (DIFFUSE, CONDUCTOR)
    assert weight_a == pytest.approx(np.array(RED[:3]) * (1 - f0), abs=1e-4)
    assert weight_b == pytest.approx([f0] * 3, abs=1e-4)
    assert got.warnings == ()


def test_principled_specular_level_and_tint(bpy: Any) -> None:
    got = exported_material(
        bpy,
        "ShaderNodeBsdfPrincipled",
        Roughness=0.0,
        IOR=1.5,
        Specular_IOR_Level=1.0,
        Specular_Tint=(1.0, 0.5, 0.0, 1.0),
    )
    assert lobes(got)[1][1] == pytest.approx([0.08, 0.04, 0.0], abs=1e-4)
    none = new_material(
        bpy, "None", "ShaderNodeBsdfPrincipled", Specular_IOR_Level=0.0, Base_Color=RED
    )
    bpy.data.objects["Cube"].data.materials[0] = none
    got = export(bpy)
    (lobe,) = got.lobes_of("None")
    assert lobe["weight"] == pytest.approx(RED[:3])


def test_principled_metal(bpy: Any) -> None:
    got = exported_material(
        bpy, "ShaderNodeBsdfPrincipled", Base_Color=RED, Metallic=1.0, Roughness=0.0
    )
    assert lobes(got) == [(CONDUCTOR, [0.8, 0.2, 0.1])]


def test_principled_glass(bpy: Any) -> None:
    """The base colour is that of a body of two surfaces, as in Cycles."""
    got = exported_material(
        bpy,
        "ShaderNodeBsdfPrincipled",
        Base_Color=RED,
        Transmission_Weight=1.0,
        Roughness=0.0,
        IOR=1.4,
    )
    (lobe,) = got.lobes_of("M")
    assert lobe["model"] == DIELECTRIC
    assert lobe["ior"] == pytest.approx(1.4)
    assert lobe["weight"] ** 2 == pytest.approx(RED[:3])


def test_principled_blend_gives_back_no_more_than_it_gets(bpy: Any) -> None:
    got = exported_material(
        bpy,
        "ShaderNodeBsdfPrincipled",
        Base_Color=(1.0, 1.0, 1.0, 1.0),
        Metallic=0.3,
        Transmission_Weight=0.5,
        Roughness=0.5,
    )
    models = sorted(int(lobe["model"]) for lobe in got.lobes_of("M"))
    assert models == [DIFFUSE, PHONG, DIELECTRIC], "metal and coat are alike and become one"
    total = sum(lobe["weight"] for lobe in got.lobes_of("M"))
    assert total == pytest.approx([1.0] * 3)


def test_principled_emission(bpy: Any) -> None:
    got = exported_material(
        bpy,
        "ShaderNodeBsdfPrincipled",
        Emission_Color=(1.0, 0.5, 0.25, 1.0),
        Emission_Strength=4.0,
    )
    assert got.emission_of("M") == pytest.approx([4.0, 2.0, 1.0])


def test_principled_inputs_that_are_ignored_are_named_once(bpy: Any) -> None:
    got = exported_material(
        bpy, "ShaderNodeBsdfPrincipled", Roughness=0.0, Alpha=0.5, Coat_Weight=1.0
    )
    assert got.warnings == ("material 'M': Alpha, Coat Weight of 'Principled BSDF' ignored",)


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
    velvet = new_material(bpy, "M", "ShaderNodeBsdfTranslucent")
    for name in "AB":
        add_cube(bpy, name, velvet)
    got = export(bpy)
    assert lobes(got) == [(DIFFUSE, [0.8] * 3)]
    assert len(got.warnings) == 1
    assert "material 'M'" in got.warnings[0]
    assert "Translucent BSDF" in got.warnings[0]


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
        (True, False),
        (False, True),
    ]


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
