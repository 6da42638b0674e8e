"""Smooth conductor of constant reflectivity: a tinted mirror."""

from __future__ import annotations

from ..geometry.vector import Vector
from ..jit import kernel
from .fresnel import reflect


@kernel
def sample_conductor(n: Vector, wo: Vector) -> Vector:
    """The mirror direction, the only one this lobe scatters to."""
    return reflect(wo, n)
