"""Spot lamp: a point lamp whose intensity falls off towards the edge of a cone."""

from __future__ import annotations

from ..jit import kernel


@kernel
def falloff(cos_angle: float, cos_outer: float, blend: float) -> float:
    """Blender's smooth step over the outer ``blend`` part of the cone, in [0, 1]."""
    if cos_angle <= cos_outer:
        return 0.0
    width = (1.0 - cos_outer) * blend
    if width <= 0.0:
        return 1.0
    t = min(1.0, (cos_angle - cos_outer) / width)
    return t * t * (3.0 - 2.0 * t)
