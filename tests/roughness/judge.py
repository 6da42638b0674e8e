"""Judges a sweep: is its mean a smooth curve, and its noise without islands?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from photon_map.tests.roughness.sweep import Point

#: Allowed difference from the reference, as a share: blur of caustics over the picture's rim.
BIAS = 0.01


class Worst(NamedTuple):
    """Where a sweep is worst: the roughness, and how much it is off."""

    roughness: float
    value: float


def farthest(points: Sequence[Point]) -> tuple[Worst, float]:
    """Largest (ours - reference) / reference, and the largest z beyond ``BIAS``."""
    off = np.array([p.mean / p.truth - 1.0 for p in points])
    spread = np.array([np.hypot(p.error, p.truth_error) / p.truth for p in points])
    worst = int(np.abs(off).argmax())
    z = np.maximum(np.abs(off) - BIAS, 0.0) / spread
    return Worst(points[worst].roughness, float(off[worst])), float(z.max())


def between(points: Sequence[Point], i: int) -> tuple[float, float]:
    """Distance of a mean from the cubic through its four neighbours, with standard error.

    In the square root of the roughness, in which the means are smooth curves at both ends.
    """
    x = np.sqrt([p.roughness for p in points])
    near = [i - 2, i - 1, i + 1, i + 2]
    share = [np.prod([(x[i] - x[k]) / (x[j] - x[k]) for k in near if k != j]) for j in near]
    means = np.array([points[j].mean for j in near])
    errors = np.array([points[j].error for j in near])
    spread = np.sqrt(points[i].error ** 2 + np.dot(np.square(share), errors**2))
    return float(points[i].mean - np.dot(share, means)), float(spread)


def roughest_jump(points: Sequence[Point]) -> tuple[Worst, float]:
    """Largest share by which a mean is off its neighbours' curve, and the largest z beyond
    ``BIAS``; the first and last two points have no two neighbours on a side.
    """
    worst, most = Worst(0.0, 0.0), 0.0
    for i in range(2, len(points) - 2):
        off, spread = between(points, i)
        share = off / points[i].mean
        if abs(share) > abs(worst.value):
            worst = Worst(points[i].roughness, share)
        most = max(most, max(abs(off) - BIAS * points[i].mean, 0.0) / spread)
    return worst, most


def island(points: Sequence[Point]) -> Worst:
    """The point whose noise is most above what lies on both sides of it.

    Its value is its squared error over the larger one of the least on its left and right: 1 or
    less where that rises, falls, or has a valley.
    """
    noise = np.array([p.noise * p.mean**2 for p in points])
    factors = [
        noise[i] / max(noise[:i].min(), noise[i + 1 :].min()) for i in range(1, len(noise) - 1)
    ]
    worst = int(np.argmax(factors))
    return Worst(points[worst + 1].roughness, float(factors[worst]))
