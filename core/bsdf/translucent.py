"""Lambertian transmission: f = albedo / pi on the other side."""

from __future__ import annotations

from ..geometry.vector import Vector, dot, scale, to_world
from ..jit import kernel
from ..sampling.warps import INV_PI, sample_cosine_hemisphere


@kernel
def eval_translucent() -> float:
    """BSDF value for albedo 1 [1/sr], the directions on different sides."""
    return INV_PI


@kernel
def pdf_translucent(n: Vector, wi: Vector) -> float:
    """Density of ``sample_translucent`` per solid angle."""
    return max(0.0, -dot(n, wi)) * INV_PI


@kernel
def sample_translucent(n: Vector, u: float, v: float) -> Vector:
    """Direction with density cos / pi about ``-n``."""
    return to_world(sample_cosine_hemisphere(u, v), scale(n, -1.0))
