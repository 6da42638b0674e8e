"""The modified Phong lobe, normalised so that it never gains energy.

f = (n + 2) / (2 pi) cos^n a, with a between wi and the mirror direction of wo
(Lafortune & Willems 1994, "Using the Modified Phong Reflectance Model").
Its albedo is 1 at normal incidence and falls towards grazing.
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector, dot, to_world
from ..jit import kernel
from .fresnel import reflect


@kernel
def eval_phong(n: Vector, wo: Vector, wi: Vector, exponent: float) -> float:
    """BSDF value for weight 1 [1/sr], both directions on the side of ``n``."""
    c = dot(reflect(wo, n), wi)
    if c <= 0.0:
        return 0.0
    return (exponent + 2.0) / (2.0 * math.pi) * math.pow(c, exponent)


@kernel
def pdf_phong(n: Vector, wo: Vector, wi: Vector, exponent: float) -> float:
    """Density of ``sample_phong`` per solid angle."""
    c = dot(reflect(wo, n), wi)
    if c <= 0.0:
        return 0.0
    return (exponent + 1.0) / (2.0 * math.pi) * math.pow(c, exponent)


@kernel
def sample_phong(n: Vector, wo: Vector, exponent: float, u: float, v: float) -> Vector:
    """Direction about the mirror direction with density ~ cos^n; it may lie below ``n``."""
    c = math.pow(1.0 - u, 1.0 / (exponent + 1.0))
    s = math.sqrt(max(0.0, 1.0 - c * c))
    phi = 2.0 * math.pi * v
    return to_world((s * math.cos(phi), s * math.sin(phi), c), reflect(wo, n))
