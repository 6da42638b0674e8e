"""Lamps of every size, in awkward places, and many of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse, mirror
from photon_map.tests import scenes
from photon_map.tests.stability.support import family, note, shot, standard_error
from photon_map.tests.stability.test_index import transmittance
from photon_map.tests.statistics import same_means

RADII = [1.0, 1e-1, 1e-2, 1e-4, 1e-6, 0.0]


def lit(intensity, height, x0=0.0, y0=0.0, albedo=0.8):
    """Radiance of a floor under a sphere of any size: all of it above the horizon."""
    return lambda x, y: (
        albedo / np.pi * intensity * height / ((x - x0) ** 2 + (y - y0) ** 2 + height**2) ** 1.5
    )


def agree(runs, expected, bias=0.0):
    """T-test of the runs' means over axis 0 at level 0.01 over all pixels."""
    note(runs, expected)
    spread = runs.var(axis=0, ddof=1) / len(runs)
    floor = np.abs(expected) * bias + 1e-7
    same_means(runs.mean(axis=0), spread, expected, floor=floor, freedom=len(runs) - 1)


@pytest.mark.parametrize("radius", RADII)
def test_direct_light_of_a_sphere_of_any_radius(radius):
    b = scenes.floor_scene([diffuse(0.8)], size=6, height=3.0)
    b.add_point_light("lamp", (0.3, -0.2, 1.5), 5.0, radius)
    scene = b.build()
    runs = family(scene)["direct"][..., 0]
    agree(runs, scenes.floor_mean(scene, lit(5.0, 1.5, 0.3, -0.2)), bias=1e-4)


#: A cone that holds all rays to the picture, so that a spot is a point lamp there.
CONE = 1.4


@pytest.mark.parametrize("radius", RADII)
def test_direct_light_of_a_spot_of_any_radius(radius):
    b = scenes.floor_scene([diffuse(0.8)], size=6, height=3.0)
    matrix = scenes.look_at((0.3, -0.2, 1.5), (0.3, -0.2, 0))
    b.add_spot_light("lamp", matrix, 5.0, CONE, radius=radius)
    scene = b.build()
    runs = family(scene)["direct"][..., 0]
    agree(runs, scenes.floor_mean(scene, lit(5.0, 1.5, 0.3, -0.2)), bias=1e-4)


@pytest.mark.parametrize("radius", [0.3, 1e-2, 1e-4, 1e-6, 0.0])
def test_caustic_of_a_spot_of_any_radius(radius):
    """By the same mirror, straight at which it shines."""
    b = SceneBuilder("spot")
    matrix = scenes.look_at((0.5, 0.2, 1.5), (4.0, 0.2, 0.0))
    b.add_spot_light("lamp", matrix, 4.0, CONE, radius=radius)
    scene = replace(scenes.mirror_caustic(8), lights=b.light_tables()["lights"])
    runs = family(scene, caustic_radius=0.2, photons_caustic=32768)["caustics"][..., 0]
    expected = scenes.floor_mean(scene, lit(4.0, 1.5, 3.5, 0.2)).mean()
    agree(runs.mean(axis=(1, 2)), expected, bias=0.003)


@pytest.mark.parametrize("radius", RADII)
def test_caustic_of_a_sphere_of_any_radius(radius):
    """Its image in a mirror x = 2: a virtual sphere, whatever its size."""
    scene = scenes.mirror_caustic(8, radius=radius)
    runs = family(scene, caustic_radius=0.2, photons_caustic=32768)["caustics"][..., 0].mean(
        axis=(1, 2)
    )
    expected = scenes.floor_mean(scene, lit(4.0, 1.5, 3.5, 0.2)).mean()
    agree(runs, expected, bias=0.003)


@pytest.mark.parametrize("radius", [0.9, 1e-1, 1e-3, 1e-6, 0.0])
def test_indirect_light_of_a_sphere_of_any_radius(radius):
    """In the middle of a closed ball all of them are one: a^2 I / (pi (1 - a))."""
    b = SceneBuilder("closed")
    shell = scenes.sphere((0, 0, 0), 1.0, 3)
    b.add_mesh("shell", *shell, b.add_material("shell", [diffuse(0.5)]))
    b.add_point_light("lamp", (0, 0, 0), np.pi, radius)
    b.set_camera(scenes.camera((0.7, 0.1, 0), (1, 0.3, 0.2), 4, 4, fov=np.radians(60)))
    runs = family(b.build())
    for name in ("direct", "indirect"):
        # The facets lie up to 1 % nearer to the lamp.
        agree(runs[name].mean(axis=(1, 2, 3)), 0.5, bias=0.012)


