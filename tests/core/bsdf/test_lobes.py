"""Lobes of one material together: reciprocity, sides, weights."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from photon_map.core.bsdf.dispatch import (
    WIDE,
    eval_part,
    is_lambertian,
    lobe_weights,
    pdf_part,
)
from photon_map.core.scene.lobes import diffuse, ggx, mirror, oren_nayar, phong
from tests.surfaces import UP, of_lobes

CASES = {
    "diffuse": [diffuse(0.7)],
    "phong": [phong(0.8, 12.0)],
    "flat phong": [phong(0.8, 0.0)],
    "rough diffuse": [oren_nayar((0.7, 0.5, 0.1), 0.8)],
    "mixed": [
        diffuse((0.5, 0.2, 0.1)),
        mirror(0.3),
        phong((0.1, 0.2, 0.4), 30.0),
        ggx(0.1, 0.7),
    ],
}


@given(
    a=st.floats(0, 1.55), b=st.floats(0, 1.55), phi=st.floats(0, 6.3),
    name=st.sampled_from(sorted(CASES)),
)  # fmt: skip
def test_light_may_run_either_way(a, b, phi, name):
    surface = of_lobes(CASES[name], 0.0)
    wo = (math.sin(a), 0.0, math.cos(a))
    wi = (math.sin(b) * math.cos(phi), math.sin(b) * math.sin(phi), math.cos(b))
    there = eval_part(surface.row, surface.lobes, UP, wo, wi, WIDE)
    back = eval_part(surface.row, surface.lobes, UP, wi, wo, WIDE)
    np.testing.assert_allclose(there, back, rtol=1e-9, atol=1e-12)


def test_below_the_surface_nothing_is_scattered():
    surface = of_lobes(CASES["mixed"], 40.0)
    under = (0.6, 0.0, -0.8)
    assert eval_part(surface.row, surface.lobes, UP, surface.wo, under, WIDE) == (0, 0, 0)
    assert pdf_part(surface.row, surface.lobes, UP, surface.wo, under, WIDE) == 0


def test_weights_are_split_between_wide_and_specular_lobes():
    surface = of_lobes(CASES["mixed"][:2], 0.0)
    wide, narrow = lobe_weights(surface.row, surface.lobes)
    assert wide == pytest.approx(0.8 / 3) and narrow == pytest.approx(0.3)
    assert is_lambertian(surface.row, surface.lobes)
    rough = of_lobes(CASES["mixed"], 0.0)
    assert not is_lambertian(rough.row, rough.lobes)
