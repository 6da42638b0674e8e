"""How much two pictures are alike, by the means of their cells; NumPy alone."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

#: Cells that pictures are compared in.
CELLS = (24, 16)


def cells(pixels: np.ndarray) -> np.ndarray:
    """Means of the picture in ``CELLS``, whose bounds are exact to half a pixel."""
    height, width = pixels.shape[:2]
    columns = np.rint(np.linspace(0, width, CELLS[0] + 1)).astype(int)
    rows = np.rint(np.linspace(0, height, CELLS[1] + 1)).astype(int)
    return np.array(
        [
            [pixels[y0:y1, x0:x1].mean(axis=(0, 1)) for x0, x1 in pairwise(columns)]
            for y0, y1 in pairwise(rows)
        ]
    )


def likeness(a: np.ndarray, b: np.ndarray) -> dict[str, float]:
    """Correlation of two pictures' cells, and their mean distance."""
    x, y = cells(a), cells(b)
    return {
        "correlation": float(np.corrcoef(x.ravel(), y.ravel())[0, 1]),
        "distance": float(np.abs(x - y).mean()),
    }


def parted(pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The middle of a picture, and a part of its rim."""
    height, width = pixels.shape[:2]
    middle = pixels[height // 4 : 3 * height // 4, width // 4 : 3 * width // 4]
    return middle, pixels[:, : width // 4 - 3]
