"""Rough diffuse reflection: Oren and Nayar's facets, with the light between them kept.

The qualitative model in the form of Fujii ("A tiny improvement of Oren-Nayar reflectance
model", 2012), and what its single bounces lose given back by the term of Portsmouth, Kutz
and Hill 2025 ("EON: A Practical Energy-Preserving Rough Diffuse BRDF", eq. 14 to 18).
``roughness`` 0..1; 0 is Lambert.
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector, dot
from ..jit import kernel

_BOUND = math.pi / 2.0 - 2.0 / 3.0


@kernel
def _scale(roughness: float) -> float:
    return 1.0 / (1.0 + roughness * _BOUND / math.pi)


@kernel
def albedo_oren_nayar(cosine: float, roughness: float) -> float:
    """Directional albedo of the single bounces, for facets of albedo 1 (exact)."""
    c = min(1.0, max(0.0, cosine))
    s = math.sqrt((1.0 - c) * (1.0 + c))
    if c < 1e-6:
        g = _BOUND - c
    else:
        g = s * (math.acos(c) - s * c - 2.0 / 3.0) + 2.0 / 3.0 * s / c * (1.0 - s * s * s)
    return _scale(roughness) * (1.0 + roughness * g / math.pi)


@kernel
def mean_albedo_oren_nayar(roughness: float) -> float:
    """Cosine-weighted mean of ``albedo_oren_nayar``."""
    return _scale(roughness) * (1.0 + roughness * (2.0 / 3.0 - 28.0 / 15.0 / math.pi))


@kernel
def eval_oren_nayar(
    n: Vector, wo: Vector, wi: Vector, roughness: float, color: Vector
) -> Vector:
    """BSDF value over ``color`` [1/sr], the albedo of the facets; directions above ``n``."""
    cos_o = dot(n, wo)
    cos_i = dot(n, wi)
    if cos_o <= 0.0 or cos_i <= 0.0:
        return 0.0, 0.0, 0.0
    s = dot(wo, wi) - cos_o * cos_i
    if s > 0.0:
        s /= max(cos_o, cos_i)
    single = _scale(roughness) * (1.0 + roughness * s) / math.pi
    mean = mean_albedo_oren_nayar(roughness)
    lost = (1.0 - albedo_oren_nayar(cos_o, roughness)) * (
        1.0 - albedo_oren_nayar(cos_i, roughness)
    )
    many = 0.0 if mean >= 1.0 else lost * mean / ((1.0 - mean) * math.pi)
    # Cycles has one more factor of the colour here than the paper (measured: albedo 0.5 at
    # roughness 1 seen from above gives 0.414, not 0.439), and so have we.
    c = (color[0] * color[0], color[1] * color[1], color[2] * color[2])
    return (
        single + many * c[0] / (1.0 - color[0] * (1.0 - mean)),
        single + many * c[1] / (1.0 - color[1] * (1.0 - mean)),
        single + many * c[2] / (1.0 - color[2] * (1.0 - mean)),
    )
