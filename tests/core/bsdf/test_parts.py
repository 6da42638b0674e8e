"""Every model's sampling against its density, and what the two parts of a lobe add up to."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.bsdf.dispatch import NARROW, WIDE, is_twosided, part_bit, pass_weight
from photon_map.core.scene import closures as c
from photon_map.core.scene import lobes as m
from photon_map.core.scene.tables import ClosureKind, Fresnel, Visibility
from tests.statistics import chi_square, same_means
from tests.surfaces import (
    Resolver,
    albedo,
    cells,
    main_part,
    of_lobes,
    samples,
    value,
    weights,
)

COUNT = 40_000
LOBES = {
    "diffuse": [m.diffuse(0.7)],
    "oren nayar": [m.oren_nayar(0.7, 0.8)],
    "translucent": [m.translucent(0.7)],
    "phong": [m.phong(0.7, 40.0)],
    "mirror-like": [m.ggx(0.9, 0.03)],
    "sharp": [m.ggx(0.9, 0.15)],
    "satin": [m.ggx(0.9, 0.4)],
    "roughest": [m.ggx(0.9, 1.0)],
    "metal": [m.ggx(1.0, 0.6, Fresnel.F82, f0=(0.9, 0.6, 0.2), f90=0.7)],
    "varnish": [m.ggx(1.0, 0.3, Fresnel.DIELECTRIC, ior=1.5), m.diffuse((0.5, 0.1, 0.2))],
    "mixed": [m.diffuse(0.2), m.ggx(0.3, 0.5), m.translucent(0.2), m.phong(0.1, 10.0)],
}
CLOSURES = {
    "clear frost": c.rough_glass(1.5, 0.15),
    "frost": c.rough_glass(1.5, 0.5),
    "roughest glass": c.rough_glass(2.4, 1.0),
    "nearly air": c.rough_glass(1.02, 0.6),
    "bubble": c.rough_glass(0.75, 0.4),
    "refraction": c.closure(ClosureKind.REFRACTION, color=0.9, roughness=0.5, ior=1.4),
    "sheen": c.sheen(0.9, 0.4),
    "layers": c.principled(
        color=(0.8, 0.3, 0.1), roughness=0.4, metallic=0.3, transmission=0.4, coat=0.5,
        coat_roughness=0.2, sheen=0.5,
    ),
}  # fmt: skip
ANGLES = [0.0, 50.0, 85.0, 89.7]
#: Seen at 89.7 degrees their lobes are arcs of 1e-5 rad: no grid of cells resolves them.
TOO_THIN_AT_GRAZING = ("mirror-like", "sharp", "clear frost")


def angles(name):
    return ANGLES[:3] if name in TOO_THIN_AT_GRAZING else ANGLES


def surfaces():
    for name, lobes in LOBES.items():
        for degrees in angles(name):
            yield f"{name} at {degrees}", degrees, of_lobes(lobes, degrees)
    for name, closure in CLOSURES.items():
        for degrees in angles(name):
            for entering in (True, False):
                side = "in" if entering else "out"
                yield (
                    f"{name} {side} at {degrees}",
                    degrees,
                    Resolver(closure)(degrees, entering),
                )


TESTS = len(LOBES) * len(ANGLES) + 2 * len(CLOSURES) * len(ANGLES)


def test_directions_follow_their_density(rng):
    for name, degrees, surface in surfaces():
        part = main_part(surface)
        drawn = samples(surface, part, COUNT, rng)
        assert np.isfinite(drawn).all(), name
        np.testing.assert_allclose(np.linalg.norm(drawn[:, 1:4], axis=1), 1, rtol=1e-9)
        observed, expected = cells(surface, part, drawn, 32 if degrees < 89.0 else 128)
        # What is lost is what the integral leaves over; its own error blurs that.
        assert abs(observed[-1] - expected[-1]) < 0.008 * COUNT, name
        if observed[:-1].sum() < COUNT / 50:
            # Total reflection ends nearly all that is refracted from inside.
            continue
        seen, mean = observed[:-1], expected[:-1] * (COUNT - observed[-1]) / expected[:-1].sum()
        # Of cells that reach above the plane by a sliver all midpoints may lie below it.
        thin = mean < 30.0
        observed = np.append(seen[~thin], seen[thin].sum())
        expected = np.append(mean[~thin], max(0.1, mean[thin].sum()))
        try:
            chi_square(observed, expected, tests=TESTS)
        except AssertionError as error:
            raise AssertionError(f"{name}: {error}") from error


def test_weight_is_value_times_cosine_over_density(rng):
    for name, _, surface in surfaces():
        part = main_part(surface)
        for row in samples(surface, part, 20, rng):
            if not row[0] or row[7] == 0.0:
                continue
            wi = tuple(row[1:4])
            f = value(surface, wi, part) * abs(wi[2]) / row[7]
            below = wi[2] < 0.0
            if "mixed" in name or ("layers" in name and below):
                continue
            factor = surface.eta**2 if below and "translucent" not in name else 1.0
            np.testing.assert_allclose(row[4:7], f * factor, rtol=1e-6, err_msg=name)


@pytest.mark.parametrize("roughness", [0.0, 0.1, 0.2, 0.25, 0.35, 0.45, 0.5, 0.7, 1.0])
def test_both_parts_together_are_the_lobe(roughness, rng):
    surface = of_lobes([m.ggx(0.8, roughness)], 40.0)
    wide, narrow = weights(surface)
    assert wide + narrow == pytest.approx(0.8, rel=1e-12)
    assert wide >= 0.0 and narrow >= 0.0
    if roughness**2 <= 0.03:
        assert wide == 0.0
    if roughness**2 >= 0.25:
        assert narrow == 0.0
    for row in samples(surface, main_part(surface), 20, rng):
        if row[0] and row[7] > 0.0:
            wi = tuple(row[1:4])
            parts = value(surface, wi, WIDE), value(surface, wi, NARROW)
            whole = parts[0].sum() + parts[1].sum()
            np.testing.assert_allclose(parts[0].sum(), whole * wide / 0.8, rtol=1e-9)


def test_share_falls_smoothly_with_roughness():
    alphas = np.linspace(0.0, 0.4, 401)
    shares = np.array([weights(of_lobes([m.ggx(1.0, a**0.5)], 0.0))[1] for a in alphas])
    assert (np.diff(shares) <= 1e-12).all() and shares[0] == 1.0 and shares[-1] == 0.0
    assert np.abs(np.diff(shares)).max() < 0.01


def test_transparent_lobes_stand_apart(rng):
    lobes = [m.transparent((0.1, 0.2, 0.3)), m.diffuse(0.5)]
    surface = of_lobes(lobes, 30.0)
    assert weights(surface) == (0.5, 0.0)
    np.testing.assert_allclose(pass_weight(surface.row, surface.lobes), (0.1, 0.2, 0.3))
    found, variance = albedo(surface, 20_000, rng)
    same_means(found, variance, (0.6, 0.7, 0.8), floor=1e-9)


def test_sides_and_ray_kinds():
    def bits(surface):
        return [
            part_bit(surface.row, surface.lobes, part, t) for part in (WIDE, NARROW)
            for t in (False, True)
        ]  # fmt: skip

    plain = of_lobes([m.diffuse(0.5), m.mirror(0.2)], 0.0)
    assert not is_twosided(plain.row, plain.lobes)
    assert bits(plain)[0] == Visibility.DIFFUSE and bits(plain)[2] == Visibility.GLOSSY
    leaf = of_lobes([m.diffuse(0.5), m.translucent(0.2)], 0.0)
    assert is_twosided(leaf.row, leaf.lobes)
    assert bits(leaf)[1] == Visibility.DIFFUSE
    frost = Resolver(c.rough_glass(1.5, 0.6))(0.0)
    assert is_twosided(frost.row, frost.lobes)
    assert bits(frost)[:2] == [Visibility.GLOSSY, Visibility.TRANSMISSION]
    clear = Resolver(c.rough_glass(1.5, 0.0))(0.0)
    assert not is_twosided(clear.row, clear.lobes)
