"""Mattes by name: which names share a pixel, and how much of it each one covers.

Friedman and Jones 2015, "Fully Automatic ID Mattes with Support for Motion Blur and
Transparency", and the Cryptomatte specification 1.2: names are hashed with MurmurHash3,
whose bits are read as a float32 that is neither denormal, infinite nor NaN.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..jit import Table, kernel

_MASK = 0xFFFFFFFF


def _rotated(x: int, by: int) -> int:
    return ((x << by) | (x >> (32 - by))) & _MASK


def murmur3(data: bytes) -> int:
    """MurmurHash3_x86_32 with seed 0 (Appleby 2011)."""
    state = 0
    for start in range(0, len(data), 4):
        block = data[start : start + 4]
        k = int.from_bytes(block, "little") * 0xCC9E2D51 & _MASK
        state ^= _rotated(k, 15) * 0x1B873593 & _MASK
        if len(block) == 4:
            state = (_rotated(state, 13) * 5 + 0xE6546B64) & _MASK
    state ^= len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35), (16, 1)):
        state = (state ^ (state >> shift)) * factor & _MASK
    return state


def name_bits(name: str) -> int:
    """The 32 bits that stand for ``name``."""
    bits = murmur3(name.encode())
    # All ones or all zeros in the exponent are no ordinary numbers: one bit of it is turned.
    return bits ^ (1 << 23) if (bits >> 23) & 0xFF in (0, 0xFF) else bits


def name_numbers(names: Sequence[str]) -> NDArray[np.float32]:
    """The numbers (N,) that stand for ``names`` in a matte."""
    known = {name: struct.unpack("<f", struct.pack("<I", name_bits(name)))[0] for name in names}
    return np.array([known[name] for name in names], np.float32)


@kernel
def add_mattes(numbers: Table, weights: Table, new_numbers: Table, new_weights: Table) -> None:
    """Add to the ranks (n, R) of pixels what new ones (n, K) see; a weight of 0 is none.

    A number that finds no place is dropped.
    """
    for k in range(len(new_numbers)):
        for j in range(new_numbers.shape[1]):
            weight = new_weights[k, j]
            if not weight > 0.0:
                continue
            for r in range(numbers.shape[1]):
                if weights[k, r] == 0.0 or numbers[k, r] == new_numbers[k, j]:
                    numbers[k, r] = new_numbers[k, j]
                    weights[k, r] += weight
                    break


def ranked(
    numbers: NDArray[np.float32], weights: NDArray[np.float64], count: NDArray[np.int32]
) -> NDArray[np.float32]:
    """Ranks (n, R) as (n, 2 R): number and coverage by turns, the largest first."""
    order = np.argsort(-weights, axis=1, kind="stable")
    out = np.zeros((len(numbers), 2 * numbers.shape[1]), np.float32)
    out[:, 0::2] = np.take_along_axis(numbers, order, 1)
    share = np.take_along_axis(weights, order, 1) / np.maximum(count, 1)[:, None]
    # A coverage of nearly one is one, whatever the rounding of its weights.
    out[:, 1::2] = np.minimum(share, 1.0)
    return out
