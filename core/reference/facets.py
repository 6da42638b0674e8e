"""Rough surfaces in plain scalars: GGX facets, their Fresnel factors, rough diffuse ones.

``d`` is the direction in which light (or the path) arrives, ``n`` the unit normal facing it;
``out`` the direction in which it leaves.
"""

from __future__ import annotations

import math

from ..jit import Row, kernel
from ..scene.tables import Fresnel
from .optics import reflectance
from .vector import TWO_PI, Vec, around, dot, unit

_DIELECTRIC, _F82 = int(Fresnel.DIELECTRIC), int(Fresnel.F82)
_SCHLICK = int(Fresnel.SCHLICK)


@kernel
def density_of_normals(cos_h: float, alpha: float) -> float:
    """GGX: alpha^2 / (pi cos^4 (alpha^2 + tan^2)^2) (Walter et al. 2007, equation 33)."""
    if cos_h <= 0.0:
        return 0.0
    tan_2 = 1.0 / (cos_h * cos_h) - 1.0
    return alpha**2 / (math.pi * cos_h**4 * (alpha**2 + tan_2) ** 2)


@kernel
def _hidden(cosine: float, alpha: float) -> float:
    """Smith's Lambda (Heitz 2014, equation 72)."""
    tan_2 = 1.0 / (cosine * cosine) - 1.0
    return 0.5 * (math.sqrt(1.0 + alpha**2 * tan_2) - 1.0)


@kernel
def visible_both_ways(cos_a: float, cos_b: float, alpha: float) -> float:
    """Height-correlated masking and shadowing G2."""
    return 1.0 / (1.0 + _hidden(cos_a, alpha) + _hidden(cos_b, alpha))


@kernel
def sample_normal(n: Vec, alpha: float, u: float, v: float) -> Vec:
    """A facet's normal of density D cos about ``n`` (Walter et al. 2007, equation 35)."""
    theta = math.atan(alpha * math.sqrt(u / (1.0 - u)))
    return around(n, math.cos(theta), math.sin(theta), TWO_PI * v)


@kernel
def fresnel_of(lobe: Row, cos_h: float) -> Vec:
    """Reflectance of a facet of a reflecting lobe, per channel."""
    away = min(1.0, max(0.0, 1.0 - cos_h))
    if lobe.fresnel == _DIELECTRIC:
        f = reflectance(cos_h, 1.0, lobe.eta)
        return (f, f, f)
    if lobe.fresnel == _SCHLICK:
        start = ((lobe.eta - 1.0) / (lobe.eta + 1.0)) ** 2
        rise = away**5
        if start > 1e-9:
            rise = max(0.0, (reflectance(cos_h, 1.0, lobe.eta) - start) / (1.0 - start))
        return (
            lobe.f0[0] * (1.0 - rise) + lobe.f90[0] * rise,
            lobe.f0[1] * (1.0 - rise) + lobe.f90[1] * rise,
            lobe.f0[2] * (1.0 - rise) + lobe.f90[2] * rise,
        )
    if lobe.fresnel == _F82:
        return (
            _f82(lobe.f0[0], lobe.f90[0], cos_h, away),
            _f82(lobe.f0[1], lobe.f90[1], cos_h, away),
            _f82(lobe.f0[2], lobe.f90[2], cos_h, away),
        )
    return (1.0, 1.0, 1.0)


@kernel
def _f82(f0: float, tint: float, cos_h: float, away: float) -> float:
    # The dip has its depth where cos (1 - cos)^6 is largest, at a cosine of 1 / 7.
    deep = (1.0 / 7.0) * (6.0 / 7.0) ** 6
    there = f0 + (1.0 - f0) * (6.0 / 7.0) ** 5
    value = f0 + (1.0 - f0) * away**5 - there * (1.0 - tint) * cos_h * away**6 / deep
    return min(1.0, max(0.0, value))


@kernel
def eval_facets(lobe: Row, d: Vec, n: Vec, out: Vec) -> Vec:
    """BSDF of a reflecting GGX lobe, its weight left out [1/sr]."""
    cos_a, cos_b = -dot(d, n), dot(out, n)
    if cos_a <= 0.0 or cos_b <= 0.0:
        return (0.0, 0.0, 0.0)
    h = unit((out[0] - d[0], out[1] - d[1], out[2] - d[2]))
    shape = density_of_normals(dot(h, n), lobe.roughness)
    shape *= visible_both_ways(cos_a, cos_b, lobe.roughness) / (4.0 * cos_a * cos_b)
    f = fresnel_of(lobe, -dot(d, h))
    return (f[0] * shape, f[1] * shape, f[2] * shape)


@kernel
def pdf_facets(lobe: Row, d: Vec, n: Vec, out: Vec) -> float:
    """Density of mirror directions at normals of ``sample_normal``."""
    h = unit((out[0] - d[0], out[1] - d[1], out[2] - d[2]))
    cos_d = -dot(d, h)
    if cos_d <= 0.0:
        return 0.0
    return density_of_normals(dot(h, n), lobe.roughness) * dot(h, n) / (4.0 * cos_d)


@kernel
def _single(cosine: float, sigma: float) -> float:
    """Directional albedo of Fujii's rough diffuse facets of albedo 1."""
    a = 1.0 / (math.pi + (math.pi / 2.0 - 2.0 / 3.0) * sigma)
    theta = math.acos(min(1.0, cosine))
    sine = math.sin(theta)
    g = math.pi / 2.0 - 2.0 / 3.0 - cosine
    if cosine > 1e-6:
        g = sine * (theta - sine * cosine - 2.0 / 3.0)
        g += 2.0 / 3.0 * math.tan(theta) * (1.0 - sine**3)
    return a * (math.pi + sigma * g)


@kernel
def eval_rough_diffuse(lobe: Row, d: Vec, n: Vec, out: Vec, channel: int) -> float:
    """BSDF of an Oren-Nayar lobe in one channel, its weight left out [1/sr]."""
    cos_a, cos_b, sigma = -dot(d, n), dot(out, n), lobe.roughness
    if cos_a <= 0.0 or cos_b <= 0.0:
        return 0.0
    a = 1.0 / (math.pi + (math.pi / 2.0 - 2.0 / 3.0) * sigma)
    s = -dot(d, out) - cos_a * cos_b
    if s > 0.0:
        s /= max(cos_a, cos_b)
    mean = a * (math.pi + sigma * (2.0 * math.pi - 5.6) / 3.0)
    lost = (1.0 - _single(cos_a, sigma)) * (1.0 - _single(cos_b, sigma))
    rho = lobe.f0[channel]
    many = lost * mean * rho * rho / (math.pi * (1.0 - rho * (1.0 - mean)))
    if mean < 1.0:
        many /= 1.0 - mean
    return a * (1.0 + sigma * s) + many
