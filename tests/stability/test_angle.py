"""The critical angle and grazing incidence to 1e-6 rad."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from photon_map.core import Settings
from photon_map.core.photon_pass import Batch, trace_batch
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse, mirror
from photon_map.tests import scenes
from photon_map.tests.stability.support import film_of, note, shot
from photon_map.tests.stability.test_index import reflectance

#: Narrow enough that all rays of a pixel have one angle.
NARROW = 1e-10


def looking(theta: float, up: float, distance: float = 1.0, size: int = 2):
    """A camera at ``distance`` from the origin that looks at it ``theta`` off the z axis."""
    eye = (distance * np.sin(theta), 0.0, up * distance * np.cos(theta))
    return scenes.camera(eye, (0, 0, 0), size, size, up=(0, 1, 0), fov=NARROW)


@pytest.mark.parametrize("gap", [-1e-3, -1e-6, 1e-6, 1e-3])
def test_critical_angle_seen_from_inside_glass(gap):
    """Above it all is black; below, what comes in is n^2 (1 - F) of the glowing sky."""
    n = 1.5
    b = SceneBuilder("half space")
    box = scenes.box((-50, -50, -50), (50, 50, 0))
    b.add_mesh("water", *box, b.add_material("water", [dielectric(n)]))
    # What is reflected ends on a black plate in the water.
    b.add_mesh("plate", *scenes.plane(49.0, -9.0), b.add_material("black", []))
    b.set_world(1.0)
    theta = np.arcsin(1 / n) + gap
    b.set_camera(looking(theta, -1.0))
    found = shot(b.build(), passes=1024)["emission"].mean()
    if gap > 0:
        assert found == 0.0
        return
    c, s = np.cos(theta), n * np.sin(theta)
    t = np.sqrt(1 - s * s)
    f = (((n * c - t) / (n * c + t)) ** 2 + ((c - n * t) / (c + n * t)) ** 2) / 2
    expected = n * n * (1 - f)
    note(found, expected)
    # Each path brings n^2 or nothing: 4096 * 4 paths in sequences.
    spread = n * n * np.sqrt(f * (1 - f) / (4 * 1024))
    assert abs(found - expected) < 3.3 * spread + 1e-5


@pytest.mark.parametrize("gap", [-1e-6, 0.0, 1e-6])
def test_photons_at_the_critical_angle_keep_their_flux(gap):
    """Sun into the side of a bar, then on its underside at the critical angle."""
    n = 1.3
    b = SceneBuilder("bar")
    b.add_mesh("bar", *scenes.box((-0.5, -0.5, 0), (0.5, 0.5, 1)),
               b.add_material("glass", [dielectric(n)]))  # fmt: skip
    grey = b.add_material("grey", [diffuse(0.5)])
    b.add_mesh("room", *scenes.box((-2, -2, -1), (2, 2, 2)), grey)
    # Inside: sin(theta) = 1 / n from the vertical, so cos(theta) is the sine off x.
    inside = np.arcsin(1 / n) + gap
    alpha = np.arcsin(n * np.cos(inside))
    beam = (-np.cos(alpha), 0.0, -np.sin(alpha))
    b.add_spot_light("beam", scenes.look_at(-0.9 * np.array(beam) + (0.5, 0, 0.5),
                                            (0.5, 0, 0.5)), 1000.0, 1e-7)  # fmt: skip
    b.set_camera(scenes.camera((-1.5, -1.5, 1.5), (0, 0, 0), 8, 8, fov=1.0))
    scene, settings = b.build(), Settings(photon_depth=256)
    assert film_of(scene, photon_depth=64, passes=2).resolve("caustics").max() < 1e12
    # All that the beam brings is absorbed by the room: half of what arrives, each time.
    power = 1000.0 * 2 * np.pi * (1 - scene.lights["cos_outer"][0])
    prepared, absorbed = prepare(scene, settings), []
    for i in range(8):
        walk = trace_batch(prepared, settings, i, Batch(False, 0, 2048, 2048))
        absorbed.append(0.5 * walk.photons["flux"][:, 0].sum(dtype=np.float64) / power)
    found, error = np.mean(absorbed), np.std(absorbed, ddof=1) / np.sqrt(8)
    note(found, 1.0)
    assert abs(found - 1) < 5.4 * error
    assert error < 0.02


@pytest.mark.parametrize("grazing", [1e-2, 1e-4, 1e-6])
def test_a_grazing_sun_lights_a_floor_by_its_sine(grazing):
    b = scenes.floor_scene([diffuse(0.8)], size=4, height=1.0)
    b.add_sun_light(
        "sun", scenes.look_at((np.cos(grazing), 0, np.sin(grazing)), (0, 0, 0)), 3.0
    )
    found = shot(b.build())["direct"]
    expected = 0.8 / np.pi * 3 * np.sin(grazing)
    note(found, expected)
    np.testing.assert_allclose(found, expected, rtol=1e-4)


@pytest.mark.parametrize("grazing", [1e-2, 1e-4, 1e-6])
def test_a_view_that_grazes_glass(grazing):
    """Sky above, black below: the slab's top shows F of the sky."""
    b = SceneBuilder("grazing")
    b.add_mesh("water", *scenes.box((-5, -5, -1), (5, 5, 0)),
               b.add_material("water", [dielectric(1.5)]))  # fmt: skip
    b.add_mesh("cellar", *scenes.box((-6, -6, -2), (6, 6, -1e-3)), b.add_material("b", []))
    b.set_world(1.0)
    theta = np.pi / 2 - grazing
    b.set_camera(looking(theta, 1.0))
    found = shot(b.build(), passes=256)["emission"].mean()
    note(found, reflectance(theta, 1.5))
    # 1024 paths, each refracted into the dark with probability 1 - F; level 0.001.
    low, high = binom.ppf((0.0005, 0.9995), 1024, 1 - reflectance(theta, 1.5)) / 1024
    assert low - 1e-5 <= 1 - found <= high + 1e-5


