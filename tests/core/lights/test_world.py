"""The map of the surroundings: what a direction shows, and how directions are drawn."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.lights.world import (
    pdf_map,
    pdf_world,
    sample_beam,
    sample_map,
    sample_world,
    world_of,
    world_radiance,
)
from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene.builder import SceneBuilder, diffuse, mirror
from photon_map.core.scene.tables import Visibility
from photon_map.tests import scenes
from photon_map.tests.statistics import chi_square, same_means, sphere_counts, sphere_integrals

COUNT = 40_000
TURN = scenes.look_at((0, 0, 0), (1, 2, 3))[:3, :3]
UP = (0.0, 0.0, 1.0)


def spotted(rows=6, columns=9):
    """A dim map with strong spots, one of them in a row of the pole."""
    texels = np.full((rows, columns, 3), 0.1)
    texels[rows // 2, columns // 3] = (9, 3, 1)
    texels[0, 2] = (1, 9, 3)
    return texels


def world(texels, rotation=TURN, radiance=0.5):
    b = SceneBuilder("sky")
    b.set_world(radiance, texels, rotation)
    return world_of(b.build())


@pytest.mark.parametrize(
    ("direction", "column"),
    [((1, 0, 0), 0.5), ((0, 1, 0), 0.25), ((0, -1, 0), 0.75), ((-1, 1e-9, 0), 0.0)],
)
def test_columns_run_from_minus_x_over_y_as_in_cycles(direction, column):
    # Found by rendering a marked map with Cycles 5.0 and 5.2.
    texels = np.zeros((4, 8, 3))
    texels[:, :, 0] = np.arange(8)
    between = (column * 8 - 0.5) % 8
    low, high = int(between), (int(between) + 1) % 8
    t = between - int(between)
    expected = 0.5 * (low * (1 - t) + high * t)
    found = world_radiance(world(texels, np.eye(3)), direction)
    assert found[0] == pytest.approx(expected, abs=1e-6)


def test_rows_run_from_straight_down_to_straight_up():
    texels = np.zeros((4, 8, 3))
    texels[:, :, 1] = np.arange(4)[:, None]
    sky = world(texels, np.eye(3), 1.0)
    assert world_radiance(sky, (0.0, 1.0, 0.0))[1] == pytest.approx(1.5)
    assert world_radiance(sky, (0.0, np.sqrt(0.5), np.sqrt(0.5)))[1] == pytest.approx(2.5)


def test_directions_are_drawn_as_their_density_says(rng):
    sky = world(spotted())
    drawn = [sample_map(sky, u, v) for u, v in rng.random((COUNT, 2))]
    directions = np.array([d for d, _ in drawn])
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1, rtol=1e-12)
    density = np.array([pdf_map(sky, tuple(d)) for d in directions])
    np.testing.assert_allclose(density, [p for _, p in drawn], rtol=1e-6)
    # In the map's frame its cells are cells of latitude; columns run against the azimuth.
    local = directions @ TURN.T
    latitude = np.arcsin(np.clip(local[:, 2], -1, 1)) / np.pi + 0.5
    column = 0.5 - np.arctan2(local[:, 1], local[:, 0]) / (2 * np.pi)
    counts = np.histogram2d(latitude, column, (6, 9), ((0, 1), (0, 1)))[0]
    rows = np.diff(sky.rows, prepend=0)[:, None]
    expected = rows * np.diff(sky.columns, prepend=0, axis=1) * COUNT
    chi_square(counts[expected > 5], expected[expected > 5])
    assert counts[expected == 0].sum() == 0


@pytest.mark.parametrize("draw", ["surface", "beam"])
def test_the_mixture_is_drawn_as_its_density_says(draw, rng):
    sky = world(spotted() + 0.4)
    normal = (0.6, 0.0, 0.8)
    if draw == "surface":
        drawn = [sample_world(sky, normal, u, v) for u, v in rng.random((COUNT, 2))]
    else:
        drawn = [sample_beam(sky, u, v) for u, v in rng.random((COUNT, 2))]
    counts = sphere_counts(np.array([d for d, _ in drawn]), 6, 12)

    def density(x, y, z):
        if draw == "surface":
            return pdf_world(sky, normal, (x, y, z))
        part = pdf_map(sky, (x, y, z))
        return sky.flat / (4 * np.pi) + (1 - sky.flat) * part

    expected = sphere_integrals(density, 6, 12, order=24)
    assert expected.sum() == pytest.approx(1, abs=2e-3)
    chi_square(counts, expected / expected.sum() * COUNT, tests=2)


def test_wherever_there_is_light_there_is_density(rng):
    texels = np.zeros((6, 9, 3))
    texels[2, 4] = 1.0
    sky = world(texels)
    directions = rng.normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    shines = np.array([max(world_radiance(sky, tuple(d))) > 0 for d in directions])
    density = np.array([pdf_map(sky, tuple(d)) for d in directions])
    assert 0.01 < shines.mean() < 0.2
    assert (density[shines] > 0).all()


def test_an_even_map_is_drawn_by_the_cosine():
    sky = world(np.full((16, 32, 3), 2.0))
    assert sky.flat == pytest.approx(1)
    assert sky.mean == pytest.approx(1)
    assert pdf_world(sky, UP, (0.6, 0.0, 0.8)) == pytest.approx(0.8 / np.pi)


def film(scene, passes=64, **options):
    settings = Settings(passes=passes, pixel_filter="BOX", filter_width=1.0, **options)
    return list(render(scene, settings))[-1].film


@pytest.mark.parametrize("tilt", [False, True])
def test_irradiance_under_a_sky_of_cosine_theta(tilt):
    """L = max(0, cos theta) lights a level floor by 2 pi / 3."""
    rows = np.sin((np.arange(512) + 0.5) / 512 * np.pi - np.pi / 2)
    texels = np.repeat(np.maximum(rows, 0)[:, None, None] * (1.0, 0.5, 2.0), 16, axis=1)
    turn = TURN if tilt else np.eye(3)
    b = SceneBuilder("cosine sky")
    # The sky's zenith is the direction that the rotation takes to +z: the floor faces it.
    points, faces = scenes.plane(4.0)
    b.add_mesh("floor", points @ turn, faces, b.add_material("floor", [diffuse(0.8)]))
    b.set_world(1.5, texels, turn)
    b.set_camera(scenes.camera(turn.T @ (0, 0, 3), (0, 0, 0), 4, 4, up=turn.T @ (0, 1, 0)))
    found = film(b.build(), 256).resolve("direct").mean(axis=(0, 1))
    expected = 0.8 / np.pi * 1.5 * 2 * np.pi / 3 * np.array([1.0, 0.5, 2.0])
    np.testing.assert_allclose(found, expected, rtol=3e-3)


def test_each_layer_under_a_map_agrees_with_the_reference():
    b = SceneBuilder("map")
    b.add_mesh("floor", *scenes.plane(2.0), b.add_material("floor", [diffuse(0.7)]))
    # What throws caustics and what throws light stand off the floor that is seen.
    tall = scenes.quad((-2, 1.5, 0), (2, 1.5, 0), (2, 1.5, 1.5), (-2, 1.5, 1.5))
    b.add_mesh("mirror", *tall, b.add_material("mirror", [mirror(0.9)]))
    side = scenes.quad((1.2, 1.2, 0), (1.2, -2, 0), (1.2, -2, 1.5), (1.2, 1.2, 1.5))
    b.add_mesh("wall", *side, b.add_material("wall", [diffuse(0.7)]))
    b.set_world(1.0, spotted(12, 24), TURN)
    b.set_camera(scenes.camera((0, -3, 3), (0, 0, 0), 8, 8, fov=0.35))
    scene = b.build()
    expected = trace(scene, 4000, seed=2)
    runs = [film(scene, 32, seed=k, photons_caustic=16384) for k in range(6)]
    for name, bias in (
        ("direct", 0.0),
        ("caustics", 0.01),
        ("indirect", 0.02),
    ):
        values = np.array([run.resolve(name).astype(float).mean(axis=(0, 1)) for run in runs])
        mean = expected[name].mean(axis=(0, 1))
        same_means(
            values.mean(axis=0), values.var(axis=0, ddof=1) / 6, mean,
            expected.variance[name].mean(axis=(0, 1)) / 64,
            floor=bias * mean + 1e-9, freedom=5,
        )  # fmt: skip


def test_a_world_hidden_from_a_kind_of_ray():
    for hidden, black in ((Visibility.CAMERA, "emission"), (Visibility.DIFFUSE, "direct")):
        b = SceneBuilder("hidden")
        b.add_mesh("floor", *scenes.plane(0.5), b.add_material("floor", [diffuse(0.7)]))
        b.set_world(1.0, spotted(), visibility=Visibility.ALL & ~hidden)
        b.set_camera(scenes.camera((0, 0, 3), (0, 0, 0), 4, 4, up=(0, 1, 0)))
        found = film(b.build(), 4)
        for layer in ("emission", "direct"):
            assert (found.resolve(layer).max() == 0) == (layer == black)
