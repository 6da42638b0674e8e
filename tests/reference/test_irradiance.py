"""The reference against closed forms of direct light on a floor (Z-tests at level 0.01)."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene.builder import diffuse, phong
from photon_map.core.scene.tables import Visibility
from photon_map.tests import scenes
from photon_map.tests.statistics import same_means

ALBEDO = 0.7
HEIGHT = 2.0


def floor():
    return scenes.floor_scene([diffuse(ALBEDO)])


def agrees(builder, irradiance, samples=600, layer="direct", order=6, floor=1e-9):
    scene = builder.build()
    expected = ALBEDO / np.pi * scenes.floor_mean(scene, irradiance, order)
    found = trace(scene, samples, seed=5)
    same_means(found[layer], found.variance[layer], expected[..., None], floor=floor)
    others = {"emission", "direct", "caustics", "indirect"} - {layer}
    assert all((found[name] == 0).all() for name in others)


def above(point=(0.0, 0.0, HEIGHT)):
    matrix = np.eye(4)
    matrix[:3, 3] = point
    return matrix


def point_irradiance(position, intensity):
    def irradiance(x, y):
        square = (x - position[0]) ** 2 + (y - position[1]) ** 2 + position[2] ** 2
        return intensity * position[2] / square**1.5

    return irradiance


@pytest.mark.parametrize("radius", [0.0, 1e-4, 0.4])
def test_point_and_sphere_give_the_inverse_square_law(radius):
    # A sphere wholly above the horizon lights a plane like a point of the same intensity.
    b = floor()
    hidden = Visibility.ALL & ~Visibility.CAMERA
    b.add_point_light("lamp", (0.3, -0.2, HEIGHT), 5.0, radius=radius, visibility=hidden)
    agrees(b, point_irradiance((0.3, -0.2, HEIGHT), 5.0))


def test_sun_irradiance_does_not_depend_on_its_angle():
    tilt = scenes.look_at((1, 0, 2), (0, 0, 0))
    cosine = 2 / np.sqrt(5)
    for angle in (0.0, 0.01, 1.0):
        b = floor()
        b.add_sun_light("sun", tilt, 3.0, angle=angle)
        agrees(b, lambda x, y: 3.0 * cosine + 0 * x)


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_spot_falls_off_by_blenders_smooth_step(radius):
    half = 0.6

    def irradiance(x, y):
        square = x**2 + y**2 + HEIGHT**2
        t = (HEIGHT / np.sqrt(square) - np.cos(half)) / (1 - np.cos(half))
        t = np.clip(t, 0, 1)
        return 5.0 * t * t * (3 - 2 * t) * HEIGHT / square**1.5

    b = floor()
    b.add_spot_light("lamp", above(), 5.0, half, blend=1.0, radius=radius)
    # The sphere shows each point a spread of angles: that is a known, small difference.
    agrees(b, irradiance, floor=1e-5 if radius == 0 else 2e-3)


def corner_factor(a, b):
    """View factor of a rectangle a x b at distance 1, its corner over the point."""
    p, q = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
    return (a / p * np.arctan(b / p) + b / q * np.arctan(a / q)) / (2 * np.pi)


def rectangle_irradiance(x, y):
    (left, right), (low, high) = (-0.75, 0.75), (-0.5, 0.5)
    u0, u1, v0, v1 = ((s - o) / HEIGHT for s, o in ((left, x), (right, x), (low, y), (high, y)))
    f = corner_factor
    return 4.0 * np.pi * (f(u1, v1) - f(u0, v1) - f(u1, v0) + f(u0, v0))


def test_rectangle_form_factor():
    b = floor()
    b.add_area_light("lamp", above(), 4.0, 1.5, 1.0)
    agrees(b, rectangle_irradiance, samples=2000)


@pytest.mark.parametrize("flip", [False, True])
def test_emissive_faces_light_like_an_area_lamp_on_both_sides(flip):
    b = floor()
    b.set_camera(scenes.camera((0, 0, 1.5), (0, 0, 0), 8, 8, up=(0, 1, 0)))
    x, y, z = 0.75, 0.5, HEIGHT
    points = [(-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)]
    quad = scenes.quad(*(points[::-1] if flip else points))
    b.add_mesh("panel", *quad, b.add_material("panel", emission=4.0))
    agrees(b, rectangle_irradiance, samples=2000)


def test_disk_form_factor():
    def irradiance(x, y):
        a = np.sqrt(x**2 + y**2)
        h, r = HEIGHT / a, 0.6 / a
        z = 1 + h * h + r * r
        return 4.0 * np.pi * 0.5 * (1 - (1 + h * h - r * r) / np.sqrt(z * z - 4 * r * r))

    b = floor()
    b.add_area_light("lamp", above(), 4.0, 1.2, 1.2, disk=True)
    agrees(b, irradiance, samples=2000)


def test_world_lights_an_open_floor_with_pi_l():
    b = floor()
    b.set_world((0.5, 1.0, 2.0))
    found = trace(b.build(), 4, seed=1)
    expected = ALBEDO * np.array([0.5, 1.0, 2.0])
    np.testing.assert_allclose(
        found["direct"], np.broadcast_to(expected, (8, 8, 3)), rtol=1e-12
    )


@pytest.mark.parametrize("exponent", [1.0, 40.0])
def test_phong_seen_head_on_has_albedo_one(exponent):
    b = scenes.floor_scene([phong(0.9, exponent)])
    b.set_camera(scenes.camera((0, 0, 2), (0, 0, 0), 4, 4, up=(0, 1, 0), fov=1e-4))
    b.set_world(2.0)
    found = trace(b.build(), 4000, seed=2)
    same_means(found["direct"], found.variance["direct"], 1.8)


def test_soft_disc_lights_like_a_disc_that_faces_each_point():
    def irradiance(x, y):
        square = x**2 + y**2 + HEIGHT**2
        return 5.0 * HEIGHT / (np.sqrt(square) * (square + 0.7**2))

    b = floor()
    hidden = Visibility.ALL & ~Visibility.CAMERA
    b.add_point_light("lamp", (0, 0, HEIGHT), 5.0, radius=0.7, visibility=hidden, soft=1)
    agrees(b, irradiance)


def test_spread_gathers_the_light_towards_the_axis():
    """Slats: cos^2 / d^2 (1 - tan a / tan e) / (1 - e / tan e) at each point of the lamp."""
    nodes, weights = np.polynomial.legendre.leggauss(12)

    def irradiance(x, y):
        total = 0 * x * y
        for a, wa in zip(nodes / 2, weights / 2, strict=True):
            for b, wb in zip(nodes / 2, weights / 2, strict=True):
                side2 = (x - a) ** 2 + (y - b) ** 2
                share = (1 - np.sqrt(side2) / HEIGHT / np.tan(1)) / (1 - 1 / np.tan(1))
                total = total + wa * wb * share * HEIGHT**2 / (side2 + HEIGHT**2) ** 2
        return 4.0 * total

    b = floor()
    b.add_area_light("lamp", above(), 4.0, 1.0, 1.0, spread=2.0)
    agrees(b, irradiance)


def test_scale_stretches_the_cone_of_a_spot():
    def irradiance(x, y):
        square = x**2 + y**2 + HEIGHT**2
        cosine = HEIGHT / np.sqrt((x / 1.5) ** 2 + (y / 0.8) ** 2 + HEIGHT**2)
        t = np.clip((cosine - np.cos(0.6)) / (1 - np.cos(0.6)), 0, 1)
        return 5.0 * t * t * (3 - 2 * t) * HEIGHT / square**1.5

    b = floor()
    b.add_spot_light("lamp", above(), 5.0, 0.6, blend=1.0, size_x=1.5, size_y=0.8)
    agrees(b, irradiance, floor=1e-5)
