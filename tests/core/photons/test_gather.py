"""The grid gather against cKDTree, and its estimate against a known photon density."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from photon_map.core.photons.gather import (
    LEAST_COSINE,
    gather_radiance,
)
from photon_map.core.photons.photon_map import build_photon_map
from photon_map.core.photons.rows import MOST_HEIGHT, largest_radius
from photon_map.core.photons.sight import SIGHT
from photon_map.core.photons.trace import PHOTON, Walk
from photon_map.core.scene.builder import SceneBuilder, diffuse, phong
from photon_map.tests.statistics import same_means

#: Nothing runs through the disc.
ALL = np.zeros(SIGHT)
UP = (0.0, 0.0, 1.0)
WO = (0.6, 0.0, 0.8)


def material(lobes):
    b = SceneBuilder("gather")
    b.add_material("tested", lobes)
    scene = b.build()
    return scene.materials[0], scene.lobes


def photons(rng, count, extent, offset=0.0):
    """Photons near z = 0, most of them facing up, light from above."""
    table = np.zeros(count, PHOTON)
    place = rng.random((count, 3)) * extent - extent / 2 + offset
    place[:, 2] = rng.normal(0, 0.02 * extent, count)
    table["position"] = place
    normal = rng.normal(0, 0.4, (count, 3)) + UP
    table["normal"] = normal / np.linalg.norm(normal, axis=1)[:, None]
    direction = rng.normal(0, 1, (count, 3)) + UP
    direction[:, 2] = np.abs(direction[:, 2])
    table["direction"] = direction / np.linalg.norm(direction, axis=1)[:, None]
    table["flux"] = rng.random((count, 3))
    return table


def photon_map(table, cell):
    return build_photon_map([Walk(table, np.arange(len(table)), 0)], cell)


def by_tree(table, p, radius, brdf, high=None):
    """The same estimate in NumPy over the tree's neighbours: (Lo, count)."""
    high = MOST_HEIGHT * radius if high is None else high
    position = table["position"].astype(float)
    tree = cKDTree(position)
    reach = np.hypot(radius, high)
    near = np.array(tree.query_ball_point(p, reach), dtype=int)
    gap = position[near] - p
    across2 = (gap[:, :2] ** 2).sum(axis=1)
    facing = table["normal"][near, 2] >= np.float32(LEAST_COSINE)
    keep = (across2 < radius**2) & (np.abs(gap[:, 2]) <= high) & facing
    kernel = 2 / (np.pi * radius**2) * (1 - across2[keep] / radius**2)
    f = brdf(table["direction"][near[keep]].astype(float))
    # The surface's area in its shadow on the tangent plane.
    cosine = table["normal"][near[keep], 2].astype(float)
    light = f * table["flux"][near[keep]] * (kernel * cosine)[:, None]
    return light.sum(axis=0), int(keep.sum())


def lambert(direction):
    return np.full((len(direction), 1), 0.5 / np.pi)


def glossy(direction):
    mirrored = (-WO[0], 0.0, WO[2])
    cosine = np.clip(direction @ mirrored, 0, None)
    return (0.5 / np.pi + 0.4 * 7 / (2 * np.pi) * cosine**5)[:, None]


@pytest.mark.parametrize("ratio", [0.1, 0.5, 1.0, 5.9])
@pytest.mark.parametrize("offset", [0.0, -1000.0])
def test_grid_finds_what_the_tree_finds(ratio, offset, rng):
    table = photons(rng, 4000, 2.0, offset)
    radius = 0.12
    grid = photon_map(table, radius / ratio)
    row, lobes = material([diffuse(0.5)])
    for xy in rng.random((60, 2)) * 2.4 - 1.2 + offset:
        p = (float(xy[0]), float(xy[1]), 0.0)
        found, inner, count = gather_radiance(grid, p, UP, UP, WO, radius, row, lobes, ALL)
        expected, number = by_tree(table, p, radius, lambert)
        assert count == number
        np.testing.assert_allclose(found, expected, rtol=1e-9)
        half, _ = by_tree(table, p, radius / np.sqrt(2), lambert, MOST_HEIGHT * radius)
        np.testing.assert_allclose(inner, half, rtol=1e-9)


