"""Histograms over the numbers that aim caustic photons."""

from __future__ import annotations

import numpy as np

from photon_map.core.photons.emission_histogram import (
    BINS,
    CASTERS,
    find_bins,
    histogram_of,
    no_histogram,
    warp_emission,
)
from photon_map.core.sampling.rng import PHOTON_CAUSTIC
from photon_map.tests.statistics import chi_square

SHAPE = (CASTERS, BINS, BINS)


def test_numbers_have_the_density_that_they_tell(rng: np.random.Generator):
    density = rng.lognormal(0.0, 1.0, (1, *SHAPE))
    histogram = histogram_of(np.array([-1, 0], np.int32), density)
    counts = np.zeros(SHAPE)
    for u in rng.random((100_000, 3)):
        *numbers, pdf = warp_emission(histogram, 1, *u)
        at = tuple((np.array(numbers) * SHAPE).astype(int))
        counts[at] += 1
        assert abs(pdf - density[0][at] / density.mean()) < 1e-9 * pdf
    chi_square(counts.ravel(), 100_000 * (density / density.sum()).ravel())


def test_places_within_a_bin_stay_even(rng: np.random.Generator):
    density = np.full((1, *SHAPE), 1e-3)
    density[0, 3, 5, 7] = 1.0
    histogram = histogram_of(np.zeros(1, np.int32), density)
    within = []
    for u in rng.random((20_000, 3)):
        numbers = np.array(warp_emission(histogram, 0, *u)[:3]) * SHAPE
        if tuple(numbers.astype(int)) == (3, 5, 7):
            within.append(numbers % 1.0)
    counts = np.histogramdd(np.array(within), 3, [(0, 1)] * 3)[0]
    chi_square(counts.ravel(), np.full(27, len(within) / 27))


def test_a_light_without_one_keeps_its_numbers():
    density = np.ones((1, *SHAPE))
    some = histogram_of(np.array([-1, 0], np.int32), density)
    for histogram in (some, no_histogram()):
        assert warp_emission(histogram, 0, 0.3, 0.2, 0.9) == (0.3, 0.2, 0.9, 1.0)


def test_paths_are_found_in_their_bins():
    # Points of nets: each eighth and sixteenth has its share of them, to the last one.
    entries, bins = np.zeros((2, 4096), np.int32)
    find_bins(np.array([0.25, 0.25, 1.0]), 1, PHOTON_CAUSTIC, 5, entries, bins)
    assert np.bincount(entries).tolist() == [1024, 0, 3072]
    caster, rest = np.divmod(bins, BINS * BINS)
    assert np.bincount(caster).tolist() == [4096 // CASTERS] * CASTERS
    assert np.bincount(rest).tolist() == [4096 // BINS**2] * BINS**2
