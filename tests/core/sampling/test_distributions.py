from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.sampling.distributions import cumulative, probability, sample_discrete
from photon_map.tests.statistics import chi_square


@pytest.mark.parametrize("weights", [[1, 2, 3, 4], [0, 5, 0, 1, 0], [7], [0, 0, 0]])
def test_entries_come_as_often_as_they_weigh(weights, rng):
    cdf = cumulative(weights)
    drawn = [sample_discrete(cdf, u) for u in rng.random(20_000)]
    counts = np.bincount(drawn, minlength=len(weights))
    prob = np.array([probability(cdf, i) for i in range(len(weights))])
    total = sum(weights)
    expected = np.array(weights) / total if total else np.full(len(weights), 1 / len(weights))
    np.testing.assert_allclose(prob, expected, atol=1e-15)
    if len(weights) > 1:
        chi_square(counts, prob * 20_000, tests=3)


def test_rounding_never_chooses_an_impossible_entry():
    cdf = cumulative([0.1] * 10 + [0.0])
    assert cdf[-1] == 1.0
    assert sample_discrete(cdf, np.nextafter(1.0, 0.0)) == 9
    assert sample_discrete(cumulative([0.0, 1.0]), 0.0) == 1
    assert len(cumulative([])) == 0
