"""Area lamp: a one-sided Lambertian rectangle or ellipse in its own x-y plane."""

from __future__ import annotations

import math

from ..geometry.vector import Vector, along, dot, subtract, vector
from ..jit import Row, kernel
from ..sampling.warps import sample_disk


@kernel
def area(lamp: Row, disk: bool) -> float:
    """Surface in m^2."""
    if disk:
        return 0.25 * math.pi * lamp.size_x * lamp.size_y
    return lamp.size_x * lamp.size_y


@kernel
def sample_point(lamp: Row, disk: bool, u: float, v: float) -> Vector:
    """Point uniform over the surface."""
    if disk:
        x, y = sample_disk(u, v)
        x *= 0.5
        y *= 0.5
    else:
        x = u - 0.5
        y = v - 0.5
    p = along(vector(lamp.position), vector(lamp.axis_x), x * lamp.size_x)
    return along(p, vector(lamp.axis_y), y * lamp.size_y)


@kernel
def hit_area(lamp: Row, disk: bool, o: Vector, d: Vector) -> tuple[float, float]:
    """Hit of the shining side: (distance, pdf_w of a uniform point); -1 if missed."""
    axis_z = vector(lamp.axis_z)
    cos_light = dot(d, axis_z)
    if cos_light <= 0.0:
        return -1.0, 0.0
    to_centre = subtract(vector(lamp.position), o)
    t = dot(to_centre, axis_z) / cos_light
    if t <= 0.0:
        return -1.0, 0.0
    q = subtract((t * d[0], t * d[1], t * d[2]), to_centre)
    x = dot(q, vector(lamp.axis_x)) / lamp.size_x
    y = dot(q, vector(lamp.axis_y)) / lamp.size_y
    if disk:
        if x * x + y * y > 0.25:
            return -1.0, 0.0
    elif abs(x) > 0.5 or abs(y) > 0.5:
        return -1.0, 0.0
    return t, t * t / (cos_light * area(lamp, disk))
