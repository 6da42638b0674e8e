"""Lamps: Blender's power in the core's units, calibrated against Cycles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tests.blender.support import add_camera, add_light, export

POINT, SPOT, SUN, RECTANGLE, DISK = range(5)
COLOR = (1.0, 0.5, 0.25)


def exported_light(bpy: Any, kind: str, **values: Any) -> Any:
    add_camera(bpy)
    add_light(bpy, kind, color=COLOR, **values)
    (light,) = export(bpy).scene.lights
    return light


@pytest.mark.parametrize("radius", [0.0, 0.3])
def test_point(bpy: Any, radius: float) -> None:
    light = exported_light(bpy, "POINT", energy=100.0, shadow_soft_size=radius)
    assert light["kind"] == POINT
    assert light["emission"] == pytest.approx(100 * np.array(COLOR) / (4 * math.pi))
    assert light["radius"] == pytest.approx(radius)


def test_spot(bpy: Any) -> None:
    light = exported_light(
        bpy, "SPOT", energy=100.0, spot_size=math.radians(60), spot_blend=0.5
    )
    assert light["kind"] == SPOT
    assert light["emission"] == pytest.approx(100 * np.array(COLOR) / (4 * math.pi))
    assert light["cos_outer"] == pytest.approx(math.cos(math.radians(30)))
    assert light["blend"] == pytest.approx(0.5)


def test_sun(bpy: Any) -> None:
    light = exported_light(bpy, "SUN", energy=3.0, angle=0.2)
    assert light["kind"] == SUN
    assert light["emission"] == pytest.approx(3 * np.array(COLOR))
    assert light["angle"] == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("shape", "kind", "area", "sizes"),
    [
        ("SQUARE", RECTANGLE, 2.0 * 3.0 * 4.0, (4.0, 6.0)),
        ("RECTANGLE", RECTANGLE, 4.0 * 1.5, (4.0, 1.5)),
        ("DISK", DISK, math.pi / 4 * 4.0 * 6.0, (4.0, 6.0)),
        ("ELLIPSE", DISK, math.pi / 4 * 4.0 * 1.5, (4.0, 1.5)),
    ],
)
def test_area_with_the_scale_of_its_object(
    bpy: Any, shape: str, kind: int, area: float, sizes: tuple[float, float]
) -> None:
    add_camera(bpy)
    lamp = add_light(bpy, "AREA", energy=50.0, shape=shape, size=2.0, size_y=0.5)
    lamp.scale = (2.0, 3.0, 7.0)
    lamp.rotation_euler = (math.pi / 2, 0.0, 0.0)
    (light,) = export(bpy).scene.lights
    assert light["kind"] == kind
    assert (light["size_x"], light["size_y"]) == pytest.approx(sizes)
    assert light["emission"] == pytest.approx([50 / (math.pi * area)] * 3)
    # Turned by 90 degrees about x, -z becomes +y.
    assert -light["axis_z"] == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)
    assert light["axis_x"] == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)


def has(bpy: Any, name: str) -> bool:
    return name in bpy.types.Light.bl_rna.properties


def test_exposure(bpy: Any) -> None:
    if not has(bpy, "exposure"):
        pytest.skip("lights have an exposure from 4.5 on")
    light = exported_light(bpy, "SUN", energy=3.0, exposure=2.0)
    assert light["emission"] == pytest.approx(12 * np.array(COLOR))


def test_without_normalize(bpy: Any) -> None:
    if not has(bpy, "normalize"):
        pytest.skip("lights can be not normalised from 4.5 on")
    add_camera(bpy)
    values = {"energy": 8.0, "normalize": False}
    add_light(bpy, "POINT", "Sphere", shadow_soft_size=0.5, **values)
    add_light(bpy, "POINT", "Dot", shadow_soft_size=0.0, **values)
    add_light(bpy, "AREA", "Area", shape="SQUARE", size=3.0, **values)
    add_light(bpy, "SUN", "Sun", angle=0.3, **values)
    got = export(bpy).scene
    power = dict(zip(got.light_names, got.lights["emission"][:, 0], strict=True))
    assert power["Sphere"] == pytest.approx(8 * 0.5**2)
    assert power["Dot"] == pytest.approx(8 / math.pi)
    assert power["Area"] == pytest.approx(8 / math.pi)
    assert power["Sun"] == pytest.approx(8 * math.pi * math.sin(0.15) ** 2)


def test_temperature(bpy: Any) -> None:
    if not has(bpy, "use_temperature"):
        pytest.skip("lights have a temperature from 4.5 on")
    add_camera(bpy)
    lamp = add_light(bpy, "SUN", energy=1.0, use_temperature=True, temperature=3000.0)
    (light,) = export(bpy).scene.lights
    assert light["emission"] == pytest.approx(tuple(lamp.data.temperature_color))
    assert light["emission"][0] > 2 * light["emission"][2]


def test_visibility(bpy: Any) -> None:
    """Blender makes lamps invisible to the camera."""
    add_camera(bpy)
    lamp = add_light(bpy, "POINT")
    assert export(bpy).scene.lights["visibility"].tolist() == [2 + 4 + 8 + 16]
    lamp.visible_camera = True
    lamp.visible_glossy = False
    lamp.visible_transmission = False
    assert export(bpy).scene.lights["visibility"].tolist() == [1 + 2 + 16]


def test_nodes_multiply_the_power(bpy: Any) -> None:
    add_camera(bpy)
    lamp = add_light(bpy, "SUN", energy=2.0)
    lamp.data.use_nodes = True
    emission = lamp.data.node_tree.nodes["Emission"]
    got = export(bpy)
    assert got.scene.lights["emission"][0] == pytest.approx([2.0] * 3)
    assert got.warnings == ()
    emission.inputs["Strength"].default_value = 3.0
    emission.inputs["Color"].default_value = (1.0, 0.5, 0.0, 1.0)
    assert export(bpy).scene.lights["emission"][0] == pytest.approx([6.0, 3.0, 0.0])
    falloff = lamp.data.node_tree.nodes.new("ShaderNodeLightFalloff")
    lamp.data.node_tree.links.new(falloff.outputs[0], emission.inputs["Strength"])
    got = export(bpy)
    assert len(got.warnings) == 1
    assert "light 'Light'" in got.warnings[0]
    assert "Light Falloff" in got.warnings[0]


def test_lamps_that_cannot_shine_are_left_out(bpy: Any) -> None:
    add_camera(bpy)
    add_light(bpy, "POINT", "Off", energy=0.0)
    add_light(bpy, "POINT", "Negative", energy=-5.0)
    add_light(bpy, "POINT", "No scale").scale = (0.0, 0.0, 0.0)
    add_light(bpy, "AREA", "No size", size=0.0, shape="SQUARE")
    got = export(bpy)
    assert got.scene.light_names == ()
    text = "\n".join(got.warnings)
    for name in ("Negative", "No scale", "No size"):
        assert f"'{name}'" in text
    assert "'Off'" not in text


def test_shapes(bpy: Any) -> None:
    add_camera(bpy)
    add_light(bpy, "AREA", "Slats", spread=1.0)
    add_light(bpy, "AREA", "Beam", spread=0.0)
    add_light(bpy, "AREA", "Plain")
    add_light(bpy, "POINT", "Soft", use_soft_falloff=True)
    add_light(bpy, "SPOT", "Hard", use_soft_falloff=False).scale = (2.0, 3.0, 4.0)
    got = export(bpy)
    assert got.warnings == ()
    lights = dict(zip(got.scene.light_names, got.scene.lights, strict=True))
    assert lights["Slats"]["spread"] == pytest.approx(1.0)
    assert lights["Beam"]["spread"] == pytest.approx(1e-3)
    assert lights["Plain"]["spread"] == pytest.approx(math.pi)
    assert (lights["Soft"]["soft"], lights["Hard"]["soft"]) == (1, 0)
    assert (lights["Hard"]["size_x"], lights["Hard"]["size_y"]) == pytest.approx((0.5, 0.75))


def test_without_shadows(bpy: Any) -> None:
    add_camera(bpy)
    add_light(bpy, "SUN", "Plain")
    assert export(bpy).scene.lights["shadow"].tolist() == [1]
    bpy.data.lights["Plain"].use_shadow = False
    got = export(bpy)
    assert got.scene.lights["shadow"].tolist() == [0]
    assert not got.warnings
