"""Fresnel reflectance and the directions of reflection and refraction."""

from __future__ import annotations

import math

from ..geometry.vector import Vector, dot
from ..jit import kernel

#: Height of x (1 - x)^6 at x = 1 / 7, where it is largest: the cosine of 81.8 degrees.
_F82_COS = 1.0 / 7.0
_F82_PEAK = _F82_COS * (1.0 - _F82_COS) ** 6


@kernel
def fresnel_dielectric(cos_i: float, eta: float) -> tuple[float, float]:
    """Unpolarised reflectance and cosine of the refracted ray.

    ``cos_i`` >= 0, ``eta`` = n_transmitted / n_incident. Total internal reflection gives
    (1, 0). Born & Wolf, "Principles of Optics", section 1.5.
    """
    cos_i = min(1.0, max(0.0, cos_i))
    if eta == 1.0:
        return 0.0, cos_i
    sin2_i = (1.0 - cos_i) * (1.0 + cos_i)
    cos2_t = 1.0 - sin2_i / (eta * eta)
    if cos2_t <= 0.0:
        return 1.0, 0.0
    cos_t = math.sqrt(cos2_t)
    parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
    perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    return 0.5 * (parallel * parallel + perpendicular * perpendicular), cos_t


@kernel
def normal_reflectance(eta: float) -> float:
    """Reflectance of a dielectric at normal incidence."""
    r = (eta - 1.0) / (eta + 1.0)
    return r * r


@kernel
def fresnel_rise(cos_i: float, eta: float) -> float:
    """How far the reflectance has risen from that at normal incidence (0) to 1 (1).

    The true curve of a dielectric of ``eta``; where that has no shape (eta 0 or 1),
    Schlick's fifth power (Schlick 1994, eq. 15).
    """
    f0 = normal_reflectance(eta)
    if eta <= 0.0 or f0 < 1e-9:
        m = min(1.0, max(0.0, 1.0 - cos_i))
        return m * m * m * m * m
    return min(1.0, max(0.0, (fresnel_dielectric(cos_i, eta)[0] - f0) / (1.0 - f0)))


@kernel
def f82_dip(f0: float, tint: float) -> float:
    """Strength b of the F82 model's dip: F = Schlick - b x (1 - x)^6, x the cosine.

    The reflectance where the dip is deepest is ``tint`` times Schlick's value there
    (Kutz, Hasan & Edmondson 2021, "Novel Aspects of the Adobe Standard Material").
    """
    m = 1.0 - _F82_COS
    schlick = f0 + (1.0 - f0) * m * m * m * m * m
    return schlick * (1.0 - tint) / _F82_PEAK


@kernel
def fresnel_f82(cos_i: float, f0: float, tint: float) -> float:
    """Reflectance of a metal: ``f0`` at normal incidence, tinted near 82 degrees."""
    m = min(1.0, max(0.0, 1.0 - cos_i))
    m2 = m * m
    schlick = f0 + (1.0 - f0) * m2 * m2 * m
    return min(1.0, max(0.0, schlick - f82_dip(f0, tint) * cos_i * m2 * m2 * m2))


@kernel
def reflect(wo: Vector, n: Vector) -> Vector:
    """Mirror direction of ``wo`` (both point away from the surface)."""
    d = 2.0 * dot(wo, n)
    return (d * n[0] - wo[0], d * n[1] - wo[1], d * n[2] - wo[2])


@kernel
def refract(wo: Vector, n: Vector, eta: float, cos_t: float) -> Vector:
    """Snell's direction through the surface; dot(wo, n) >= 0 and ``cos_t`` from Fresnel."""
    cos_i = dot(wo, n)
    k = cos_i / eta - cos_t
    return (
        k * n[0] - wo[0] / eta,
        k * n[1] - wo[1] / eta,
        k * n[2] - wo[2] / eta,
    )
