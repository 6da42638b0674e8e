"""Sun lamp: parallel light, or a disc of constant radiance seen under a full angle."""

from __future__ import annotations

import math

from ..geometry.vector import Vector, dot, subtract
from ..jit import kernel


@kernel
def versine(angle: float) -> float:
    """1 - cos of half the full ``angle``, exact for tiny suns."""
    s = math.sin(0.25 * angle)
    return 2.0 * s * s


@kernel
def radiance_scale(angle: float) -> float:
    """Radiance of the disc per irradiance on a facing plane: 1 / (pi sin^2(angle / 2))."""
    s = math.sin(0.5 * angle)
    return 1.0 / (math.pi * s * s)


@kernel
def in_disc(to_sun: Vector, d: Vector, angle: float) -> bool:
    """Whether unit ``d`` points into the disc around unit ``to_sun``."""
    gap = subtract(d, to_sun)
    return dot(d, to_sun) > 0.0 and 0.5 * dot(gap, gap) <= versine(angle)
