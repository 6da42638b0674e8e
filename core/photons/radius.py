"""Gather radii: where they start and how they shrink from pass to pass.

Knaus & Zwicker 2011, "Progressive Photon Mapping: A Probabilistic Approach", eq. 15:
r_{i+1}^2 = r_i^2 (i + alpha) / (i + 1), so the variance of the mean and its bias both
go to zero; alpha = 2/3 balances them (Kaplanyan & Dachsbacher 2013).
"""

from __future__ import annotations

from math import exp, lgamma, sqrt

#: ``alpha`` of the global map, at least. Its discs are looked at through final-gather rays,
#: which blur them, and the bias at borders is divided out (``coverage``): so noise, which
#: falls as i^-alpha, outweighs the bias that shrinking would remove.
GLOBAL_ALPHA = 0.95


def radius_factor(i: int, alpha: float) -> float:
    """r_i / r_0 for pass ``i`` counted from 0, in closed form through gamma functions."""
    # prod_{k=1}^{i} (k + alpha) / (k + 1) = Gamma(i+1+alpha) / (Gamma(1+alpha) Gamma(i+2))
    log_ratio = lgamma(i + 1 + alpha) - lgamma(1 + alpha) - lgamma(i + 2)
    return sqrt(exp(log_ratio))
