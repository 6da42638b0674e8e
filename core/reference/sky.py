"""Radiance of the surroundings: one colour, or a picture all around."""

from __future__ import annotations

import math

from ..jit import kernel
from .flat import Flat
from .vector import TWO_PI, Vec


@kernel
def sky_radiance(s: Flat, d: Vec) -> Vec:
    """What arrives from ``d``; the picture is interpolated between its texels' middles."""
    tall, wide, _ = s.sky_picture.shape
    if tall == 0:
        return s.sky[0], s.sky[1], s.sky[2]
    x = s.sky_turn[0, 0] * d[0] + s.sky_turn[0, 1] * d[1] + s.sky_turn[0, 2] * d[2]
    y = s.sky_turn[1, 0] * d[0] + s.sky_turn[1, 1] * d[1] + s.sky_turn[1, 2] * d[2]
    z = s.sky_turn[2, 0] * d[0] + s.sky_turn[2, 1] * d[1] + s.sky_turn[2, 2] * d[2]
    # The picture's middle looks along +x, its left quarter along +y, its top up.
    across = (0.5 - math.atan2(y, x) / TWO_PI) * wide - 0.5
    above = (1.0 - math.acos(max(-1.0, min(1.0, z))) / math.pi) * tall - 0.5
    r, g, b = 0.0, 0.0, 0.0
    for line in range(int(math.floor(above)), int(math.floor(above)) + 2):
        for column in range(int(math.floor(across)), int(math.floor(across)) + 2):
            weight = (1.0 - abs(above - line)) * (1.0 - abs(across - column))
            texel = s.sky_picture[line % tall, column % wide]
            r += weight * texel[0]
            g += weight * texel[1]
            b += weight * texel[2]
    return r * s.sky[0], g * s.sky[1], b * s.sky[2]
