"""Histograms by which lights send caustic photons to where the camera sees them land.

A photon's start is a function of a few uniform numbers: one chooses the cone or disc around a
caster, two the place in it. A histogram over these numbers is a density on them, which is
divided out: that is exact however cones overlap. (Emission learnt from photons that were
seen: Peter & Pietrek 1998, "Importance driven construction of photon maps".)
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..jit import Row, Table, kernel
from ..sampling.distributions import sample_discrete, warp
from ..sampling.rng import mix, sobol_2d, stream

#: Bins of the number that chooses a caster, and of each of the other two.
CASTERS, BINS = 8, 16
#: Bins of one light.
CELLS = CASTERS * BINS * BINS


class EmissionHistogram(NamedTuple):
    """Histograms of R lights: ``row`` (E,) i4 tells whose is whose, -1 none.

    Cumulative tables: ``casters`` (R, CASTERS), ``rows`` (R, CASTERS, BINS) and ``columns``
    (R, CASTERS, BINS, BINS), each within the one before.
    """

    row: NDArray[np.int32]
    casters: NDArray[np.float64]
    rows: NDArray[np.float64]
    columns: NDArray[np.float64]


def no_histogram() -> EmissionHistogram:
    """All lights aim evenly at the casters."""
    return EmissionHistogram(
        np.zeros(0, np.int32), np.zeros((0, CASTERS)), np.zeros((0, CASTERS, BINS)),
        np.zeros((0, CASTERS, BINS, BINS)),
    )  # fmt: skip


def histogram_of(row: NDArray[np.int32], density: NDArray[np.float64]) -> EmissionHistogram:
    """Of densities (R, CASTERS, BINS, BINS), all above 0."""
    in_rows = density.sum(axis=3)
    in_casters = in_rows.sum(axis=2)
    return EmissionHistogram(row, _shares(in_casters), _shares(in_rows), _shares(density))


def _shares(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cumulative shares along the last axis, the last one 1 in spite of rounding."""
    table = np.cumsum(weights, axis=-1)
    table /= table[..., -1:]
    table[..., -1] = 1.0
    return table


@kernel
def warp_emission(
    histogram: Row, entry: int, u_cone: float, u: float, v: float
) -> tuple[float, float, float, float]:
    """Numbers by the histogram of light ``entry`` and their density: (u_cone, u, v, pdf)."""
    if len(histogram.row) == 0 or histogram.row[entry] < 0:
        return u_cone, u, v, 1.0
    r = histogram.row[entry]
    caster, a, p = warp(histogram.casters[r], u_cone)
    i, b, q = warp(histogram.rows[r, caster], u)
    j, c, s = warp(histogram.columns[r, caster, i], v)
    pdf = p * CASTERS * q * BINS * s * BINS
    return (caster + a) / CASTERS, (i + b) / BINS, (j + c) / BINS, pdf


@kernel
def emission_numbers(scramble: np.uint64, k: int) -> Any:
    """Numbers of path ``k``: (light, cone, (u, v) of the aim, (s, t) of the light)."""
    u_light, u_cone = sobol_2d(k, mix(scramble + np.uint64(1)))
    u, v = sobol_2d(k, mix(scramble + np.uint64(2)))
    s, t = sobol_2d(k, mix(scramble + np.uint64(3)))
    return u_light, u_cone, u, v, s, t


@kernel
def find_bins(
    light_cdf: Table, seed: int, purpose: int, i: int, entries: Table, bins: Table
) -> None:
    """Light (n,) and bin (n,) of each path of a pass that no histogram has warped."""
    scramble = stream(seed, purpose, i, -1)
    for k in range(len(bins)):
        u_light, u_cone, u, v, _, _ = emission_numbers(scramble, k)
        entries[k] = sample_discrete(light_cdf, u_light)
        row = int(u_cone * CASTERS) * BINS + int(u * BINS)
        bins[k] = row * BINS + int(v * BINS)
