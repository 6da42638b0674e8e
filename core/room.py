"""Room for the arrays that a thread works in, chunk after chunk, batch after batch.

They hold megabytes. Asked for anew they come from the system each time, which clears and maps
each of their pages at its first touch: a tenth of the time of a pass.
"""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


class Room(threading.local):
    """This thread's arrays by name; they go with the thread."""

    def __init__(self) -> None:
        self.arrays: dict[str, NDArray[np.uint8]] = {}

    def take(
        self, name: str, count: int, dtype: DTypeLike, columns: int = 0, kept: int = 0
    ) -> NDArray[Any]:
        """(count,) or (count, columns) of ``dtype``, until ``name`` is taken again.

        The first ``kept`` rows are what they were. The others hold anything: the caller
        writes what it reads.
        """
        row = np.dtype((dtype, columns) if columns else dtype)
        array = self.arrays.get(name)
        if array is None or array.nbytes < count * row.itemsize:
            # A little more, so that it does not grow with each chunk. Not zeros: NumPy asks for
            # large pages for those of ``empty`` alone, which are there ten times as soon.
            grown = np.empty((count + count // 4) * row.itemsize, np.uint8)
            if array is not None and kept:
                grown[: kept * row.itemsize] = array[: kept * row.itemsize]
            array = self.arrays[name] = grown
        return array[: count * row.itemsize].view(row.base).reshape((count, *row.shape))


ROOM = Room()
