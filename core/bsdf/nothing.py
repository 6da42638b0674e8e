"""The BRDF of a free place in ``added``: it reflects nothing."""

from __future__ import annotations

from ..geometry.vector import Vector
from ..jit import Row, kernel
from .diffuse import pdf_diffuse, sample_diffuse


@kernel
def evaluate(lobe: Row, n: Vector, wo: Vector, wi: Vector) -> Vector:
    """BRDF value [1/sr] per channel, the lobe's weight included; both sides above ``n``."""
    return 0.0, 0.0, 0.0


@kernel
def sample(lobe: Row, n: Vector, wo: Vector, u: float, v: float) -> Vector:
    """A direction for two random numbers; below ``n`` it counts for nothing."""
    return sample_diffuse(n, u, v)


@kernel
def pdf(lobe: Row, n: Vector, wo: Vector, wi: Vector) -> float:
    """Density of ``sample`` per solid angle."""
    return pdf_diffuse(n, wi)
