"""Rough glass: GGX microfacets that refract (Walter et al. 2007).

``eta`` = n_transmitted / n_incident as seen from ``wo``, ``n`` on the side of ``wo``. The
values are for radiance that leaves towards ``wo``: they hold the factor 1 / eta^2, which
flux does not have. Fresnel's share of transmission is the caller's.
"""

from __future__ import annotations

from ..geometry.vector import Vector, dot, normalize, scale
from ..jit import kernel
from .fresnel import fresnel_dielectric, refract
from .microfacet import distribution, masking_shadowing, sample_visible_normal, slope_length


@kernel
def half_refraction(n: Vector, wo: Vector, wi: Vector, eta: float) -> Vector:
    """Microfacet normal on the side of ``n`` that refracts ``wo`` into ``wi`` (eq. 16)."""
    h = normalize((
        wo[0] + eta * wi[0],
        wo[1] + eta * wi[1],
        wo[2] + eta * wi[2],
    ))  # fmt: skip
    return scale(h, -1.0) if dot(h, n) < 0.0 else h


@kernel
def _spread(wo_h: float, wi_h: float, eta: float) -> float:
    """|wi.h| / (wo.h + eta wi.h)^2: solid angle of h per that of wi, over eta^2 (eq. 17)."""
    t = wo_h + eta * wi_h
    if t == 0.0:
        return 0.0
    return abs(wi_h) / (t * t)


@kernel
def eval_refraction(n: Vector, wo: Vector, wi: Vector, alpha: float, eta: float) -> float:
    """BSDF value where all light is transmitted [1/sr]; ``wi`` below ``n`` (eq. 21)."""
    cos_o = dot(n, wo)
    cos_i = -dot(n, wi)
    if cos_o <= 0.0 or cos_i <= 0.0:
        return 0.0
    h = half_refraction(n, wo, wi, eta)
    wo_h = dot(wo, h)
    wi_h = dot(wi, h)
    if wo_h <= 0.0 or wi_h >= 0.0:
        return 0.0
    g = 4.0 * masking_shadowing(cos_o, cos_i, alpha)
    return g * distribution(dot(n, h), alpha) * wo_h * _spread(wo_h, wi_h, eta)


@kernel
def pdf_refraction(n: Vector, wo: Vector, wi: Vector, alpha: float, eta: float) -> float:
    """Density of ``sample_rough_refraction`` per solid angle."""
    cos_o = dot(n, wo)
    if cos_o <= 0.0:
        return 0.0
    h = half_refraction(n, wo, wi, eta)
    wo_h = dot(wo, h)
    wi_h = dot(wi, h)
    if wo_h <= 0.0 or wi_h >= 0.0:
        return 0.0
    visible = 2.0 * distribution(dot(n, h), alpha) / (cos_o + slope_length(cos_o, alpha))
    return visible * wo_h * eta * eta * _spread(wo_h, wi_h, eta)


@kernel
def sample_rough_refraction(
    n: Vector, wo: Vector, alpha: float, eta: float, u: float, v: float
) -> tuple[Vector, bool]:
    """Refract at a visible normal: (wi, possible); ``wi`` may lie above ``n``."""
    h = sample_visible_normal(n, wo, alpha, u, v)
    reflectance, cos_t = fresnel_dielectric(dot(wo, h), eta)
    if reflectance >= 1.0 and cos_t == 0.0:
        return wo, False
    return refract(wo, h, eta, cos_t), True
