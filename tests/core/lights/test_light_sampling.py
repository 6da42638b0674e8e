"""Light sampling: uniform where it says so, densities that integrate to 1 (level 0.01)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from photon_map.core.lights.dispatch import sample_li, see_lamp
from photon_map.core.scene.builder import SceneBuilder
from photon_map.tests import scenes
from photon_map.tests.core.lights.support import PLAIN, UP, draw, prepared
from photon_map.tests.statistics import same_means, uniform_square

COUNT = 20_000
POINT = (0.4, -0.3, 0.2)
PLACE = scenes.look_at((1.0, 2.0, 3.0), (0.5, -0.4, 0.1), up=(0.1, 0.3, 1))


def lamp(name):
    b = SceneBuilder(name)
    if name == "sphere":
        b.add_point_light("lamp", PLACE[:3, 3], 5.0, radius=0.5)
    elif name == "near sphere":
        b.add_point_light("lamp", (0.4, -0.3, 1.2), 5.0, radius=1.0 - 1e-3)
    elif name == "tiny sphere":
        b.add_point_light("lamp", PLACE[:3, 3], 5.0, radius=1e-6)
    elif name == "spot":
        b.add_spot_light("lamp", PLACE, 5.0, 0.7, blend=0.5, radius=0.3)
    elif name == "stretched spot":
        b.add_spot_light("lamp", PLACE, 5.0, 0.7, blend=0.5, radius=0.3, size_x=2.0, size_y=0.5)
    elif name == "soft":
        b.add_point_light("lamp", PLACE[:3, 3], 5.0, radius=0.5, soft=1)
    elif name == "around":
        b.add_point_light("lamp", (0.4, -0.2, 0.1), 5.0, radius=0.5)
    elif name == "sun":
        b.add_sun_light("lamp", PLACE, 3.0, angle=0.5)
    elif name == "small sun":
        b.add_sun_light("lamp", PLACE, 3.0, angle=1e-4)
    else:
        spread = {"narrow rectangle": 0.6, "narrow disk": 0.6, "wide disk": 2.5}.get(
            name, 3.1416
        )
        b.add_area_light(
            "lamp", PLACE, 4.0, 1.5, 0.8, disk="disk" in name, spread=min(spread, math.pi)
        )
    return prepared(b)[:3]


SHAPES = [
    "soft",
    "around",
    "stretched spot",
    "narrow rectangle",
    "narrow disk",
    "wide disk",
    "sphere",
    "near sphere",
    "tiny sphere",
    "spot",
    "sun",
    "small sun",
    "rectangle",
    "disk",
]


@pytest.mark.parametrize("name", SHAPES)
def test_what_is_sampled_is_what_a_ray_sees(name, rng):
    lights, mesh, materials = lamp(name)
    wi, distance, radiance, pdf_w, delta = draw(
        lights, mesh, materials, 0, POINT, rng.random((2000, 3))
    )
    assert not delta.any()
    np.testing.assert_allclose(np.linalg.norm(wi[pdf_w > 0], axis=1), 1, rtol=1e-9)
    seen = [see_lamp(lights.lamps[0], POINT, tuple(w)) for w in wi]
    t, light, density = (np.array(column) for column in zip(*seen, strict=True))
    # A few directions at the rim may miss by rounding.
    hit = t > 0
    assert hit[pdf_w > 0].mean() > 0.99
    hit &= pdf_w > 0
    np.testing.assert_allclose(t[hit], distance[hit], rtol=1e-5)
    np.testing.assert_allclose(light[hit], radiance[hit], rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(density[hit], pdf_w[hit], rtol=1e-5)


@pytest.mark.parametrize(
    "name", [name for name in SHAPES if name not in ("narrow disk", "around")]
)
def test_density_integrates_to_one(name, rng):
    lights, mesh, materials = lamp(name)
    shape = lights.lamps[0]
    # A cone around the lamp's shape, sampled uniformly.
    to_lamp = PLACE[:3, 2] if "sun" in name else np.array(shape["position"]) - POINT
    plate = "rectangle" in name or "disk" in name
    reach = 0.9 if plate else shape["radius"] * 1.01
    distance = np.linalg.norm(to_lamp)
    half = 0.51 * shape["angle"] if "sun" in name else math.asin(min(1.0, reach / distance))
    axis = to_lamp / distance
    versine = 2 * math.sin(half / 2) ** 2
    height, phi = rng.random(COUNT) * versine, rng.random(COUNT) * 2 * np.pi
    side = np.cross(axis, (0.6, 0.8, 0.0))
    side /= np.linalg.norm(side)
    radial = np.outer(np.cos(phi), side) + np.outer(np.sin(phi), np.cross(axis, side))
    d = np.outer(1 - height, axis) + radial * np.sqrt(height * (2 - height))[:, None]
    seen = [see_lamp(shape, POINT, tuple(w)) for w in d]
    value = np.array([pdf if t > 0 else 0.0 for t, _, pdf in seen]) * 2 * np.pi * versine
    same_means(value.mean(), value.var() / COUNT, 1.0)


@pytest.mark.parametrize("name", ["sphere", "tiny sphere", "sun", "small sun"])
def test_round_lamps_are_uniform_in_solid_angle(name, rng):
    lights, mesh, materials = lamp(name)
    wi, _, _, pdf_w, _ = draw(lights, mesh, materials, 0, POINT, rng.random((COUNT, 3)))
    axis = PLACE[:3, 2] if "sun" in name else np.array(lights.lamps[0]["position"]) - POINT
    axis = axis / np.linalg.norm(axis)
    side = np.cross(axis, UP)
    side /= np.linalg.norm(side)
    apart = wi - axis
    versine = (apart**2).sum(axis=1) / 2
    azimuth = np.arctan2(wi @ np.cross(axis, side), wi @ side) / (2 * np.pi) % 1.0
    whole = 1 / (2 * np.pi * pdf_w)
    assert np.ptp(pdf_w) < 1e-9 * pdf_w[0]
    uniform_square(np.clip(versine / whole, 0, 1), azimuth, tests=4)


@pytest.mark.parametrize("name", ["rectangle", "disk"])
def test_plates_are_uniform_in_area(name, rng):
    lights, mesh, materials = lamp(name)
    wi, distance, _, _, _ = draw(lights, mesh, materials, 0, POINT, rng.random((COUNT, 3)))
    local = (POINT + wi * distance[:, None] - PLACE[:3, 3]) @ PLACE[:3, :3]
    x, y = local[:, 0] / 1.5, local[:, 1] / 0.8
    np.testing.assert_allclose(local[:, 2], 0, atol=1e-9)
    if name == "disk":
        x, y = 4 * (x * x + y * y) - 0.5, np.arctan2(y, x) / (2 * np.pi)
    uniform_square(x + 0.5, y + 0.5, tests=2)


def test_inside_a_sphere_it_shines_all_around():
    lights, mesh, materials = lamp("sphere")
    inside = tuple(lights.lamps[0]["position"] + (0.0, 0.0, 0.1))
    light = 5.0 / (math.pi * 0.25)
    assert (
        sample_li(lights, mesh, materials, PLAIN, 0, inside, UP, 0.5, 0.5, 0.5)[2][0] == light
    )
    t, seen, _ = see_lamp(lights.lamps[0], inside, (0.0, 0.0, 1.0))
    assert (t, seen[0]) == (pytest.approx(0.4), light)


def test_behind_an_area_lamp_there_is_no_light():
    lights, mesh, materials = lamp("rectangle")
    behind = tuple(PLACE[:3, 3] + PLACE[:3, 2])
    assert sample_li(lights, mesh, materials, PLAIN, 0, behind, UP, 0.5, 0.5, 0.5)[3] == 0
