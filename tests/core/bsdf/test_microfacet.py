"""Microfacets: reciprocity, closed forms of Fresnel, limits, and numbers that stay finite."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from photon_map.core.bsdf.dispatch import NARROW, WIDE
from photon_map.core.bsdf.fresnel import (
    fresnel_dielectric,
    fresnel_f82,
    fresnel_rise,
    reflect,
    refract,
)
from photon_map.core.bsdf.microfacet import (
    distribution,
    eval_ggx,
    masking,
    pdf_ggx,
    sample_visible_normal,
)
from photon_map.core.bsdf.oren_nayar import (
    albedo_oren_nayar,
    eval_oren_nayar,
    mean_albedo_oren_nayar,
)
from photon_map.core.bsdf.rough_dielectric import eval_refraction, pdf_refraction
from photon_map.core.scene import closures as c
from photon_map.core.scene import lobes as m
from photon_map.core.scene.tables import Fresnel
from tests.statistics import integral, same_means
from tests.surfaces import UP, Resolver, albedo, direction, of_lobes, samples, weights

DOWN = (0.0, 0.0, -1.0)
ALPHAS = st.floats(1e-4, 1.0)
ANGLES = st.floats(0.0, math.pi / 2 - 1e-6)
TURNS = st.floats(0.0, 6.3)


def towards(theta, phi=0.0, sign=1.0):
    s = math.sin(theta)
    return s * math.cos(phi), s * math.sin(phi), sign * math.cos(theta)


@pytest.mark.parametrize("alpha", [0.05, 0.3, 1.0])
def test_facets_cover_the_plane_and_are_seen_as_masking_says(alpha):
    def projected(cosine):
        return distribution(cosine, alpha) * cosine * 2 * math.pi

    assert integral(projected, 0, 1) == pytest.approx(1.0, rel=1e-6)
    # The visible area along a direction is its cosine (Heitz 2014, equation 14).
    theta, azimuths = 1.1, (np.arange(720) + 0.5) * math.pi / 360
    wo = np.array(towards(theta))

    def visible(cosine):
        s = math.sqrt(1 - cosine * cosine)
        h = np.stack([s * np.cos(azimuths), s * np.sin(azimuths), 0 * azimuths + cosine])
        facing = np.maximum(0.0, wo @ h).mean() * 2 * math.pi
        return distribution(cosine, alpha) * facing * masking(wo[2], alpha)

    assert integral(visible, 0, 1) == pytest.approx(math.cos(theta), rel=2e-3)


@given(a=ANGLES, b=ANGLES, phi=TURNS, alpha=ALPHAS)
def test_reflection_may_run_either_way(a, b, phi, alpha):
    wo, wi = towards(a), towards(b, phi)
    there, back = eval_ggx(UP, wo, wi, alpha), eval_ggx(UP, wi, wo, alpha)
    assert there == pytest.approx(back, rel=1e-6) and 0.0 <= there < math.inf
    assert 0.0 <= pdf_ggx(UP, wo, wi, alpha) < math.inf


@given(a=ANGLES, b=ANGLES, phi=TURNS, alpha=ALPHAS, eta=st.floats(0.4, 2.5))
def test_refraction_may_run_either_way_up_to_the_index_squared(a, b, phi, alpha, eta):
    wo, wi = towards(a), towards(b, phi, -1.0)
    there = eval_refraction(UP, wo, wi, alpha, eta) * eta * eta
    back = eval_refraction(DOWN, wi, wo, alpha, 1 / eta)
    assert there == pytest.approx(back, rel=1e-5, abs=1e-200)
    assert 0.0 <= there < math.inf
    assert 0.0 <= pdf_refraction(UP, wo, wi, alpha, eta) < math.inf


@pytest.mark.parametrize("roughness", [0.3, 0.7])
def test_flux_through_rough_glass_is_the_same_both_ways(roughness, rng):
    # In light from all sides the flux inwards over that outwards is the index squared.
    flux = []
    for entering in (True, False):
        mean = []
        for degrees in np.degrees(np.arccos(np.sqrt((np.arange(40) + 0.5) / 40))):
            glass = Resolver(c.rough_glass(1.5, roughness, multiscatter=False))
            surface = glass(degrees, entering)
            total = 0.0
            for part, share in zip((WIDE, NARROW), weights(surface), strict=True):
                if share > 0.0:
                    drawn = samples(surface, part, 8000, rng)
                    total += (drawn[:, 4] * (drawn[:, 8] > 0)).mean()
            mean.append(total)
        flux.append(np.mean(mean))
    assert flux[0] == pytest.approx(flux[1] * 1.5**2, rel=0.01)


@given(f0=st.floats(0, 1), tint=st.floats(0, 1))
def test_f82_meets_its_three_values(f0, tint):
    schlick = f0 + (1 - f0) * (6 / 7) ** 5
    assert fresnel_f82(1.0, f0, tint) == pytest.approx(f0, abs=1e-12)
    assert fresnel_f82(1 / 7, f0, tint) == pytest.approx(schlick * tint, abs=1e-12)
    assert fresnel_f82(0.0, f0, tint) == pytest.approx(1.0)


@given(cosine=st.floats(0, 1), eta=st.floats(0.3, 3.0))
def test_rise_is_the_dielectric_curve_from_its_own_start(cosine, eta):
    f0 = ((eta - 1) / (eta + 1)) ** 2
    if f0 < 1e-6:
        return
    expected = fresnel_dielectric(cosine, eta)[0]
    found = f0 + (1 - f0) * fresnel_rise(cosine, eta)
    # Below Brewster's angle the true curve dips under its start; the rise does not.
    assert found == pytest.approx(max(expected, f0), abs=1e-9)


@pytest.mark.parametrize("alpha", [1e-4, 3e-4, 1e-3])
def test_narrow_facets_tend_to_the_mirror(alpha, rng):
    for degrees in (0.0, 45.0, 80.0):
        surface = of_lobes([m.ggx(0.7, alpha**0.5, Fresnel.DIELECTRIC, ior=1.5)], degrees)
        drawn = samples(surface, NARROW, 20_000, rng)
        mirror = np.array(reflect(surface.wo, UP))
        away = np.linalg.norm(drawn[:, 1:4] - mirror, axis=1)
        assert np.median(away) < 4 * alpha
        expected = 0.7 * fresnel_dielectric(surface.wo[2], 1.5)[0]
        same_means(
            drawn[:, 4].mean(), drawn[:, 4].var() / len(drawn), expected, floor=0.01 * expected
        )


def test_narrow_rough_glass_tends_to_smooth_glass(rng):
    for entering in (True, False):
        rough = Resolver(c.rough_glass(1.5, 0.02))(35.0, entering)
        smooth = Resolver(c.rough_glass(1.5, 0.0))(35.0, entering)
        drawn, sharp = (samples(s, NARROW, 20_000, rng) for s in (rough, smooth))
        passed = drawn[:, 8] > 0
        _, cos_t = fresnel_dielectric(rough.wo[2], rough.eta)
        straight = np.array(refract(rough.wo, UP, rough.eta, cos_t))
        away = np.linalg.norm(drawn[passed, 1:4] - straight, axis=1)
        assert np.median(away) < 2e-3
        share = sharp[:, 8].mean()
        same_means(passed.mean(), share * (1 - share) / 10_000, share)


@given(u=st.floats(0, 1, exclude_max=True), v=st.floats(0, 1, exclude_max=True),
       cosine=st.floats(0.0, 1.0), alpha=ALPHAS)  # fmt: skip
def test_visible_normals_are_unit_and_face_the_viewer(u, v, cosine, alpha):
    wo = (math.sqrt(1 - cosine * cosine), 0.0, cosine)
    h = sample_visible_normal(UP, wo, alpha, u, v)
    assert math.hypot(*h) == pytest.approx(1.0, abs=1e-9)
    assert h[2] >= 0.0 and np.dot(h, wo) >= -1e-9


@pytest.mark.parametrize("cosine", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("roughness", [0.01, 0.02, 0.3, 1.0])
def test_grazing_stays_finite(cosine, roughness, rng):
    degrees = math.degrees(math.acos(cosine))
    closures = (
        c.glossy(1.0, roughness), c.rough_glass(1.5, roughness),
        c.rough_glass(1.0 / 1.5, roughness),
        c.principled(color=0.8, roughness=roughness, coat=1.0, sheen=1.0, metallic=0.3),
    )  # fmt: skip
    for closure in closures:
        surface = Resolver(closure)(degrees)
        found, _ = albedo(surface, 4000, rng)
        assert np.isfinite(found).all() and (found < 1.15).all()
        for part in (WIDE, NARROW):
            assert np.isfinite(samples(surface, part, 500, rng)).all()


@pytest.mark.parametrize("eta", [1.0, 1 + 1e-6, 1 - 1e-6, 1 + 1e-3])
def test_glass_of_no_index_lets_light_straight_through(eta, rng):
    surface = Resolver(c.rough_glass(eta, 0.5))(60.0)
    drawn = samples(surface, NARROW, 2000, rng)
    assert (drawn[:, 8] > 0).mean() > 0.999
    away = np.linalg.norm(drawn[:, 1:4] + np.array(surface.wo), axis=1)
    assert np.median(away) <= 2 * abs(eta - 1) + 1e-12
    found, _ = albedo(surface, 20_000, rng)
    assert found[0] == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("roughness", [0.0, 0.4, 1.0])
def test_oren_nayar_has_its_closed_albedo(roughness, rng):
    for degrees in (0.0, 40.0, 80.0):
        wo = direction(degrees)
        z, phi = (np.arange(200) + 0.5) / 200, (np.arange(200) + 0.5) / 200 * 2 * np.pi
        dark = (1e-6, 1e-6, 1e-6)
        values = [
            eval_oren_nayar(UP, wo, towards(math.acos(a), b), roughness, dark)[0] * a
            for a in z for b in phi
        ]  # fmt: skip
        found = np.mean(values) * 2 * math.pi
        assert found == pytest.approx(albedo_oren_nayar(wo[2], roughness), rel=2e-3)
        white, _ = albedo(of_lobes([m.oren_nayar(1.0, roughness)], degrees), 40_000, rng)
        assert white[0] == pytest.approx(1.0, abs=0.01)
    mean = integral(lambda x: 2 * x * albedo_oren_nayar(x, roughness), 0, 1)
    assert mean == pytest.approx(mean_albedo_oren_nayar(roughness), rel=1e-6)