def test_glossy_surfaces_weigh_each_photon_by_its_direction(rng):
    table = photons(rng, 4000, 2.0)
    grid = photon_map(table, 0.3)
    row, lobes = material([diffuse(0.5), phong(0.4, 5.0)])
    for xy in rng.random((40, 2)) * 2 - 1:
        p = (float(xy[0]), float(xy[1]), 0.0)
        found, inner, _ = gather_radiance(grid, p, UP, UP, WO, 0.2, row, lobes, ALL)
        expected, _ = by_tree(table, p, 0.2, glossy)
        np.testing.assert_allclose(found, expected, rtol=1e-6)
        half, _ = by_tree(table, p, 0.2 / np.sqrt(2), glossy, MOST_HEIGHT * 0.2)
        np.testing.assert_allclose(inner, half, rtol=1e-6)


def test_a_radius_beyond_the_grids_reach_is_cut(rng):
    table = photons(rng, 500, 2.0)
    grid = photon_map(table, 0.05)
    row, lobes = material([diffuse(0.5)])
    most = largest_radius(0.05)
    cut = gather_radiance(grid, (0.1, 0.0, 0.0), UP, UP, WO, 10.0, row, lobes, ALL)
    assert cut == gather_radiance(grid, (0.1, 0.0, 0.0), UP, UP, WO, most, row, lobes, ALL)


@pytest.mark.parametrize("count", [0, 1, 17])
def test_few_photons_and_none(count, rng):
    table = photons(rng, count, 0.01)
    grid = photon_map(table, 1.0)
    row, lobes = material([diffuse(0.5)])
    found, _, number = gather_radiance(grid, (0.0, 0.0, 0.0), UP, UP, WO, 0.5, row, lobes, ALL)
    expected, known = by_tree(table, (0, 0, 0), 0.5, lambert) if count else (np.zeros(3), 0)
    assert number == known
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_order_of_batches_changes_no_bit(rng):
    table = photons(rng, 1000, 1.0)
    row, lobes = material([diffuse(0.5)])
    order = rng.permutation(1000)
    cuts = [order[:300], order[300:310], order[310:]]
    shuffled = build_photon_map([Walk(table[c], c, 0) for c in cuts], 0.2)
    whole = photon_map(table, 0.2)
    for p in ((0.0, 0.0, 0.0), (0.2, -0.1, 0.0)):
        a = gather_radiance(whole, p, UP, UP, WO, 0.2, row, lobes, ALL)
        assert a == gather_radiance(shuffled, p, UP, UP, WO, 0.2, row, lobes, ALL)


def test_estimate_of_an_even_density_is_irradiance_times_albedo_over_pi(rng):
    # 1 W in 4000 photons over 4 m^2: E = 0.25 W/m^2; each query is one sample.
    row, lobes = material([diffuse(0.8)])
    found = []
    for _ in range(200):
        table = np.zeros(4000, PHOTON)
        table["position"][:, :2] = rng.random((4000, 2)) * 2 - 1
        table["normal"] = table["direction"] = UP
        table["flux"] = 1 / 4000
        grid = photon_map(table, 0.2)
        found.append(
            gather_radiance(grid, (0.1, 0.2, 0.0), UP, UP, WO, 0.2, row, lobes, ALL)[0][0]
        )
    same_means(np.mean(found), np.var(found, ddof=1) / len(found), 0.25 * 0.8 / np.pi)


def test_even_light_in_a_ball_is_even_whatever_the_radius(rng):
    # Without the area's shadow a disc of half the ball's radius finds 4 % too much.
    count = 10_000
    row, lobes = material([diffuse(0.5)])
    up = (0.0, 0.0, 1.0)
    found = []
    for _ in range(100):
        table = np.zeros(count, PHOTON)
        place = rng.normal(0, 1, (count, 3))
        place /= np.linalg.norm(place, axis=1)[:, None]
        table["position"] = place
        table["normal"] = table["direction"] = -place
        table["flux"] = 4 * np.pi / count
        grid = photon_map(table, 0.5)
        point = (0.0, 0.0, -1.0)
        found.append(gather_radiance(grid, point, up, up, up, 0.5, row, lobes, ALL)[0][0])
    same_means(np.mean(found), np.var(found, ddof=1) / 100, 0.5 / np.pi)
    assert np.std(found, ddof=1) < 0.1 * 0.5 / np.pi, "the test would see nothing"
