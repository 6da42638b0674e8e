"""The uniform world: constant radiance from everywhere that nothing covers."""

from __future__ import annotations

from ..geometry.vector import Vector, dot, to_world
from ..jit import kernel
from ..sampling.warps import INV_PI, sample_cosine_hemisphere


@kernel
def sample_world(n: Vector, u: float, v: float) -> tuple[Vector, float]:
    """Direction about ``n`` in proportion to its cosine: (wi, pdf_w)."""
    wi = to_world(sample_cosine_hemisphere(u, v), n)
    return wi, dot(n, wi) * INV_PI


@kernel
def pdf_world(n: Vector, wi: Vector) -> float:
    """Density of ``sample_world`` per solid angle."""
    return max(0.0, dot(n, wi)) * INV_PI
