"""Area lamp: a one-sided rectangle or ellipse in its own x-y plane.

Lambertian, or with a spread: slats before it let light out by 1 - tan a / tan e at the
angle a from the axis, e being half the spread, and the power stays. The integral of
cos a (1 - tan a / tan e) over the cone is pi (1 - e / tan e).
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector, along, dot, subtract, to_world, vector
from ..jit import Row, kernel
from ..sampling.warps import sample_disk

#: A spread from here on is none [rad].
_FULL = math.pi - 1e-4


@kernel
def area(lamp: Row, disk: bool) -> float:
    """Surface in m^2."""
    if disk:
        return 0.25 * math.pi * lamp.size_x * lamp.size_y
    return lamp.size_x * lamp.size_y


@kernel
def spread_share(lamp: Row, cos_light: float) -> float:
    """Radiance at an angle to the axis over the mean one; 1 without spread."""
    if lamp.spread >= _FULL:
        return 1.0
    if cos_light <= 0.0:
        return 0.0
    half = 0.5 * lamp.spread
    tan_half = math.tan(half)
    tan_light = math.sqrt(max(0.0, 1.0 - cos_light * cos_light)) / cos_light
    return max(0.0, (tan_half - tan_light) / (tan_half - half))


@kernel
def window(lamp: Row, p: Vector) -> tuple[float, float, float, float]:
    """Part (x0, x1, y0, y1), in sizes from the middle, that sends light to ``p``.

    The box about what the spread lets through; it may be empty.
    """
    if lamp.spread >= _FULL:
        return -0.5, 0.5, -0.5, 0.5
    q = subtract(p, vector(lamp.position))
    reach = abs(dot(q, vector(lamp.axis_z))) * math.tan(0.5 * lamp.spread)
    x = dot(q, vector(lamp.axis_x))
    y = dot(q, vector(lamp.axis_y))
    return (
        max(-0.5, (x - reach) / lamp.size_x),
        min(0.5, (x + reach) / lamp.size_x),
        max(-0.5, (y - reach) / lamp.size_y),
        min(0.5, (y + reach) / lamp.size_y),
    )


@kernel
def _uses_window(lamp: Row, disk: bool, x0: float, x1: float, y0: float, y1: float) -> bool:
    """Whether points are drawn from the window rather than from the whole ellipse."""
    return not disk or (x1 - x0) * (y1 - y0) < 0.25 * math.pi


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
def sample_seen_point(
    lamp: Row, disk: bool, p: Vector, u: float, v: float
) -> tuple[Vector, float]:
    """Point uniform over what may send light to ``p``: (point, pdf_a); pdf 0: no light."""
    x0, x1, y0, y1 = window(lamp, p)
    if x1 <= x0 or y1 <= y0:
        return p, 0.0
    if not _uses_window(lamp, disk, x0, x1, y0, y1):
        return sample_point(lamp, disk, u, v), 1.0 / area(lamp, disk)
    x = x0 + u * (x1 - x0)
    y = y0 + v * (y1 - y0)
    if disk and x * x + y * y > 0.25:
        return p, 0.0
    q = along(vector(lamp.position), vector(lamp.axis_x), x * lamp.size_x)
    q = along(q, vector(lamp.axis_y), y * lamp.size_y)
    return q, 1.0 / ((x1 - x0) * (y1 - y0) * lamp.size_x * lamp.size_y)


@kernel
def hit_area(lamp: Row, disk: bool, o: Vector, d: Vector) -> tuple[float, float, float]:
    """Hit of the shining side: (distance, pdf_w of the sampled point, cosine); -1: missed."""
    axis_z = vector(lamp.axis_z)
    cos_light = dot(d, axis_z)
    if cos_light <= 0.0:
        return -1.0, 0.0, 0.0
    to_centre = subtract(vector(lamp.position), o)
    t = dot(to_centre, axis_z) / cos_light
    if t <= 0.0:
        return -1.0, 0.0, 0.0
    q = subtract((t * d[0], t * d[1], t * d[2]), to_centre)
    x = dot(q, vector(lamp.axis_x)) / lamp.size_x
    y = dot(q, vector(lamp.axis_y)) / lamp.size_y
    if disk:
        if x * x + y * y > 0.25:
            return -1.0, 0.0, 0.0
    elif abs(x) > 0.5 or abs(y) > 0.5:
        return -1.0, 0.0, 0.0
    x0, x1, y0, y1 = window(lamp, o)
    if _uses_window(lamp, disk, x0, x1, y0, y1):
        if x < x0 or x > x1 or y < y0 or y > y1:
            return t, 0.0, cos_light
        pdf_a = 1.0 / ((x1 - x0) * (y1 - y0) * lamp.size_x * lamp.size_y)
    else:
        pdf_a = 1.0 / area(lamp, disk)
    return t, t * t * pdf_a / cos_light, cos_light


@kernel
def sample_shine(lamp: Row, u: float, v: float) -> tuple[Vector, float]:
    """Direction of a photon, by the cosine within the spread: (w, pdf_w)."""
    sine = 1.0 if lamp.spread >= _FULL else math.sin(0.5 * lamp.spread)
    x, y = sample_disk(u, v)
    x *= sine
    y *= sine
    z = math.sqrt(max(0.0, 1.0 - x * x - y * y))
    n = (-lamp.axis_z[0], -lamp.axis_z[1], -lamp.axis_z[2])
    return to_world((x, y, z), n), z / (math.pi * sine * sine)
