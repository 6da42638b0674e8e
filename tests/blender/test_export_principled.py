"""The Principled BSDF: every input to its field."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from photon_map.core.scene.closures import closure
from photon_map.core.scene.tables import PARAM_NAMES, ClosureKind
from tests.blender.test_export_materials import DIELECTRIC, RED, exported_material, lobes


def test_principled_as_it_comes(bpy: Any) -> None:
    got = exported_material(bpy, "ShaderNodeBsdfPrincipled")
    (row,) = got.closures_of("M")
    fresh = closure(ClosureKind.PRINCIPLED, roughness=0.5, distribution=1)
    for name in (name for name in fresh.dtype.names if name != "factors"):
        for ours, theirs in zip(leaves(row[name]), leaves(fresh[name]), strict=True):
            assert ours == pytest.approx(theirs, abs=1e-6), name
    assert lobes(got) == []
    material = got.material("M")
    assert material["ior"] == 0, "no light enters"
    assert not material["passes"]
    assert not material["emission"].any()
    assert got.warnings == ()


def leaves(value: Any) -> list[np.ndarray]:
    """The plain numbers of a row, whatever is nested in it."""
    if value.dtype.names is None:
        return [np.asarray(value)]
    return [leaf for name in value.dtype.names for leaf in leaves(value[name])]


def test_every_input_of_principled(bpy: Any) -> None:
    tint = (0.9, 0.5, 0.25, 1.0)
    got = exported_material(
        bpy,
        "ShaderNodeBsdfPrincipled",
        Base_Color=RED,
        Metallic=0.25,
        Roughness=0.75,
        IOR=1.25,
        Alpha=0.5,
        Diffuse_Roughness=0.125,
        Specular_IOR_Level=0.75,
        Specular_Tint=tint,
        Transmission_Weight=0.375,
        Coat_Weight=0.0625,
        Coat_Roughness=0.1875,
        Coat_IOR=1.75,
        Coat_Tint=tint,
        Sheen_Weight=0.875,
        Sheen_Roughness=0.625,
        Sheen_Tint=tint,
        Emission_Color=(1.0, 0.5, 0.25, 1.0),
        Emission_Strength=4.0,
    )
    (row,) = got.closures_of("M")
    numbers = {
        "ior": 1.25, "diffuse_roughness": 0.125, "specular_level": 0.75, "coat": 0.0625,
        "coat_roughness": 0.1875, "coat_ior": 1.75, "sheen": 0.875, "sheen_roughness": 0.625,
        "distribution": 1, "factor_count": 0,
    }  # fmt: skip
    assert {name: row[name] for name in numbers} == numbers
    params = {"metallic": 0.25, "roughness": 0.75, "alpha": 0.5, "transmission": 0.375}
    assert {name: row[name]["value"][0] for name in params} == params
    assert row["color"]["value"] == pytest.approx(RED[:3])
    assert row["emission"]["value"] == pytest.approx([4.0, 2.0, 1.0])
    for name in ("specular_tint", "coat_tint", "sheen_tint"):
        assert row[name] == pytest.approx(tint[:3])
    assert all(row[name]["texture"] == -1 for name in PARAM_NAMES)
    material = got.material("M")
    assert material["ior"] == 1.25
    assert material["passes"] == 1
    assert material["emission"] == pytest.approx([2.0, 1.0, 0.5]), "alpha hides half of it"
    assert got.warnings == ()


def test_clear_principled_glass_is_a_plain_dielectric(bpy: Any) -> None:
    got = exported_material(
        bpy,
        "ShaderNodeBsdfPrincipled",
        Base_Color=(1.0, 1.0, 1.0, 1.0),
        Transmission_Weight=1.0,
        Roughness=0.0,
        IOR=1.4,
    )
    (lobe,) = got.lobes_of("M")
    assert lobe["model"] == DIELECTRIC
    assert lobe["ior"] == pytest.approx(1.4)
    assert not got.closures_of("M")


def test_what_principled_does_not_do_is_said(bpy: Any) -> None:
    got = exported_material(
        bpy,
        "ShaderNodeBsdfPrincipled",
        Anisotropic=0.5,
        Thin_Film_Thickness=100.0,
        Subsurface_Weight=0.5,
    )
    assert got.warnings == (
        "material 'M': Anisotropic, Thin Film Thickness of 'Principled BSDF' ignored",
        "subsurface scattering is rendered diffuse in: material 'M'",
    )
