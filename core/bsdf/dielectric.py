"""Smooth dielectric: Snell's law, unpolarised Fresnel, total internal reflection."""

from __future__ import annotations

from ..geometry.vector import Vector, dot
from ..jit import kernel
from .fresnel import fresnel_dielectric, reflect, refract


@kernel
def sample_dielectric(n: Vector, wo: Vector, eta: float, u: float) -> tuple[Vector, bool]:
    """Reflect with probability F, else refract: (wi, transmitted); the weight is 1.

    ``n`` on the side of ``wo``; ``eta`` = n_transmitted / n_incident. Radiance still has
    to be scaled by 1 / eta^2 after a refraction, photon power has not.
    """
    reflectance, cos_t = fresnel_dielectric(dot(wo, n), eta)
    if u < reflectance:
        return reflect(wo, n), False
    return refract(wo, n, eta, cos_t), True


@kernel
def sample_refraction(n: Vector, wo: Vector, eta: float) -> tuple[Vector, bool]:
    """Refract always: (wi, possible); nothing passes at total internal reflection."""
    reflectance, cos_t = fresnel_dielectric(dot(wo, n), eta)
    if reflectance >= 1.0 and cos_t == 0.0:
        return wo, False
    return refract(wo, n, eta, cos_t), True