@pytest.mark.parametrize("radius", [0.4, 1e-2, 1e-5])
def test_a_sphere_that_touches_the_floor(radius):
    b = scenes.floor_scene([diffuse(0.8)], size=6, height=3.0)
    b.add_point_light("lamp", (0.1, 0.1, radius), 5.0, radius)
    scene = b.build()
    found = family(scene, passes=32)["direct"][..., 0]
    # E is pi L at the point it touches, 25 / (pi r^2) ever narrower: the floor off it.
    expected = scenes.floor_mean(scene, lit(5.0, radius, 0.1, 0.1), order=40)
    far = np.ones((6, 6), bool)
    far[2:4, 2:4] = radius > 0.1
    agree(found[:, far], expected[far], bias=2e-3)


def test_a_sphere_half_sunk_into_the_floor():
    b = scenes.floor_scene([diffuse(0.8)], size=6, height=3.0)
    b.add_point_light("lamp", (0.1, 0.1, 0.0), 5.0, 0.3)
    scene = b.build()
    runs = family(scene, passes=16)["direct"]
    expected = trace(scene, 1000, seed=5)
    spread = runs.var(axis=0, ddof=1) / len(runs)
    same_means(
        runs.mean(axis=0), spread, expected["direct"], expected.variance["direct"],
        floor=1e-4, freedom=7,
    )  # fmt: skip


@pytest.mark.parametrize("height", [0.0, 1e-9, 1e-6, -1e-9])
def test_a_point_lamp_on_the_floor_is_finite(height):
    b = scenes.floor_scene([diffuse(0.8)], size=5, height=3.0)
    b.add_mesh("ceiling", *scenes.plane(4.0, 5.0), b.add_material("c", [diffuse(0.5)]))
    b.add_point_light("lamp", (0.0, 0.0, height), 5.0)
    layers = shot(b.build())
    # Through the ceiling: it lies a little above its floor, or shines from below it.
    if height > 1e-7:
        assert layers["indirect"].mean() > 0


def sunk_glass_ball(subdivisions: int):
    """A ball of glass around a lamp: rays meet it straight on, so nothing is bent."""
    b = scenes.floor_scene([diffuse(0.8)], size=6, height=3.0)
    ball = scenes.sphere((0, 0, 1.5), 0.5, subdivisions)
    normals = scenes.sphere_normals(ball, (0, 0, 1.5))
    b.add_mesh("ball", *ball, b.add_material("glass", [dielectric(1.5)]), normals)
    return b


@pytest.mark.parametrize("radius", [0.0, 1e-3])
def test_a_lamp_inside_a_glass_ball_shines_as_if_bare(radius):
    b = sunk_glass_ball(3)
    b.add_point_light("lamp", (0, 0, 1.5), 5.0, radius)
    scene = b.build()
    runs = family(scene, photons_caustic=32768, caustic_radius=0.2)
    assert (runs["direct"] == 0).all()
    expected = scenes.floor_mean(scene, lit(5.0, 1.5))
    # Behind the ball the camera looks through it: outer pixels alone.
    found = runs["caustics"][..., 0]
    rim = np.ones((6, 6), bool)
    rim[1:5, 1:5] = False
    agree(found[:, rim].mean(axis=1), expected[rim].mean(), bias=0.01)


