"""Rows of a table that may belong to one pixel, added by NumPy, which adds to each once."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray


def each_once(
    ids: NDArray[np.int32],
) -> Iterator[tuple[slice | NDArray[np.intp], NDArray[np.int32]]]:
    """Rows (n,) in groups that have each pixel once: (which rows, their pixels).

    ``ids`` (n,) ascending pixels. The k-th rows of all pixels are the k-th group.
    """
    first = np.searchsorted(ids, ids, side="left")
    turn = np.arange(len(ids)) - first
    most = int(turn.max(initial=0))
    if most == 0:
        yield slice(None), ids
        return
    for k in range(most + 1):
        rows = np.flatnonzero(turn == k)
        yield rows, ids[rows]


def add_each(
    plane: NDArray[np.float64], ids: NDArray[np.int32], values: NDArray[np.float64]
) -> None:
    """Add ``values`` (n, ...) to the rows ``ids`` (n,), ascending, of ``plane`` (m, ...)."""
    for rows, pixels in each_once(ids):
        plane[pixels] += values[rows]
