"""Smooth interfaces against closed forms, from normal incidence to grazing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from photon_map.core.bsdf.dielectric import sample_dielectric, sample_refraction
from photon_map.core.bsdf.fresnel import fresnel_dielectric, reflect, refract
from photon_map.tests.statistics import same_means

UP = (0.0, 0.0, 1.0)
ANGLES = st.floats(0.001, math.pi / 2 - 1e-6)
ETAS = st.one_of(st.floats(1.001, 4.0), st.floats(0.25, 0.999))


def arriving(theta):
    return (math.sin(theta), 0.0, math.cos(theta))


@given(theta=ANGLES, eta=ETAS)
def test_reflectance_is_fresnels_sine_and_tangent_law(theta, eta):
    found, cos_t = fresnel_dielectric(math.cos(theta), eta)
    sine = math.sin(theta) / eta
    if sine >= 1:
        assert (found, cos_t) == (1.0, 0.0)
        return
    t = math.asin(sine)
    s = (math.sin(theta - t) / math.sin(theta + t)) ** 2
    p = (math.tan(theta - t) / math.tan(theta + t)) ** 2
    # Near the critical angle the closed form itself loses digits.
    assert found == pytest.approx((s + p) / 2, rel=1e-5, abs=1e-9)
    assert cos_t == pytest.approx(math.cos(t), abs=1e-6)


@pytest.mark.parametrize("n", [1.33, 1.5, 2.4])
def test_normal_incidence_and_brewsters_angle(n):
    assert fresnel_dielectric(1.0, n)[0] == pytest.approx(((n - 1) / (n + 1)) ** 2, rel=1e-14)
    brewster = math.atan(n)
    # There the parallel part vanishes, and the rays are at right angles.
    expected = math.cos(2 * brewster) ** 2 / 2
    assert fresnel_dielectric(math.cos(brewster), n)[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("n", [1.0001, 1.33, 1.5, 3.0])
def test_total_internal_reflection_on_both_sides_of_the_critical_angle(n):
    critical = math.asin(1 / n)
    beyond, before = critical + 1e-6, critical - 1e-6
    assert fresnel_dielectric(math.cos(beyond), 1 / n) == (1.0, 0.0)
    reflectance, cos_t = fresnel_dielectric(math.cos(before), 1 / n)
    assert reflectance < 1.0
    # cos_t from the series of Snell's law at the critical angle.
    assert cos_t == pytest.approx(math.sqrt(2e-6 * math.sqrt(n * n - 1)), rel=1e-2)
    assert sample_dielectric(UP, arriving(beyond), 1 / n, 1 - 1e-16)[1] is False
    assert sample_refraction(UP, arriving(beyond), 1 / n)[1] is False
    assert sample_refraction(UP, arriving(before), 1 / n)[1] is True


@pytest.mark.parametrize("eta", [1 / 1.5, 1.5])
def test_grazing_light_is_reflected_and_stays_finite(eta):
    for cosine in (1e-6, 1e-12, 1e-300, 0.0):
        reflectance, cos_t = fresnel_dielectric(cosine, eta)
        assert 1 - 20e-6 <= reflectance <= 1.0 and math.isfinite(cos_t)
        # First order of the equations: 1 - F = 2 cos (eta + 1 / eta ...) for eta above 1.
    slope = (1 - fresnel_dielectric(1e-6, 1.5)[0]) / 1e-6
    assert slope == pytest.approx(2 * (1.5**2 + 1) / math.sqrt(1.5**2 - 1), rel=1e-4)


@given(theta=ANGLES, eta=ETAS)
def test_both_sides_reflect_alike(theta, eta):
    reflectance, cos_t = fresnel_dielectric(math.cos(theta), eta)
    if reflectance < 1:
        back, cos_i = fresnel_dielectric(cos_t, 1 / eta)
        assert back == pytest.approx(reflectance, rel=1e-4, abs=1e-9)
        assert cos_i == pytest.approx(math.cos(theta), abs=1e-6)


@given(theta=st.floats(0.0, math.pi / 2), u=st.floats(0, 1, exclude_max=True))
def test_index_one_passes_straight_at_any_angle(theta, u):
    wo = arriving(theta)
    wi, transmitted = sample_dielectric(UP, wo, 1.0, u)
    assert transmitted
    np.testing.assert_allclose(wi, np.negative(wo), rtol=0, atol=1e-16)


@given(theta=ANGLES, phi=st.floats(0, 6.3), eta=ETAS)
def test_refracted_ray_obeys_snell_and_runs_back(theta, phi, eta):
    wo = np.array([math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), 0])
    wo[2] = math.cos(theta)
    reflectance, cos_t = fresnel_dielectric(wo[2], eta)
    if reflectance >= 1:
        return
    wi = np.array(refract(tuple(wo), UP, eta, cos_t))
    assert np.linalg.norm(wi) == pytest.approx(1, abs=1e-12)
    assert wi[2] <= 0
    # Tangential parts are opposite and scaled by the index: Snell, in one plane.
    np.testing.assert_allclose(eta * wi[:2], -wo[:2], atol=1e-12)
    back_t = fresnel_dielectric(-wi[2], 1 / eta)[1]
    back = refract(tuple(wi), (0.0, 0.0, -1.0), 1 / eta, back_t)
    np.testing.assert_allclose(back, wo, atol=1e-6)


@given(theta=ANGLES)
def test_mirror_direction_keeps_the_angle(theta):
    wi = reflect(arriving(theta), UP)
    np.testing.assert_allclose(wi, (-math.sin(theta), 0, math.cos(theta)), atol=1e-15)


@pytest.mark.parametrize("degrees", [0, 45, 80])
def test_reflection_is_drawn_as_often_as_fresnel_says(degrees, rng):
    wo = arriving(math.radians(degrees))
    expected = fresnel_dielectric(wo[2], 1.5)[0]
    drawn = [not sample_dielectric(UP, wo, 1.5, u)[1] for u in rng.random(50_000)]
    same_means(np.mean(drawn), expected * (1 - expected) / 50_000, expected)