def through_pane(intensity, height, radius, ior=1.5, order=24):
    """Irradiance under a thin pane by a sphere: its disc of directions, each by Fresnel."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    turns = 2 * np.pi * (np.arange(order) + 0.5) / order

    def irradiance(x, y):
        d = np.sqrt(x * x + y * y + height**2)
        if radius < 1e-3:
            return intensity * share(height / d) * height / d**3
        # Heights of directions about the axis to the lamp, which leans by acos(h / d).
        least = np.sqrt(1 - (radius / d) ** 2)
        total = np.zeros(np.broadcast(x, y).shape)
        for node, weight in zip(nodes, weights, strict=True):
            mu = (1 + least) / 2 + (1 - least) / 2 * node
            for turn in turns:
                lean = np.sqrt(1 - (height / d) ** 2) * np.sqrt(1 - mu * mu) * np.cos(turn)
                up = mu * height / d + lean
                total += weight * (1 - least) / 2 * share(up) * up * 2 * np.pi / order
        return intensity / (np.pi * radius**2) * total

    def share(cosine):
        return np.vectorize(lambda c: transmittance(np.arccos(c), ior))(cosine)

    return irradiance


@pytest.mark.parametrize("radius", RADII)
def test_a_lamp_behind_a_pane(radius):
    """Integral of Fresnel's share over a thin pane: the shift is 1e-4 of the height."""
    height = 1.5 if radius < 0.3 else 2.5
    b = scenes.floor_scene([diffuse(0.8)], size=6, height=1.0)
    # No larger than the light that reaches the picture: photons are aimed at all of it.
    pane = scenes.box((-2, -2, 1.1), (2, 2, 1.101))
    b.add_mesh("pane", *pane, b.add_material("glass", [dielectric(1.5)]))
    b.add_point_light("lamp", (0, 0, height), 5.0, radius)
    scene = b.build()
    irradiance = through_pane(5.0, height, radius)
    expected = scenes.floor_mean(scene, lambda x, y: 0.8 / np.pi * irradiance(x, y), order=2)
    runs = family(scene, photons_caustic=32768, caustic_radius=0.2)
    found = runs["caustics"][..., 0]
    agree(found.mean(axis=(1, 2)), expected.mean(), bias=0.003)


@pytest.mark.parametrize("ratio", [1e3, 1e6])
def test_a_dim_lamp_keeps_its_share_beside_a_bright_one(ratio):
    """Two closed balls: the bright lamp in one of them must not starve the other."""
    b = SceneBuilder("two rooms")
    grey = b.add_material("grey", [diffuse(0.5)])
    for x, intensity in ((0.0, np.pi), (2.5, np.pi * ratio)):
        b.add_mesh(f"shell {x}", *scenes.sphere((x, 0, 0), 1.0, 3), grey)
        b.add_point_light(f"lamp {x}", (x, 0, 0), intensity)
    b.set_camera(scenes.camera((0.7, 0.1, 0), (1, 0.3, 0.2), 4, 4, fov=np.radians(60)))
    runs = family(b.build(), passes=32)
    for name in ("direct", "indirect"):
        means = runs[name].mean(axis=(1, 2, 3))
        agree(means, 0.5, bias=0.012)
        assert standard_error(means) < 0.05 * 0.5


@pytest.mark.parametrize("watts", [1e9, 1e-9])
def test_watts_scale_every_layer(watts):
    def scene(factor):
        b = scenes.floor_scene([diffuse(0.8)], size=6)
        b.add_mesh("ball", *scenes.sphere((0, 0, 1), 0.5, 2),
                   b.add_material("silver", [mirror(0.9)]))  # fmt: skip
        b.add_mesh("wall", *scenes.quad((2, -4, 0), (2, -4, 4), (2, 4, 4), (2, 4, 0)),
                   b.add_material("w", [diffuse(0.5)], emission=0.1 * factor))  # fmt: skip
        b.add_point_light("lamp", (-1, 1, 2), factor / (4 * np.pi), 0.1)
        b.set_world(0.01 * factor)
        return b.build()

    found, expected = shot(scene(watts)), shot(scene(1.0))
    for name, values in found.items():
        assert expected[name].mean() > 0
        note(values / watts, expected[name])
        np.testing.assert_allclose(values / watts, expected[name], rtol=1e-5)


def test_two_thousand_lamps_add_up():
    b = scenes.floor_scene([diffuse(0.8)], size=4, height=3.0)
    rng = np.random.default_rng(7)
    places = np.column_stack([rng.uniform(-3, 3, (2000, 2)), rng.uniform(1, 3, 2000)])
    powers = 10.0 ** rng.uniform(-3, 0, 2000)
    for k, (place, power) in enumerate(zip(places, powers, strict=True)):
        b.add_point_light(f"l{k}", place, power, 0.01 * (k % 2))
    scene = b.build()

    def radiance(x, y):
        x, y = np.broadcast_arrays(x, y)
        d2 = (x[..., None] - places[:, 0]) ** 2 + (y[..., None] - places[:, 1]) ** 2
        e = (powers * places[:, 2] / (d2 + places[:, 2] ** 2) ** 1.5).sum(axis=-1)
        return 0.8 / np.pi * e

    runs = family(scene, passes=64)["direct"][..., 0]
    expected = scenes.floor_mean(scene, radiance)
    agree(runs, expected)
    assert (runs.std(axis=0) < 0.2 * expected).all()
