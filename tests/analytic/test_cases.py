"""Caustics against their closed forms: right in the mean, and closer with every pass."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.tests.analytic.cases import CASES, prism, table

BY_NAME = {case.name: case for case in CASES}
#: Share of the light that bends at a place where the closed form jumps, out of the pixels
#: that are compared: none for the smooth ones.
EDGE = {"prism": 0.01, "ball lens": 0.002, "nephroid": 0.003, "thin lens": 0.002}


@pytest.mark.parametrize("name", BY_NAME)
def test_error_against_the_closed_form_falls_with_the_passes(name):
    few, many = table(BY_NAME[name], (2, 16))
    # 2^19 photons; the least lit case sees a tenth of them: 0.5 % at one sigma.
    assert abs(many.mean_error) < 0.01 + EDGE.get(name, 0.0)
    # The cube root of 8 is 2; at least its fourth root where edges are compared.
    assert many.error < few.error * 8 ** (-0.25 if name not in EDGE else -0.15)
    assert many.photons == 8 * few.photons


@pytest.mark.slow
@pytest.mark.parametrize("name", BY_NAME)
def test_no_closed_form_is_missed_by_more_than_half_a_percent(name):
    result = BY_NAME[name].measure(256)
    assert abs(result.mean_error) < 0.003 + EDGE.get(name, 0.0)
    # Of edges and cusps, where the light is infinite, a pixel's width of disc is left.
    assert result.error < (0.06 if name in EDGE else 0.05)


def test_the_nephroids_cusp_lies_half_way_to_the_mirror():
    result = BY_NAME["nephroid"].measure(16)
    size = len(result.found)
    rows = slice(size // 2 - 1, size // 2 + 1)
    x = (np.arange(size) + 0.5) / size * 2 - 1
    at = [
        x[np.nanargmax(image[rows].mean(axis=0))] for image in (result.found, result.expected)
    ]
    # Both branches meet at R / 2, and the light lies before it: within two pixels of 0.04.
    assert abs(at[1] - 0.5) < 0.09
    assert abs(at[0] - at[1]) < 0.05


def test_the_prism_bends_by_its_least_deviation():
    found = BY_NAME["prism"].measure(16).found
    expected = prism()[1]
    rows = np.isfinite(expected[:, 0])
    z = np.arange(len(expected))
    # The upper edge of the patch: where half of its light is reached.
    edges = []
    for image in (found, expected):
        profile = image[rows].mean(axis=1)
        level = profile[2:10].mean()
        edges.append(z[rows][0] + profile.sum() / level)
    # A row is 1.25 degrees seen from the prism.
    assert abs(edges[0] - edges[1]) < 0.2
