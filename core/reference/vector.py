"""Three-vectors as tuples of floats, the random stream, and the sampling of directions."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..jit import allocating_kernel as kernel

Vec = tuple[float, float, float]
Stream = NDArray[np.uint64]

TWO_PI = 2.0 * math.pi
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
_MIX_2 = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


@kernel
def _scramble(z: np.uint64) -> np.uint64:
    """The finaliser of SplitMix64 (Steele, Lea & Flood 2014)."""
    z = np.uint64(z)
    z = np.uint64((z ^ (z >> _S30)) * _MIX_1)
    z = np.uint64((z ^ (z >> _S27)) * _MIX_2)
    return np.uint64(z ^ (z >> _S31))


@kernel
def start(stream: Stream, seed: int, index: int) -> None:
    """Put ``stream`` (1,) at the beginning of the sequence ``index`` of ``seed``."""
    mixed = _scramble(np.uint64(np.uint64(seed) + _GOLDEN))
    stream[0] = _scramble(np.uint64(mixed ^ (np.uint64(index) * _GOLDEN + _MIX_2)))


@kernel
def uniform(stream: Stream) -> float:
    """The next number of [0, 1), 53 bits, by SplitMix64."""
    stream[0] = stream[0] + _GOLDEN
    return float(_scramble(stream[0]) >> _S11) * (1.0 / 9007199254740992.0)


@kernel
def dot(a: Vec, b: Vec) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Vec, b: Vec) -> Vec:
    """Vector product."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@kernel
def scaled(a: Vec, s: float) -> Vec:
    """Vector times number."""
    return (a[0] * s, a[1] * s, a[2] * s)


@kernel
def times(a: Vec, b: Vec) -> Vec:
    """Product by channel."""
    return (a[0] * b[0], a[1] * b[1], a[2] * b[2])


@kernel
def along(origin: Vec, direction: Vec, t: float) -> Vec:
    """``origin + t * direction``."""
    return (
        origin[0] + t * direction[0],
        origin[1] + t * direction[1],
        origin[2] + t * direction[2],
    )


@kernel
def unit(a: Vec) -> Vec:
    """The vector at length 1."""
    return scaled(a, 1.0 / math.sqrt(dot(a, a)))


@kernel
def vec(column: NDArray[np.float64]) -> Vec:
    """Three numbers of a table as a vector."""
    return (column[0], column[1], column[2])


@kernel
def around(axis: Vec, cos_theta: float, sin_theta: float, phi: float) -> Vec:
    """The direction at polar angle theta and azimuth ``phi`` about the unit ``axis``."""
    # Cross with the coordinate axis that is least aligned: never near zero length.
    x, y, z = abs(axis[0]), abs(axis[1]), abs(axis[2])
    helper = (0.0, 0.0, 1.0)
    if x <= y and x <= z:
        helper = (1.0, 0.0, 0.0)
    elif y <= z:
        helper = (0.0, 1.0, 0.0)
    tangent = unit(cross(helper, axis))
    bitangent = cross(axis, tangent)
    p, q = sin_theta * math.cos(phi), sin_theta * math.sin(phi)
    return (
        p * tangent[0] + q * bitangent[0] + cos_theta * axis[0],
        p * tangent[1] + q * bitangent[1] + cos_theta * axis[1],
        p * tangent[2] + q * bitangent[2] + cos_theta * axis[2],
    )


@kernel
def sample_cosine_power(axis: Vec, exponent: float, u: float, v: float) -> Vec:
    """A direction of density (exponent + 1) / (2 pi) cos^exponent about ``axis``."""
    cos_theta = (1.0 - u) ** (1.0 / (exponent + 1.0))
    return around(axis, cos_theta, math.sqrt(max(0.0, 1.0 - cos_theta**2)), TWO_PI * v)


@kernel
def sample_cone(axis: Vec, height: float, u: float, v: float) -> Vec:
    """A direction uniform over the cap of ``height`` = 1 - cos(half angle) about ``axis``."""
    drop = u * height
    return around(axis, 1.0 - drop, math.sqrt(drop * (2.0 - drop)), TWO_PI * v)
