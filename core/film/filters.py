"""Pixel filters, sampled by importance: every path counts fully for one pixel.

Ernst, Stamminger & Greiner 2006, "Filter Importance Sampling". Pixels stay independent,
so films of different passes add up.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..settings import PixelFilter

_STEPS = 1024


def filter_profile(kind: PixelFilter, t: NDArray[np.float64]) -> NDArray[np.float64]:
    """Value of the filter at ``t`` in [-1/2, 1/2] of its width."""
    if kind == "BOX":
        return np.ones_like(t)
    if kind == "GAUSSIAN":
        # Blender's choice: sigma is a twelfth of the width.
        return np.exp(-2.0 * (6.0 * t) ** 2)
    # The 4-term window of Harris 1978, "On the use of windows", table 1.
    x = 2.0 * np.pi * (t + 0.5)
    window: NDArray[np.float64] = (
        0.35875 - 0.48829 * np.cos(x) + 0.14128 * np.cos(2 * x) - 0.01168 * np.cos(3 * x)
    )
    return window


#: Full support per width: Blender's widths are not those of the support.
SUPPORT = {"BOX": 1.0, "GAUSSIAN": 3.0, "BLACKMAN_HARRIS": 2.0}


def filter_table(kind: PixelFilter, width: float) -> NDArray[np.float64]:
    """Distribution of a filter of Blender's ``width`` [pixels], for ``filter_offset``.

    Rows (2, n): offsets from the pixel's middle [pixels] and the share of the filter that
    lies before each.
    """
    edge = np.linspace(-0.5, 0.5, _STEPS + 1)
    middle = 0.5 * (edge[1:] + edge[:-1])
    cdf = np.concatenate([[0.0], np.cumsum(filter_profile(kind, middle))])
    return np.stack([edge * width * SUPPORT[kind], cdf / cdf[-1]])


def covered_pixels(table: NDArray[np.float64]) -> float:
    """Pixels of an even square whose photons scatter as much as those that the filter weighs.

    The square of 1 / integral of f^2 of ``filter_table``'s density f along one axis.
    """
    step = (table[0, -1] - table[0, 0]) / (table.shape[1] - 1)
    return float((step / (np.diff(table[1]) ** 2).sum()) ** 2)
