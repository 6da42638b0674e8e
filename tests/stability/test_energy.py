"""Energy where it is hardest to keep: mirror boxes, gems, surfaces of albedo 1."""

from __future__ import annotations

import time

import numpy as np
import pytest
from scipy.stats import binom

from photon_map.core import Settings
from photon_map.core.photon_pass import Batch, trace_batch
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse, mirror
from photon_map.tests import scenes
from photon_map.tests.stability.support import family, film_of, note, shot, standard_error
from photon_map.tests.stability.test_index import reflectance


def mirror_room(floor: float, side: float = 1.0):
    """Perfect mirrors all around over a floor of that albedo, seen whole from above."""
    b = SceneBuilder("mirror room")
    points, faces = scenes.box((-1, -1, 0), (1, 1, 1.5))
    silver = b.add_material("silver", [mirror(side)])
    paint = b.add_material("paint", [diffuse(floor)])
    rows = np.where(points[faces][..., 2].max(axis=1) == 0, paint, silver)
    b.add_mesh("room", points, faces, rows)
    b.add_point_light("lamp", (0.3, -0.2, 0.7), 1.0, 0.1)
    # The image is the floor: its half side 1 at the distance 1.4.
    fov = 2 * np.arctan(1 / 1.4)
    b.set_camera(scenes.camera((0, 0, 1.4), (0, 0, 0), 12, 12, up=(0, 1, 0), fov=fov))
    return b.build()


@pytest.mark.parametrize("albedo", [0.2, 0.5])
def test_a_mirror_box_gives_the_floor_all_its_light(albedo):
    """What is emitted is absorbed by the floor: mean E (1 - a) A = 4 pi I."""
    runs = family(mirror_room(albedo), photon_depth=1024, camera_depth=1024, caustic_radius=0.5)
    expected = albedo / np.pi * 4 * np.pi / (4.0 * (1 - albedo))
    # The emission layer is the lamp itself, which is in the picture.
    means = (runs["total"] - runs["emission"]).mean(axis=(1, 2, 3))
    note(means, expected)
    # Discs at the rim of the floor lose what lies beyond it: boundary bias of 3 %.
    assert abs(means.mean() - expected) < 5.4 * standard_error(means) + 0.03 * expected
    assert means.mean() > expected * 0.97


@pytest.mark.parametrize("reflectance", [1.0, 0.999])
def test_a_box_of_mirrors_alone_ends_in_bounded_time(reflectance):
    b = SceneBuilder("mirrors")
    b.add_mesh("box", *scenes.box((-1, -1, -1), (1, 1, 1)),
               b.add_material("m", [mirror(reflectance)]))  # fmt: skip
    b.add_mesh("dot", *scenes.sphere((0.5, 0.5, 0.5), 0.05, 1),
               b.add_material("d", [diffuse(0.5)]))  # fmt: skip
    b.add_point_light("lamp", (-0.3, 0, 0.2), 1.0, 0.05)
    b.set_camera(scenes.camera((0, 0.1, 0), (1, 0.3, 0), 8, 8))
    begin = time.process_time()
    film_of(b.build(), camera_depth=1024, photon_depth=1024, passes=2)
    assert time.process_time() - begin < 60


def test_a_glowing_mirror_box_sums_its_series():
    b = SceneBuilder("glowing mirrors")
    b.add_mesh("box", *scenes.box((-1, -1, -1), (1, 1, 1)),
               b.add_material("m", [mirror(0.8)], emission=1.0))  # fmt: skip
    b.set_camera(scenes.camera((0.2, 0.1, 0), (1, 0.3, 0.4), 8, 8))
    found = shot(b.build(), camera_depth=1024)["emission"]
    note(found, 1 / (1 - 0.8))
    # Paths end below a throughput of 1e-4.
    np.testing.assert_allclose(found, 1 / (1 - 0.8), rtol=2e-4)


def brilliant(ior: float = 2.42):
    """A gem: a crown of 8 and a pavilion of 8 faces around a girdle."""
    angle = 2 * np.pi * np.arange(8) / 8
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    table = 0.55 * ring + (0, 0, 0.35)
    points = np.concatenate([ring, table, [(0, 0, -0.85), (0, 0, 0.35)]])
    faces = []
    for k in range(8):
        n = (k + 1) % 8
        faces += [(k, n, 8 + n), (k, 8 + n, 8 + k), (n, k, 16), (8 + k, 8 + n, 17)]
    return points, np.array(faces)


@pytest.mark.parametrize("depth", [64, 1024])
def test_a_gem_in_a_white_furnace(depth):
    b = SceneBuilder("gem")
    b.add_mesh("gem", *brilliant(), b.add_material("diamond", [dielectric(2.42)]))
    b.set_world(1.0)
    b.set_camera(scenes.camera((0, -3, 2), (0, 0, 0), 16, 16))
    found = shot(b.build(), passes=32, camera_depth=depth)["emission"]
    note(found, 1.0)
    assert found.max() < 1 + 1e-5
    # 64 bounces leave out the paths that are still inside: totally reflected ones.
    assert found.mean() > (1 - 1e-6 if depth == 1024 else 0.995)


