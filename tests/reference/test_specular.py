"""The reference's mirrors and glass against closed forms (Z-tests at level 0.01)."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.reference.optics import cos_transmitted, reflectance, refracted
from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene.builder import (
    SceneBuilder,
    dielectric,
    diffuse,
    mirror,
    refraction,
)
from photon_map.core.scene.tables import Visibility
from photon_map.tests import scenes
from photon_map.tests.statistics import integral, same_means


def fresnel(theta: float, n: float) -> float:
    """Reflectance into index ``n`` by Fresnel's sine and tangent laws."""
    if theta < 1e-9:
        return ((n - 1) / (n + 1)) ** 2
    t = np.arcsin(np.sin(theta) / n)
    s_part = np.sin(theta - t) / np.sin(theta + t)
    p_part = np.tan(theta - t) / np.tan(theta + t)
    return (s_part**2 + p_part**2) / 2


def slab_transmittance(theta: float, n: float) -> float:
    """Of a plane slab, all internal reflections added: (1 - F) / (1 + F)."""
    f = fresnel(theta, n)
    return (1 - f) / (1 + f)


@pytest.mark.parametrize("degrees", [0.0, 20.0, 45.0, np.degrees(np.arctan(1.5)), 75.0, 89.0])
def test_reflectance_agrees_with_fresnels_own_form(degrees):
    theta = np.radians(degrees)
    assert reflectance(np.cos(theta), 1.0, 1.5) == pytest.approx(fresnel(theta, 1.5), rel=1e-9)


def test_total_reflection_begins_at_the_critical_angle():
    critical = np.arcsin(1 / 1.5)
    assert reflectance(np.cos(critical + 1e-6), 1.5, 1.0) == 1.0
    assert reflectance(np.cos(critical - 1e-6), 1.5, 1.0) < 1.0
    assert cos_transmitted(np.cos(critical + 1e-6), 1.5, 1.0) == -1.0
    assert reflectance(1e-6, 1.0, 1.0) == 0.0


def test_refracted_direction_obeys_snell():
    d = (np.sin(0.7), 0.0, -np.cos(0.7))
    passes, out = refracted(d, (0.0, 0.0, 1.0), 1.0, 1.5)
    assert passes
    np.testing.assert_allclose(out[0], np.sin(0.7) / 1.5, rtol=1e-14)
    assert out[1] == 0.0 and out[2] < 0.0


@pytest.mark.parametrize("degrees", [0.0, 30.0, 56.31, 80.0])
def test_slab_transmits_as_the_sum_of_its_reflections(degrees):
    theta = np.radians(degrees)
    b = SceneBuilder("slab")
    b.add_mesh("slab", *scenes.glass_slab(1.5), b.add_material("slab", [dielectric(1.5)]))
    glow = b.add_material("glow", emission=3.0)
    b.add_mesh("panel", *scenes.plane(60.0, 0.0), glow)
    eye = (2 * np.sin(theta), 0, 0.7 + 2 * np.cos(theta))
    b.set_camera(scenes.camera(eye, (0, 0, 0.7), 2, 2, up=(0, 1, 0), fov=1e-4))
    found = trace(b.build(), 20000, seed=2)
    expected = 3.0 * slab_transmittance(theta, 1.5)
    same_means(found["emission"], found.variance["emission"], expected, floor=3e-4)


def test_world_through_a_slab_lights_the_floor_as_a_caustic():
    b = scenes.floor_scene([diffuse(0.8)], half=40.0, size=4, height=0.4)
    b.add_mesh("slab", *scenes.glass_slab(1.5), b.add_material("slab", [dielectric(1.5)]))
    b.set_world(1.0)
    found = trace(b.build(), 20000, seed=3)
    hemisphere = integral(
        lambda t: slab_transmittance(t, 1.5) * np.sin(2 * t), 0.0, np.pi / 2 - 1e-9
    )
    same_means(found["caustics"], found.variance["caustics"], 0.8 * hemisphere, floor=1e-3)
    # What comes in under the slab's rim, 40 m away.
    assert found["direct"].max() < 0.02


def test_plane_mirror_is_a_virtual_light():
    scene = scenes.mirror_caustic(radius=0.15)
    found = trace(scene, 30000, seed=4)

    def irradiance(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 4.0 * 1.5 / ((x - 3.5) ** 2 + (y - 0.2) ** 2 + 1.5**2) ** 1.5

    expected = 0.8 / np.pi * scenes.floor_mean(scene, irradiance)
    same_means(found["caustics"], found.variance["caustics"], expected[..., None])


def test_refraction_alone_has_no_fresnel_loss_and_is_black_beyond_the_critical_angle():
    b = SceneBuilder("refraction")
    rows = b.add_material("water", [refraction(1.33)])
    b.add_mesh("surface", *scenes.plane(60.0, 0.0), rows)
    b.set_world(1.0)
    b.set_camera(scenes.camera((0, 0, -1), (0.1, 0, 0), 2, 2, fov=1e-3))
    np.testing.assert_allclose(trace(b.build(), 4)["emission"], 1.33**2, rtol=1e-12)
    b.set_camera(scenes.camera((0, 0, -1), (3.0, 0, 0), 2, 2, fov=1e-3))
    assert (trace(b.build(), 4)["combined"] == 0).all()


@pytest.mark.parametrize(
    ("bits", "seen"),
    [
        (Visibility.CAMERA, (3.0, 0.0, 0.0)),
        # The third ray meets the mirror in the end.
        (Visibility.GLOSSY, (0.0, 3.0, 3.0)),
        (Visibility.TRANSMISSION, (0.0, 0.0, 3.0)),
    ],
)
def test_lamp_shapes_are_seen_by_the_rays_of_their_visibility(bits, seen):
    b = SceneBuilder("visibility")
    silver, pane = b.add_material("m", [mirror()]), b.add_material("p", [refraction(1.0)])
    b.add_mesh("mirror", *scenes.plane(9.0, -1.0), silver)
    b.add_mesh("pane", *scenes.box((-9, -9, 2), (9, 9, 3)), pane)
    b.add_area_light("up", np.diag([1.0, -1, -1, 1]), 3.0, 20, 20, visibility=bits)
    down = np.eye(4)
    down[2, 3] = 1.0
    b.add_area_light("down", down, 3.0, 20, 20, visibility=bits)
    views = [
        ((0, 0, -0.5), (0.1, 0, 1)),
        ((0, 0, -0.5), (0.1, 0, -1)),
        ((0, 0, 4), (0.1, 0, 0)),
    ]
    for (eye, target), value in zip(views, seen, strict=True):
        b.set_camera(scenes.camera(eye, target, 1, 1, fov=1e-3))
        found = trace(b.build(), 2)["emission"]
        np.testing.assert_allclose(found, value)
