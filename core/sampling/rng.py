"""Counter-based random numbers: a value is a function of (stream, dimension) alone.

No state is kept, so a path draws the same numbers whatever thread or chunk it runs in.
The hash is the finaliser of SplitMix64 (Steele, Lea & Flood 2014). Low-discrepancy points
are the first two Sobol dimensions, Owen-scrambled by hashing (Laine & Karras 2011) and
padded by index scrambling (Burley 2020, "Practical Hash-based Owen Scrambling").
"""

from __future__ import annotations

import numpy as np

from ..jit import kernel

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_LOW_32 = np.uint64(0xFFFFFFFF)
_TO_UNIT_53 = 1.0 / 9007199254740992.0
_TO_UNIT_32 = 1.0 / 4294967296.0

#: Passes are dealt out to this many independent sequences. Within one the points of a pixel
#: are stratified over its passes; between them they are not, which tells the true error.
REPLICATES = 4

# What a stream is for; streams of different purpose never share numbers.
CAMERA = 1
PHOTON_GLOBAL = 2
PHOTON_CAUSTIC = 3
CONNECTION = 4


@kernel
def mix(x: np.uint64) -> np.uint64:
    """SplitMix64 finaliser: a bijection of 64 bits without visible structure."""
    x = np.uint64(x)
    x = (x ^ (x >> np.uint64(30))) * _MIX_1
    x = (x ^ (x >> np.uint64(27))) * _MIX_2
    return x ^ (x >> np.uint64(31))


@kernel
def stream(seed: int, purpose: int, i: int, index: int) -> np.uint64:
    """Key of the stream of path ``index`` in pass ``i``."""
    key = mix(np.uint64(seed) + _GOLDEN * np.uint64(purpose))
    key = mix(key ^ mix(np.uint64(i) + _GOLDEN))
    return mix(key ^ mix(np.uint64(index) + _MIX_1))


@kernel
def uniform(key: np.uint64, dimension: int) -> float:
    """Number ``dimension`` of a stream, in [0, 1)."""
    bits = mix(np.uint64(key) + _GOLDEN * np.uint64(dimension + 1))
    return float(bits >> np.uint64(11)) * _TO_UNIT_53


@kernel
def _reverse(x: np.uint64) -> np.uint64:
    """The low 32 bits in reverse order."""
    x = ((x >> np.uint64(1)) & np.uint64(0x55555555)) | (
        (x & np.uint64(0x55555555)) << np.uint64(1)
    )
    x = ((x >> np.uint64(2)) & np.uint64(0x33333333)) | (
        (x & np.uint64(0x33333333)) << np.uint64(2)
    )
    x = ((x >> np.uint64(4)) & np.uint64(0x0F0F0F0F)) | (
        (x & np.uint64(0x0F0F0F0F)) << np.uint64(4)
    )
    x = ((x >> np.uint64(8)) & np.uint64(0x00FF00FF)) | (
        (x & np.uint64(0x00FF00FF)) << np.uint64(8)
    )
    return (x >> np.uint64(16)) | ((x & np.uint64(0xFFFF)) << np.uint64(16))


@kernel
def _permute(x: np.uint64, seed: np.uint64) -> np.uint64:
    """Laine-Karras permutation of 32 bits: a change in a bit reaches only higher ones.

    On a reversed number that is a nested uniform (Owen) scramble.
    """
    x = (x + seed) & _LOW_32
    x = x ^ ((x * np.uint64(0x6C50B47C)) & _LOW_32)
    x = x ^ ((x * np.uint64(0xB82F1E52)) & _LOW_32)
    x = x ^ ((x * np.uint64(0xC7AFE638)) & _LOW_32)
    return x ^ ((x * np.uint64(0x8D22F6E6)) & _LOW_32)


@kernel
def _pascal(x: np.uint64) -> np.uint64:
    """Bit k of the result is the parity of those bits j of ``x`` for which C(j, k) is odd.

    That is the product of ``x`` with the second Sobol matrix, low bits for high ones. By
    Lucas' theorem C(j, k) is odd where the digits of k are among those of j, so the
    product factors into one step for each of the 5 digits.
    """
    x ^= (x >> np.uint64(1)) & np.uint64(0x55555555)
    x ^= (x >> np.uint64(2)) & np.uint64(0x33333333)
    x ^= (x >> np.uint64(4)) & np.uint64(0x0F0F0F0F)
    x ^= (x >> np.uint64(8)) & np.uint64(0x00FF00FF)
    return x ^ (x >> np.uint64(16))


@kernel
def sobol_2d(index: int, key: np.uint64) -> tuple[float, float]:
    """Point ``index`` of an Owen-scrambled (0, 2)-sequence; ``key`` chooses the scramble."""
    order = _permute(_reverse(np.uint64(index) & _LOW_32), mix(key) & _LOW_32)
    order = _reverse(order)
    # The sequence's points are the reverse of `order` and of its Pascal product: each
    # scramble would reverse them once more, which cancels.
    x = _reverse(_permute(order, mix(key + _MIX_1) & _LOW_32))
    y = _reverse(_permute(_pascal(order), mix(key + _MIX_2) & _LOW_32))
    return float(x) * _TO_UNIT_32, float(y) * _TO_UNIT_32


@kernel
def camera_2d(
    i: int, pixel_key: np.uint64, dimension: int, j: int = 0, each: int = 1
) -> tuple[float, float]:
    """Point ``j`` of the ``each`` points that pass ``i`` takes of a pixel's pair of dimensions.

    Pass i takes its points from replicate i % REPLICATES.
    """
    replicate = np.uint64(i % REPLICATES)
    index = (i // REPLICATES) * each + j
    return sobol_2d(index, mix(pixel_key + replicate) + np.uint64(dimension))
