"""Smooth interfaces in plain scalars: mirror direction, Snell's law, Fresnel's equations."""

from __future__ import annotations

import math

from ..jit import allocating_kernel as kernel
from .vector import Vec, dot


@kernel
def mirrored(direction: Vec, normal: Vec) -> Vec:
    """The travelling ``direction`` after reflection at a plane of unit ``normal``."""
    k = 2.0 * dot(direction, normal)
    return (
        direction[0] - k * normal[0],
        direction[1] - k * normal[1],
        direction[2] - k * normal[2],
    )


@kernel
def cos_transmitted(cos_i: float, n_i: float, n_t: float) -> float:
    """Cosine behind the interface by Snell's law, -1 at total internal reflection."""
    # 1 - sin^2 t with sin^2 i = (1 - c)(1 + c): exact where the cosine is near 1.
    ratio = n_i / n_t
    square = 1.0 - ratio * ratio * (1.0 - cos_i) * (1.0 + cos_i)
    return math.sqrt(square) if square > 0.0 else -1.0


@kernel
def reflectance(cos_i: float, n_i: float, n_t: float) -> float:
    """Unpolarised Fresnel reflectance (Born & Wolf, Principles of Optics, 1.5.2)."""
    if n_i == n_t:
        return 0.0
    cos_t = cos_transmitted(cos_i, n_i, n_t)
    if cos_t < 0.0 or cos_i <= 0.0:
        return 1.0
    perpendicular = (n_i * cos_i - n_t * cos_t) / (n_i * cos_i + n_t * cos_t)
    parallel = (n_t * cos_i - n_i * cos_t) / (n_t * cos_i + n_i * cos_t)
    return 0.5 * (perpendicular * perpendicular + parallel * parallel)


@kernel
def refracted(direction: Vec, normal: Vec, n_i: float, n_t: float) -> tuple[bool, Vec]:
    """Whether light passes, and the travelling direction behind; ``normal`` faces it."""
    if n_i == n_t:
        return True, direction
    cos_i = -dot(direction, normal)
    cos_t = cos_transmitted(cos_i, n_i, n_t)
    if cos_t < 0.0:
        return False, direction
    ratio = n_i / n_t
    k = ratio * cos_i - cos_t
    x = ratio * direction[0] + k * normal[0]
    y = ratio * direction[1] + k * normal[1]
    z = ratio * direction[2] + k * normal[2]
    s = 1.0 / math.sqrt(x * x + y * y + z * z)
    return True, (x * s, y * s, z * s)
