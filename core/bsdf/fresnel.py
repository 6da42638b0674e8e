"""Fresnel reflectance and the directions of reflection and refraction."""

from __future__ import annotations

import math

from ..geometry.vector import Vector, dot
from ..jit import kernel


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
