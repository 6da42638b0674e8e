"""The tables that pixel filters are sampled with (chi-square, level 0.01)."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.camera.lens import filter_offset
from photon_map.core.film.filters import filter_profile, filter_table
from photon_map.tests.statistics import chi_square

KINDS = ("BOX", "GAUSSIAN", "BLACKMAN_HARRIS")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("width", [1.0, 2.5])
def test_offsets_follow_the_filter(kind, width, rng):
    count, bins, fine = 50_000, 40, 1000
    table = filter_table(kind, width)
    offsets = np.array([filter_offset(table, u) for u in rng.random(count)])
    reach = np.abs(offsets).max()
    assert table[0] == -table[-1] and reach <= table[-1]
    support = 2 * table[-1]
    t = (np.arange(bins * fine) + 0.5) / (bins * fine) - 0.5
    share = filter_profile(kind, t).reshape(bins, fine).sum(axis=1)
    counts = np.histogram(offsets, bins, (-support / 2, support / 2))[0]
    chi_square(counts, share / share.sum() * count, tests=6)


@pytest.mark.parametrize("kind", KINDS)
def test_filters_are_symmetric_and_scale_with_their_width(kind):
    one, three = filter_table(kind, 1.0), filter_table(kind, 3.0)
    np.testing.assert_allclose(one, -one[::-1], atol=1e-9)
    np.testing.assert_allclose(three, 3 * one, atol=1e-12)
    assert (np.diff(one) >= 0).all()


def test_box_of_width_one_covers_the_pixel():
    table = filter_table("BOX", 1.0)
    assert filter_offset(table, 0.0) == pytest.approx(-0.5)
    assert filter_offset(table, 0.25) == pytest.approx(-0.25)
    assert filter_offset(table, np.nextafter(1.0, 0.0)) == pytest.approx(0.5)
