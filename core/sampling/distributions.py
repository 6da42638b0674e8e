"""Discrete distributions as cumulative tables."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..jit import Table, kernel


def cumulative(weights: ArrayLike) -> NDArray[np.float64]:
    """Cumulative probabilities of not negative ``weights`` (N,); all zero: uniform."""
    w = np.asarray(weights, dtype=np.float64)
    total = w.sum()
    if w.size == 0:
        return np.zeros(0)
    p = w / total if total > 0 else np.full(w.size, 1.0 / w.size)
    cdf = np.cumsum(p)
    # Entries behind the last possible one share its 1.0, so rounding can't choose them.
    cdf[np.flatnonzero(p)[-1] :] = 1.0
    return cdf


@kernel
def sample_discrete(cdf: Table, u: float) -> int:
    """Index whose slice of the cumulative table holds ``u`` in [0, 1)."""
    low = 0
    high = len(cdf) - 1
    while low < high:
        middle = (low + high) // 2
        if u < cdf[middle]:
            high = middle
        else:
            low = middle + 1
    return low


@kernel
def warp(cdf: Table, u: float) -> tuple[int, float, float]:
    """Entry of a cumulative table that holds ``u``: (entry, place within in [0, 1), share)."""
    k = sample_discrete(cdf, u)
    before = cdf[k - 1] if k > 0 else 0.0
    share = cdf[k] - before
    return k, min((u - before) / share, 1.0 - 1e-9), share


@kernel
def probability(cdf: Table, i: int) -> float:
    """Probability of entry ``i``."""
    if i == 0:
        return cdf[0]
    return cdf[i] - cdf[i - 1]
