"""The tables that pixel filters are sampled with (chi-square, level 0.01)."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.camera.lens import filter_offset
from photon_map.core.film.filters import filter_profile, filter_table
from photon_map.tests.statistics import chi_square

#: Full support in units of Blender's filter width.
SUPPORT = {"BOX": 1.0, "GAUSSIAN": 3.0, "BLACKMAN_HARRIS": 2.0}


@pytest.mark.parametrize("kind", SUPPORT)
@pytest.mark.parametrize("width", [1.0, 2.5])
def test_offsets_follow_the_filter(kind, width, rng):
    count, bins, fine = 50_000, 40, 1000
    table = filter_table(kind, width)
    offsets = np.array([filter_offset(table, u) for u in rng.random(count)])
    support = SUPPORT[kind] * width
    assert np.abs(offsets).max() <= support / 2
    t = (np.arange(bins * fine) + 0.5) / (bins * fine) - 0.5
    share = filter_profile(kind, t).reshape(bins, fine).sum(axis=1)
    counts = np.histogram(offsets, bins, (-support / 2, support / 2))[0]
    chi_square(counts, share / share.sum() * count, tests=6)


@pytest.mark.parametrize("kind", SUPPORT)
def test_filters_are_symmetric_and_scale_with_their_width(kind):
    one, three = filter_table(kind, 1.0), filter_table(kind, 3.0)
    numbers = np.linspace(0.001, 0.999, 999)
    offsets = np.array([filter_offset(one, u) for u in numbers])
    np.testing.assert_allclose(offsets, -offsets[::-1], atol=1e-9)
    np.testing.assert_allclose(
        [filter_offset(three, u) for u in numbers], 3 * offsets, atol=1e-9
    )
    assert (np.diff(offsets) > 0).all()


def test_box_of_width_one_covers_the_pixel():
    table = filter_table("BOX", 1.0)
    assert filter_offset(table, 0.0) == pytest.approx(-0.5)
    assert filter_offset(table, 0.25) == pytest.approx(-0.25)
    assert filter_offset(table, np.nextafter(1.0, 0.0)) == pytest.approx(0.5)
