"""Index of refraction exactly 1, nearly 1, 0.2 and 4, through photons and camera paths."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse
from photon_map.tests import scenes
from photon_map.tests.stability.support import family, note, shot, standard_error

INDICES = [1.0, 1.0 - 1e-6, 1.0 + 1e-6, 0.2, 4.0]


def reflectance(theta: float, n: float) -> float:
    """Unpolarised Fresnel reflectance from index 1 into ``n``; 1 beyond the critical angle."""
    sine = np.sin(theta) / n
    if sine >= 1:
        return 1.0
    c, t = np.cos(theta), np.sqrt(1 - sine**2)
    s, p = (c - n * t) / (c + n * t), (n * c - t) / (n * c + t)
    return float(s * s + p * p) / 2


def transmittance(theta: float, n: float) -> float:
    """Of a slab with all its internal reflections: (1 - F) / (1 + F)."""
    f = reflectance(theta, n)
    return (1 - f) / (1 + f)


@pytest.mark.parametrize("theta", [0.0, 0.15, 0.3])
@pytest.mark.parametrize("n", INDICES)
def test_sun_through_a_slab(n, theta):
    b = scenes.floor_scene([diffuse(0.8)], half=1.0, size=4, height=0.4)
    b.add_mesh("slab", *scenes.glass_slab(n, half=1.0), b.add_material("g", [dielectric(n)]))
    b.add_sun_light("sun", scenes.look_at((np.sin(theta), 0, np.cos(theta)), (0, 0, 0)), 3.0)
    runs = family(b.build(), photons_caustic=16384)
    expected = 0.8 / np.pi * 3 * np.cos(theta) * transmittance(theta, n)
    means = runs["caustics"].mean(axis=(1, 2, 3))
    note(means, expected)
    # 5.4 sigma at 7 degrees of freedom: 0.001.
    assert abs(means.mean() - expected) <= 5.4 * standard_error(means) + 1e-6 * expected
    assert standard_error(means) <= 0.02 * expected
    assert (runs["direct"] == 0).all()


@pytest.mark.parametrize("n", INDICES)
def test_a_ball_in_a_white_furnace_vanishes(n):
    b = SceneBuilder("ball")
    ball = scenes.sphere((0, 0, 0), 1.0, 2)
    b.add_mesh("ball", *ball, b.add_material("glass", [dielectric(n)]))
    b.set_world(1.0)
    b.set_camera(scenes.camera((0, -3, 0.3), (0, 0, 0), 12, 12))
    found = shot(b.build(), camera_depth=1024)["emission"]
    note(found, 1.0)
    np.testing.assert_allclose(found, 1.0, rtol=1e-5)


@pytest.mark.parametrize("n", INDICES)
def test_inside_a_medium_radiance_is_n_squared(n):
    b = SceneBuilder("inside")
    ball = scenes.sphere((0, 0, 0), 1.0, 2)
    b.add_mesh("ball", *ball, b.add_material("glass", [dielectric(n)]))
    b.set_world(1.0)
    b.set_camera(scenes.camera((0.1, -0.2, 0.05), (0, 0, 0), 8, 8))
    found = shot(b.build(), camera_depth=1024)["emission"]
    note(found, n * n)
    np.testing.assert_allclose(found, n * n, rtol=1e-5)


@pytest.mark.parametrize("n", [1.0, 1.0 - 1e-6, 1.0 + 1e-6])
def test_a_body_of_index_1_changes_no_light(n):
    """Under the body all light is a caustic, beside it direct: the sum is that of no body."""
    b = scenes.floor_scene([diffuse(0.8)], half=4.0, size=8, height=3.0)
    body = scenes.box((-0.7, -0.6, 0.2), (0.6, 0.7, 0.9))
    b.add_mesh("body", *body, b.add_material("air", [dielectric(n)]))
    b.add_point_light("lamp", (0.2, 0.1, 2.0), 5.0)
    scene = b.build()

    def radiance(x, y):
        return 0.8 / np.pi * 5.0 * 2.0 / ((x - 0.2) ** 2 + (y - 0.1) ** 2 + 4.0) ** 1.5

    runs = family(scene, photons_caustic=32768, caustic_radius=0.2)
    assert runs["caustics"].mean() > 0.3 * runs["total"].mean()
    total = runs["total"].mean(axis=(1, 2, 3))
    expected = scenes.floor_mean(scene, radiance).mean()
    note(total, expected)
    # Light that the floor scatters up and the body's lid sends back is none: F is 0.
    # The disc blurs the edge of the shadow, whose light neither gains nor loses in sum,
    # but caustics are seen through the body, too: 0.3 % is the step of the image's border.
    assert abs(total.mean() - expected) <= 5.4 * standard_error(total) + 3e-3 * expected
