"""Statistical checks: every one states its level and holds over a whole family of them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import integrate, stats

#: Probability that a correct program fails one call, over all the comparisons inside.
LEVEL = 0.01


def sidak(level: float, count: int) -> float:
    """Level of each of ``count`` independent tests that together have ``level``."""
    return -float(np.expm1(np.log1p(-level) / max(1, count)))


def pooled(
    observed: ArrayLike, expected: ArrayLike, least: float = 5.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Both tables with cells of small expectation put together until none is below least.

    Raises ``AssertionError`` for an observation where nothing is expected.
    """
    o, e = np.ravel(observed).astype(float), np.ravel(expected).astype(float)
    impossible = o[e <= 0].sum()
    assert impossible == 0, f"{impossible:.0f} observations in cells of probability 0"
    order = np.argsort(e[e > 0])
    o, e = o[e > 0][order], e[e > 0][order]
    cells_o, cells_e, sum_o, sum_e = [], [], 0.0, 0.0
    for count, mean in zip(o, e, strict=True):
        sum_o, sum_e = sum_o + count, sum_e + mean
        if sum_e >= least:
            cells_o.append(sum_o)
            cells_e.append(sum_e)
            sum_o = sum_e = 0.0
    if sum_e > 0 and cells_e:
        cells_o[-1] += sum_o
        cells_e[-1] += sum_e
    return np.array(cells_o), np.array(cells_e)


def chi_square(
    observed: ArrayLike, expected: ArrayLike, tests: int = 1, level: float = LEVEL
) -> None:
    """Assert that counts follow their expectation; one of a family of ``tests`` tests.

    Both add up to the same number: what falls outside of all cells is a cell of its own.
    """
    total, mean = float(np.sum(observed)), float(np.sum(expected))
    assert abs(mean / total - 1) < 1e-3, f"{mean} expected of {total}"
    o, e = pooled(observed, expected)
    assert len(e) > 1, "a chi-square test needs two cells"
    p = stats.chisquare(o, e * total / e.sum()).pvalue
    assert p > sidak(level, tests), f"chi-square p = {p:.3g} over {len(e)} cells"


def uniform_square(u: ArrayLike, v: ArrayLike, bins: int = 16, tests: int = 1) -> None:
    """Assert by chi-square that pairs are uniform on the unit square and independent."""
    counts = np.histogram2d(np.ravel(u), np.ravel(v), bins, ((0, 1), (0, 1)))[0]
    assert counts.sum() == np.size(u), "a value lies outside of [0, 1]"
    chi_square(counts, np.full_like(counts, np.size(u) / counts.size), tests)


def sphere_counts(directions: NDArray[np.float64], rows: int, columns: int) -> NDArray:
    """Counts (rows, columns) of directions (N, 3) by z and azimuth (equal solid angles)."""
    z = np.clip(directions[:, 2], -1, 1)
    azimuth = np.arctan2(directions[:, 1], directions[:, 0])
    edges = ((-1, 1), (-np.pi, np.pi))
    return np.histogram2d(z, azimuth, bins=(rows, columns), range=edges)[0]


def sphere_integrals(
    pdf: Callable[[float, float, float], float], rows: int, columns: int, order: int = 16
) -> NDArray[np.float64]:
    """Integral of ``pdf(x, y, z)`` per solid angle over each cell of ``sphere_counts``.

    Gauss-Legendre of ``order`` squared points; cells with a jump inside are split finer.
    """
    nodes, weights = np.polynomial.legendre.leggauss(order)

    def patch(z0: float, z1: float, a0: float, a1: float) -> float:
        z = (z0 + z1) / 2 + (z1 - z0) / 2 * nodes
        a = (a0 + a1) / 2 + (a1 - a0) / 2 * nodes
        values = np.array(
            [
                [pdf(r * np.cos(t), r * np.sin(t), c) for t in a]
                for c, r in zip(z, np.sqrt(1 - z * z), strict=True)
            ]
        )
        return float(weights @ values @ weights) * (z1 - z0) * (a1 - a0) / 4

    def refined(z0: float, z1: float, a0: float, a1: float, depth: int) -> float:
        zm, am = (z0 + z1) / 2, (a0 + a1) / 2
        quarters = ((z0, zm, a0, am), (z0, zm, am, a1), (zm, z1, a0, am), (zm, z1, am, a1))
        fine = sum(patch(za, zb, aa, ab) for za, zb, aa, ab in quarters)
        if depth == 0 or abs(fine - patch(z0, z1, a0, a1)) < 1e-5:
            return fine
        return sum(refined(za, zb, aa, ab, depth - 1) for za, zb, aa, ab in quarters)

    z, a = np.linspace(-1, 1, rows + 1), np.linspace(-np.pi, np.pi, columns + 1)
    cells = [
        refined(z[i], z[i + 1], a[j], a[j + 1], 4) for i in range(rows) for j in range(columns)
    ]
    return np.reshape(cells, (rows, columns))


def same_means(
    mean: ArrayLike,
    variance: ArrayLike,
    other: ArrayLike,
    other_variance: ArrayLike = 0.0,
    level: float = LEVEL,
    floor: ArrayLike = 0.0,
    freedom: float = np.inf,
) -> None:
    """Assert that means with known variances agree everywhere (Z-tests, Sidak-corrected).

    ``floor`` is an absolute difference that is always allowed (rounding, a known bias);
    ``freedom``: degrees of freedom when the variances are estimates of few runs (t-tests).
    """
    a, b = np.asarray(mean, float), np.asarray(other, float)
    spread = np.sqrt(np.asarray(variance, float) + np.asarray(other_variance, float))
    a, b, spread = np.broadcast_arrays(a, b, spread)
    assert np.isfinite(a).all() and np.isfinite(b).all(), "a mean is NaN or infinite"
    excess = np.maximum(np.abs(a - b) - floor, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(excess > 0, excess / spread, 0.0)
    p = 2 * stats.t.sf(z, freedom)
    worst = np.unravel_index(np.argmin(p), p.shape)
    assert p.min() > sidak(level, p.size), (
        f"at {tuple(map(int, worst))}: {a[worst]:.6g} against {b[worst]:.6g}, "
        f"z = {z[worst]:.2f}, p = {p[worst]:.3g} in a family of {p.size}"
    )


def integral(f: Callable[[float], float], low: float, high: float) -> float:
    """Adaptive quadrature of ``f``."""
    return float(integrate.quad(f, low, high, limit=200)[0])
