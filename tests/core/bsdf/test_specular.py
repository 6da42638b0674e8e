"""The choice between specular lobes, its weights, and the radiance scale of refraction."""

from __future__ import annotations

import math

import numpy as np
import pytest

from photon_map.core.bsdf.dispatch import NARROW, sample_part
from photon_map.core.scene.builder import (
    SceneBuilder,
    dielectric,
    diffuse,
    mirror,
    refraction,
)
from photon_map.tests.statistics import same_means

UP = (0.0, 0.0, 1.0)
WO = (math.sin(0.8), 0.0, math.cos(0.8))


def tables(lobes):
    b = SceneBuilder("specular")
    row = b.add_material("tested", lobes)
    scene = b.build()
    return scene.materials[row], scene.lobes


def events(lobes, numbers, entering=True, around=1.0, wo=WO):
    material, rows = tables(lobes)
    drawn = [
        sample_part(material, rows, UP, wo, entering, around, NARROW, *u, 0.5) for u in numbers
    ]
    assert all(event[3] == 0.0 for event in drawn), "a delta has no density"
    return [event[:3] + event[4:] for event in drawn]


def test_mean_weight_of_a_mixture_is_the_sum_of_its_lobes(rng):
    lobes = [mirror((0.1, 0.2, 0.3)), dielectric(1.5, (0.4, 0.3, 0.1)), diffuse(0.2)]
    found = events(lobes, rng.random((40_000, 2)))
    weights = np.array([weight for _, _, weight, _, _ in found])
    variance = weights.var(axis=0) / len(weights)
    same_means(weights.mean(axis=0), variance, (0.5, 0.5, 0.4))


def test_share_of_transmission_is_that_of_the_dielectric_times_one_minus_fresnel(rng):
    found = events([mirror(0.3), dielectric(1.5, 0.6)], rng.random((40_000, 2)))
    transmitted = np.array([event[3] for event in found])
    t = math.asin(math.sin(0.8) / 1.5)
    s, p = math.sin(0.8 - t) / math.sin(0.8 + t), math.tan(0.8 - t) / math.tan(0.8 + t)
    expected = 2 / 3 * (1 - (s * s + p * p) / 2)
    same_means(transmitted.mean(), expected * (1 - expected) / len(found), expected)


@pytest.mark.parametrize("around", [1.0, 1.33])
@pytest.mark.parametrize("lobe", [dielectric(1.5), refraction(1.5)])
def test_radiance_scales_of_going_in_and_out_cancel(lobe, around):
    possible, wi, _, transmitted, eta_in = events([lobe], [(0.5, 0.999)], True, around)[0]
    assert possible and transmitted
    assert eta_in == pytest.approx(1.5 / around, rel=1e-15)
    assert wi[0] == pytest.approx(-WO[0] / eta_in, rel=1e-14)
    # From inside the same way back; the side of wo is called up again.
    inside = (wi[0], wi[1], -wi[2])
    possible, out, _, transmitted, eta_out = events(
        [lobe], [(0.5, 0.999)], False, around, inside
    )[0]
    assert possible and transmitted
    assert eta_in * eta_out == pytest.approx(1.0, rel=1e-15)
    np.testing.assert_allclose(out[0], -inside[0] * 1.5 / around, rtol=1e-14)
    np.testing.assert_allclose(abs(out[2]), WO[2], rtol=1e-12)


def test_reflection_has_no_scale_and_total_reflection_ends_pure_refraction():
    _, wi, weight, transmitted, eta = events([mirror(0.4)], [(0.5, 0.5)])[0]
    assert (transmitted, eta) == (False, 1.0)
    np.testing.assert_allclose(wi, (-WO[0], 0.0, WO[2]), rtol=1e-15)
    np.testing.assert_allclose(weight, 0.4)
    possible, _, _, transmitted, eta = events([dielectric(1.5)], [(0.5, 1 - 1e-16)], False)[0]
    assert possible and not transmitted and eta == 1.0
    assert events([refraction(1.5)], [(0.5, 0.5)], False)[0][0] is False


def test_material_without_specular_lobe_scatters_nothing():
    assert events([diffuse(0.5)], [(0.5, 0.5)])[0][0] is False
    assert events([mirror(0.0)], [(0.5, 0.5)])[0][0] is False
