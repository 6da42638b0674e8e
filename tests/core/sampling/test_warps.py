"""Chi-square tests of the maps from the unit square (level 0.01 each, fixed seed)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from photon_map.core.sampling import warps
from photon_map.tests.statistics import chi_square, uniform_square

COUNT = 40_000


@pytest.fixture
def pairs(rng):
    return rng.random((COUNT, 2))


def azimuth(x, y):
    return np.arctan2(y, x) / (2 * np.pi) % 1.0


def apply(sample, pairs, *first):
    return np.array([sample(*first, u, v) for u, v in pairs])


def test_disk_is_uniform(pairs):
    x, y = apply(warps.sample_disk, pairs).T
    uniform_square(x * x + y * y, azimuth(x, y))


def test_cosine_hemisphere_has_density_cos_over_pi(pairs):
    x, y, z = apply(warps.sample_cosine_hemisphere, pairs).T
    assert z.min() >= 0
    uniform_square(z * z, azimuth(x, y))


def test_sphere_is_uniform(pairs):
    x, y, z = apply(warps.sample_sphere, pairs).T
    uniform_square((z + 1) / 2, azimuth(x, y))


@pytest.mark.parametrize("half_angle", [1e-6, 0.3, 2.5, math.pi])
def test_cone_is_uniform_in_solid_angle(pairs, half_angle):
    versine = 2 * math.sin(half_angle / 2) ** 2
    x, y, z = apply(warps.sample_cone, pairs, versine).T
    # 1 - cos from the sine: the cosine of a cone of 1e-6 rad is 1 to the last bit.
    height = (x * x + y * y) / (1 + z) if half_angle < 2 else 1 - z
    uniform_square(np.minimum(height / versine, 1), azimuth(x, y))
    np.testing.assert_allclose(x * x + y * y + z * z, 1, rtol=1e-12)


@pytest.mark.parametrize("sine", [1e-8, 0.5, 1.0])
def test_one_minus_cos_does_not_cancel(sine):
    expected = 2 * math.sin(math.asin(sine) / 2) ** 2
    assert warps.one_minus_cos(sine**2) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("blades", [3, 5, 8])
def test_polygon_is_uniform_inside_its_blades(pairs, blades):
    x, y = apply(warps.sample_polygon, pairs, blades).T
    fine, bins = 600, 12
    middle = (np.arange(fine) + 0.5) / fine * 2 - 1
    gx, gy = np.meshgrid(middle, middle, indexing="ij")
    # Inside when the direction to the nearest edge's middle stays below the apothem.
    turn = (np.arctan2(gy, gx) % (2 * np.pi / blades)) - np.pi / blades
    inside = np.hypot(gx, gy) * np.cos(turn) <= np.cos(np.pi / blades)
    area = inside.reshape(bins, fine // bins, bins, fine // bins).sum(axis=(1, 3))
    # One cell may keep a handful of points that the fine grid puts just outside.
    counts = np.histogram2d(x, y, bins, ((-1, 1), (-1, 1)))[0]
    chi_square(counts, (area + 1e-2) / (area + 1e-2).sum() * COUNT, tests=3)


def test_triangle_is_uniform(pairs):
    s, t = apply(warps.sample_triangle, pairs).T
    assert s.min() >= 0 and t.min() >= 0 and (s + t).max() <= 1
    # (1 - s - t, t / (s + t)) is the inverse of the square-root map.
    uniform_square((s + t) ** 2, t / (s + t))
