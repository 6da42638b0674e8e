"""Spot lamp: a point lamp whose intensity falls off towards the edge of a cone."""

from __future__ import annotations

import math

from ..geometry.vector import Vector, along, dot, normalize, scale, vector
from ..jit import Row, kernel
from ..sampling.warps import sample_cone


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


@kernel
def cone_share(lamp: Row, w: Vector) -> float:
    """Fraction of the axial intensity along ``w``; the lamp's scale stretches the cone."""
    x = dot(w, vector(lamp.axis_x)) / lamp.size_x
    y = dot(w, vector(lamp.axis_y)) / lamp.size_y
    z = -dot(w, vector(lamp.axis_z))
    if z == 0.0 and x == 0.0 and y == 0.0:
        return 0.0
    return falloff(z / math.sqrt(x * x + y * y + z * z), lamp.cos_outer, lamp.blend)


@kernel
def sample_in_cone(lamp: Row, u: float, v: float) -> tuple[Vector, float]:
    """Direction in the stretched cone: (w, pdf_w)."""
    versine = 1.0 - lamp.cos_outer
    local = sample_cone(versine, u, v)
    pdf_w = 1.0 / (2.0 * math.pi * versine)
    x = local[0] * lamp.size_x
    y = local[1] * lamp.size_y
    length = math.sqrt(x * x + y * y + local[2] * local[2])
    if length <= 0.0:
        return scale(vector(lamp.axis_z), -1.0), 0.0
    # A linear map S stretches solid angles by det S / |S w|^3.
    pdf_w *= length * length * length / (lamp.size_x * lamp.size_y)
    w = scale(vector(lamp.axis_z), -local[2])
    w = along(along(w, vector(lamp.axis_x), x), vector(lamp.axis_y), y)
    return normalize(w), pdf_w
