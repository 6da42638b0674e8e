"""Cells of hashed grids: a cell's key, and the bucket that it lies in."""

from __future__ import annotations

import numpy as np

from ..jit import kernel

_X = np.uint64(0x9E3779B97F4A7C15)
_SHIFT = 21  # bits a coordinate has in a cell's key
_HALF = 1 << 20


@kernel
def cell_key(x: int, y: int, z: int) -> int:
    """One number for a cell; cells 2^21 apart share it, farther than float32 reaches."""
    mask = (1 << _SHIFT) - 1
    return (
        ((x + _HALF) & mask)
        | (((y + _HALF) & mask) << _SHIFT)
        | (((z + _HALF) & mask) << (2 * _SHIFT))
    )


@kernel
def bucket_of(key: int, buckets: int) -> np.int64:
    """Bucket of a cell in a table whose size is a power of two.

    Rows of cells along x lie in one piece of memory, each row somewhere else.
    """
    row = (np.uint64(key) >> np.uint64(_SHIFT)) * _X
    x = np.uint64(key) & np.uint64((1 << _SHIFT) - 1)
    # Signed, as all indices are: with unsigned ones Numba's sums would be floats.
    return np.int64(((row >> np.uint64(32)) + x) & np.uint64(buckets - 1))


@kernel
def row_of(key: int) -> int:
    """The part of a cell's key that all cells along x share."""
    return key >> _SHIFT