@pytest.mark.parametrize("grazing", [1e-2, 1e-4, 1e-6])
def test_a_beam_that_grazes_a_mirror_keeps_its_flux(grazing):
    """Sun almost along a mirror: what it catches lands on the wall that ends it."""
    b = SceneBuilder("grazing mirror")
    b.add_mesh("mirror", *scenes.quad((-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)),
               b.add_material("silver", [mirror(1.0)]))  # fmt: skip
    wall = scenes.quad((1, -2, -1), (1, -2, 1), (1, 2, 1), (1, 2, -1))
    b.add_mesh("wall", *wall, b.add_material("grey", [diffuse(0.5)]))
    beam = (-np.cos(grazing), 0.0, np.sin(grazing))
    b.add_sun_light("sun", scenes.look_at(beam, (0, 0, 0)), 3.0)
    b.set_camera(scenes.camera((-2, 0, 0.2), (1, 0, 0), 8, 8, fov=0.8))
    scene, settings = b.build(), Settings()
    shot(scene)
    prepared, emitted = prepare(scene, settings), 400_000
    walk = trace_batch(prepared, settings, 0, Batch(True, 0, emitted, emitted))
    flux = walk.photons["flux"][:, 0].sum(dtype=np.float64)
    # The aim is the disc around the mirror, 2 pi m^2 across the beam.
    expected, caught = 3 * 4 * np.sin(grazing), emitted * 4 * np.sin(grazing) / (2 * np.pi)
    if caught > 1000:
        note(flux, expected)
    # 5 standard deviations of the count; stratified points scatter less.
    assert abs(flux - expected) <= expected * (5 / np.sqrt(caught) + 1e-5)


@pytest.mark.parametrize("grazing", [1e-2, 1e-4, 1e-6])
def test_a_narrow_beam_that_grazes_a_mirror_keeps_its_flux(grazing):
    """A spot whose photons all meet the mirror within 5 cm, and then the wall behind it."""
    b = SceneBuilder("grazing beam")
    b.add_mesh("mirror", *scenes.plane(1.0), b.add_material("silver", [mirror(1.0)]))
    wall = scenes.quad((1, -2, -1), (1, -2, 1), (1, 2, 1), (1, 2, -1))
    b.add_mesh("wall", *wall, b.add_material("grey", [diffuse(0.5)]))
    start = 0.5 * np.array([-np.cos(grazing), 0.0, np.sin(grazing)])
    half_angle, emitted = 0.1 * grazing, 4096
    b.add_spot_light("beam", scenes.look_at(start, (0, 0, 0)), 1.0, half_angle)
    b.set_camera(scenes.camera((-2, 0, 0.2), (1, 0, 0), 8, 8))
    scene, settings = b.build(), Settings()
    walk = trace_batch(prepare(scene, settings), settings, 0, Batch(False, 0, emitted, emitted))
    assert (walk.order % settings.photon_depth == 1).all()
    place = walk.photons["position"]
    assert (place[:, 2] > 0).all() and (place[:, 0] > 0.99).all()
    found = walk.photons["flux"][:, 0].sum(dtype=np.float64)
    # The cone as its cosine in float64 has it; of the narrowest, 1e-7 rad, rounding takes
    # 0.3 % at the rim.
    power = 2 * np.pi * (1 - scene.lights["cos_outer"][0])
    note(found, power)
    np.testing.assert_allclose(found, power, rtol=5e-3 if half_angle < 1e-6 else 1e-4)
