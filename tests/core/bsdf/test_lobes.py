"""Non-specular lobes: chi-square of sample and pdf, furnace, reciprocity (level 0.01)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from photon_map.core.bsdf.dispatch import (
    eval_nonspecular,
    is_lambertian,
    lobe_weights,
    pdf_nonspecular,
    sample_nonspecular,
)
from photon_map.core.scene.builder import SceneBuilder, diffuse, mirror, phong
from photon_map.tests.statistics import (
    chi_square,
    same_means,
    sphere_counts,
    sphere_integrals,
)

COUNT = 60_000
CASES = {
    "diffuse": [diffuse(0.7)],
    "phong": [phong(0.8, 12.0)],
    "flat phong": [phong(0.8, 0.0)],
    "mixed": [diffuse((0.5, 0.2, 0.1)), mirror(0.3), phong((0.1, 0.2, 0.4), 30.0)],
}
NORMAL = tuple(np.array([2.0, -1.0, 2.0]) / 3)


def tables(lobes):
    b = SceneBuilder("lobes")
    b.add_material("black", [])
    row = b.add_material("tested", lobes)
    scene = b.build()
    return scene.materials[row], scene.lobes


def arriving(normal, degrees):
    """A direction at an angle from ``normal``."""
    n = np.array(normal)
    side = np.cross(n, (0.0, 0.6, 0.8))
    theta = math.radians(degrees)
    return tuple(math.cos(theta) * n + math.sin(theta) * side / np.linalg.norm(side))


@njit
def draw(material, lobes, n, wo, u):
    out = np.empty((len(u), 3))
    for k in range(len(u)):
        wi = sample_nonspecular(material, lobes, n, wo, u[k, 0], u[k, 1], u[k, 2])
        out[k, 0], out[k, 1], out[k, 2] = wi
    return out


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("degrees", [0, 50, 85])
def test_directions_follow_their_density(name, degrees, rng):
    material, lobes = tables(CASES[name])
    wo = arriving(NORMAL, degrees)
    wi = draw(material, lobes, NORMAL, wo, rng.random((COUNT, 3)))
    np.testing.assert_allclose(np.linalg.norm(wi, axis=1), 1, rtol=1e-9)
    density = np.array([pdf_nonspecular(material, lobes, NORMAL, wo, tuple(w)) for w in wi])
    # What lies below the surface has no density and is lost: a cell of its own.
    below = wi @ NORMAL <= 0
    assert (density[below] == 0).all() and (density[~below] > 0).all()
    counts = sphere_counts(wi[~below], 8, 16)
    expected = COUNT * sphere_integrals(
        lambda x, y, z: pdf_nonspecular(material, lobes, NORMAL, wo, (x, y, z)), 8, 16, 8
    )
    lost = COUNT - expected.sum()
    assert lost > -1e-4 * COUNT
    chi_square(np.append(counts, below.sum()), np.append(expected, max(lost, 0)), tests=12)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("degrees", [0, 50, 85])
def test_furnace_returns_no_more_than_came(name, degrees, rng):
    material, lobes = tables(CASES[name])
    wo = arriving(NORMAL, degrees)
    shares = np.zeros((20_000, 3))
    for k, w in enumerate(draw(material, lobes, NORMAL, wo, rng.random((20_000, 3)))):
        wi = tuple(w)
        pdf_w = pdf_nonspecular(material, lobes, NORMAL, wo, wi)
        if pdf_w > 0:
            f = eval_nonspecular(material, lobes, NORMAL, wo, wi)
            shares[k] = np.array(f) * (w @ NORMAL) / pdf_w
    albedo = sum(np.array(b.weight) for b in CASES[name] if b.model <= 1)
    spread = shares.var(axis=0) / len(shares)
    assert (shares.mean(axis=0) <= albedo + 5 * np.sqrt(spread) + 1e-12).all()
    if degrees == 0 or name == "diffuse":
        same_means(shares.mean(axis=0), spread, albedo, floor=1e-12)


@given(
    a=st.floats(0, 1.55), b=st.floats(0, 1.55), phi=st.floats(0, 6.3),
    name=st.sampled_from(sorted(CASES)),
)  # fmt: skip
def test_light_may_run_either_way(a, b, phi, name):
    material, lobes = tables(CASES[name])
    up = (0.0, 0.0, 1.0)
    wo = (math.sin(a), 0.0, math.cos(a))
    wi = (math.sin(b) * math.cos(phi), math.sin(b) * math.sin(phi), math.cos(b))
    there = eval_nonspecular(material, lobes, up, wo, wi)
    back = eval_nonspecular(material, lobes, up, wi, wo)
    np.testing.assert_allclose(there, back, rtol=1e-9, atol=1e-12)


def test_below_the_surface_nothing_is_scattered():
    material, lobes = tables(CASES["mixed"])
    up, wo = (0.0, 0.0, 1.0), (0.0, 0.6, 0.8)
    assert eval_nonspecular(material, lobes, up, wo, (0.6, 0.0, -0.8)) == (0, 0, 0)
    assert pdf_nonspecular(material, lobes, up, wo, (0.6, 0.0, -0.8)) == 0


def test_weights_are_split_between_wide_and_specular_lobes():
    material, lobes = tables(CASES["mixed"])
    rough, smooth = lobe_weights(material, lobes)
    assert rough == pytest.approx((0.6 + 0.4 + 0.5) / 3) and smooth == pytest.approx(0.3)
    assert not is_lambertian(material, lobes)
    assert is_lambertian(*tables(CASES["diffuse"]))