def test_a_gem_lets_out_all_photons():
    """In a closed room of albedo 0.5: half of all light is absorbed at each wall hit."""
    b = SceneBuilder("gem room")
    b.add_mesh("gem", *brilliant(), b.add_material("diamond", [dielectric(2.42)]))
    b.add_mesh("room", *scenes.box((-4, -4, -4), (4, 4, 4)),
               b.add_material("wall", [diffuse(0.5)]))  # fmt: skip
    b.add_point_light("lamp", (0.5, 0.4, 3), 1.0)
    b.set_camera(scenes.camera((3, 3, 3), (0, 0, 0), 8, 8))
    settings = Settings(photon_depth=1024)
    prepared = prepare(b.build(), settings)
    absorbed = []
    for i in range(8):
        walk = trace_batch(prepared, settings, i, Batch(False, 0, 8192, 8192))
        absorbed.append(0.5 * walk.photons["flux"][:, 0].sum(dtype=np.float64))
    found, error = np.mean(absorbed), np.std(absorbed, ddof=1) / np.sqrt(8)
    note(found, 4 * np.pi)
    assert abs(found - 4 * np.pi) < 5.4 * error
    assert error < 0.01 * found


#: A bar of glass 10 m long in which light is totally reflected 64 times.
BAR, WIDTH, REFLECTIONS, INDEX = 10.0, 0.1, 64, 1.5
_INSIDE = np.arctan(REFLECTIONS * WIDTH / BAR)
_OUTSIDE = np.arcsin(INDEX * np.sin(_INSIDE))
#: What passes both ends once; 80 events are too few to come back from the far end.
PASSED = (1 - reflectance(_OUTSIDE, INDEX)) ** 2
DEPTH = 80


def light_guide(screen_lobes, glow=0.0):
    """The bar along x, and behind its far end a screen."""
    b = SceneBuilder("light guide")
    h = WIDTH / 2
    glass = b.add_material("glass", [dielectric(INDEX)])
    b.add_mesh("bar", *scenes.box((0, -h, -h), (BAR, h, h)), glass)
    x = BAR + 1
    screen = scenes.quad((x, -3, -3), (x, -3, 3), (x, 3, 3), (x, 3, -3))
    b.add_mesh("screen", *screen, b.add_material("screen", screen_lobes, emission=glow))
    return b, np.array([np.cos(_OUTSIDE), 0.0, -np.sin(_OUTSIDE)])


def test_64_total_reflections_of_a_view_lose_nothing():
    b, beam = light_guide([], glow=1.0)
    b.set_camera(scenes.camera(-beam, (0, 0, 0), 2, 2, up=(0, 1, 0), fov=1e-6))
    found = shot(b.build(), passes=1024, camera_depth=DEPTH)["emission"].mean()
    note(found, PASSED)
    # 4096 paths that pass or not; level 0.001.
    low, high = binom.ppf((0.0005, 0.9995), 4096, PASSED) / 4096
    assert low - 1e-5 <= found <= high + 1e-5


def test_64_total_reflections_of_photons_lose_nothing():
    b, beam = light_guide([diffuse(0.5)])
    half_angle, intensity, emitted = 1e-4, 1e9, 40_000
    matrix = scenes.look_at(-0.5 * beam, (0, 0, 0))
    b.add_spot_light("beam", matrix, intensity, half_angle)
    b.set_camera(scenes.camera((BAR, -2, 0), (BAR + 1, 0, -1), 4, 4))
    settings = Settings(photon_depth=DEPTH)
    walk = trace_batch(
        prepare(b.build(), settings), settings, 0, Batch(False, 0, emitted, emitted)
    )
    power = 4 * np.pi * intensity * np.sin(half_angle / 2) ** 2
    found = walk.photons["flux"][:, 0].sum(dtype=np.float64) / power
    note(found, PASSED)
    low, high = binom.ppf((0.0005, 0.9995), emitted, PASSED) / emitted
    assert low - 1e-5 <= found <= high + 1e-5


def test_albedo_1_stays_finite_and_bounded():
    """A closed white box has no steady state: photon_depth bounds what is shown."""
    b = SceneBuilder("white")
    b.add_mesh("box", *scenes.box((-1, -1, -1), (1, 1, 1)),
               b.add_material("w", [diffuse(1.0)]))  # fmt: skip
    b.add_point_light("lamp", (0, 0, 0.5), 1.0, 0.05)
    b.set_camera(scenes.camera((0, 0, -0.5), (1, 0.3, 0), 8, 8))
    depth = 32
    found = shot(b.build(), photon_depth=depth)
    # E of the n-th flight is 4 pi I / A; the gather reaches ``depth`` of them.
    each = 4 * np.pi / 24 / np.pi
    note(found["indirect"], depth * each)
    assert found["indirect"].mean() == pytest.approx(depth * each, rel=0.1)


def test_white_paint_in_a_white_furnace_is_white():
    b = SceneBuilder("white furnace")
    b.add_mesh("ball", *scenes.sphere((0, 0, 0), 1.0, 2),
               b.add_material("w", [diffuse(1.0)]))  # fmt: skip
    b.set_world(1.0)
    b.set_camera(scenes.camera((0, -3, 0.3), (0, 0, 0), 8, 8))
    # A convex body sees nothing but the sky.
    found = shot(b.build())["total"]
    note(found, 1.0)
    np.testing.assert_allclose(found.mean(), 1.0, rtol=1e-5)
