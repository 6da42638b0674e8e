"""Lambertian reflection: f = albedo / pi."""

from __future__ import annotations

from ..geometry.vector import Vector, dot, to_world
from ..jit import kernel
from ..sampling.warps import INV_PI, sample_cosine_hemisphere


@kernel
def eval_diffuse() -> float:
    """BSDF value for albedo 1 [1/sr], both directions on the same side."""
    return INV_PI


@kernel
def pdf_diffuse(n: Vector, wi: Vector) -> float:
    """Density of ``sample_diffuse`` per solid angle."""
    return max(0.0, dot(n, wi)) * INV_PI


@kernel
def sample_diffuse(n: Vector, u: float, v: float) -> Vector:
    """Direction with density cos / pi about ``n``."""
    return to_world(sample_cosine_hemisphere(u, v), n)
