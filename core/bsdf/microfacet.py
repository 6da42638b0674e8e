"""GGX microfacets: distribution, Smith's masking, visible normals and their mirror lobe.

Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces"; the
height-correlated masking-shadowing of Heitz 2014, "Understanding the Masking-Shadowing
Function"; visible normals by the spherical caps of Dupuy & Benyoub 2023. ``alpha`` is the
width of the slopes; ``n`` is on the side of ``wo``. All forms are free of divisions by the
cosines, so that they hold at grazing.
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector, add, basis, dot, normalize
from ..jit import kernel
from .fresnel import reflect


@kernel
def distribution(cos_h: float, alpha: float) -> float:
    """Density of microfacet normals D(h) [1/sr], h at ``cos_h`` from the normal."""
    c2 = min(1.0, cos_h * cos_h)
    a2 = alpha * alpha
    t = (1.0 - c2) + a2 * c2
    return a2 / (math.pi * t * t)


@kernel
def slope_length(cosine: float, alpha: float) -> float:
    """sqrt(cos^2 + alpha^2 sin^2): the Smith terms are made of it.

    Lambda = (length / cos - 1) / 2, therefore G1 = 2 cos / (cos + length).
    """
    c2 = cosine * cosine
    return math.sqrt(c2 + alpha * alpha * max(0.0, 1.0 - c2))


@kernel
def masking(cosine: float, alpha: float) -> float:
    """Smith's G1: the visible share of the microfacets, seen at ``cosine`` >= 0."""
    if cosine <= 0.0:
        return 0.0
    return 2.0 * cosine / (cosine + slope_length(cosine, alpha))


@kernel
def masking_shadowing(cos_o: float, cos_i: float, alpha: float) -> float:
    """Smith's height-correlated G2 / (4 cos_o cos_i); both cosines >= 0 (Heitz 2014, 99)."""
    t = cos_o * slope_length(cos_i, alpha) + cos_i * slope_length(cos_o, alpha)
    if t <= 0.0:
        return 0.0
    return 0.5 / t


@kernel
def shadowing_given_masking(cos_o: float, cos_i: float, alpha: float) -> float:
    """G2 / G1(cos_o): what a path drawn from the visible normals keeps."""
    slope_i = slope_length(cos_i, alpha)
    t = cos_o * slope_i + cos_i * slope_length(cos_o, alpha)
    if t <= 0.0:
        return 0.0
    return cos_i * (cos_o + slope_length(cos_o, alpha)) / t


@kernel
def half_reflection(wo: Vector, wi: Vector) -> Vector:
    """Microfacet normal that mirrors ``wo`` into ``wi``."""
    return normalize(add(wo, wi))


@kernel
def eval_ggx(n: Vector, wo: Vector, wi: Vector, alpha: float) -> float:
    """BSDF value for reflectance 1 [1/sr], both directions on the side of ``n``."""
    cos_o = dot(n, wo)
    cos_i = dot(n, wi)
    if cos_o <= 0.0 or cos_i <= 0.0:
        return 0.0
    cos_h = dot(n, half_reflection(wo, wi))
    return distribution(cos_h, alpha) * masking_shadowing(cos_o, cos_i, alpha)


@kernel
def pdf_ggx(n: Vector, wo: Vector, wi: Vector, alpha: float) -> float:
    """Density of mirror directions at visible normals, per solid angle.

    ``wi`` may lie below ``n``: such samples are drawn and scatter nothing.
    """
    cos_o = dot(n, wo)
    h = half_reflection(wo, wi)
    cos_h = dot(n, h)
    if cos_o <= 0.0 or cos_h <= 0.0 or dot(wo, h) <= 0.0:
        return 0.0
    return 0.5 * distribution(cos_h, alpha) / (cos_o + slope_length(cos_o, alpha))


@kernel
def sample_visible_normal(n: Vector, wo: Vector, alpha: float, u: float, v: float) -> Vector:
    """Microfacet normal with density G1 max(0, wo.h) D(h) / cos_o about ``n``."""
    t, s = basis(n)
    stretched = normalize((alpha * dot(wo, t), alpha * dot(wo, s), dot(wo, n)))
    # A cap of the unit sphere about the stretched direction, then halfway towards it.
    phi = 2.0 * math.pi * u
    z = (1.0 - v) * (1.0 + stretched[2]) - stretched[2]
    r = math.sqrt(max(0.0, 1.0 - z * z))
    x = alpha * (r * math.cos(phi) + stretched[0])
    y = alpha * (r * math.sin(phi) + stretched[1])
    z = max(0.0, z + stretched[2])
    h = (
        x * t[0] + y * s[0] + z * n[0],
        x * t[1] + y * s[1] + z * n[1],
        x * t[2] + y * s[2] + z * n[2],
    )
    if x == 0.0 and y == 0.0 and z == 0.0:
        return n
    return normalize(h)


@kernel
def sample_ggx(n: Vector, wo: Vector, alpha: float, u: float, v: float) -> Vector:
    """Mirror direction at a visible normal; it may lie below ``n``."""
    return reflect(wo, sample_visible_normal(n, wo, alpha, u, v))
