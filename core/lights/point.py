"""Point lamp: a point, or a sphere of constant radiance I / (pi r^2) outside."""

from __future__ import annotations

import math

from ..geometry.vector import Vector, dot, scale, subtract, to_world
from ..jit import kernel
from ..sampling.warps import one_minus_cos, sample_cone


@kernel
def sample_sphere_li(
    centre: Vector, radius: float, p: Vector, u: float, v: float
) -> tuple[Vector, float, float]:
    """Direction to a sphere, uniform in its solid angle: (wi, distance, pdf_w).

    ``pdf_w`` is 0 when ``p`` lies inside, where the sphere shows no outside.
    """
    to_centre = subtract(centre, p)
    d2 = dot(to_centre, to_centre)
    if d2 <= radius * radius:
        return to_centre, 0.0, 0.0
    d = math.sqrt(d2)
    versine = one_minus_cos(radius * radius / d2)
    local = sample_cone(versine, u, v)
    wi = to_world(local, scale(to_centre, 1.0 / d))
    # Distance to the near side, from the angle alone: stable for tiny and far spheres.
    sin2 = local[0] * local[0] + local[1] * local[1]
    half = math.sqrt(max(0.0, radius * radius - d2 * sin2))
    return wi, d * local[2] - half, 1.0 / (2.0 * math.pi * versine)


@kernel
def hit_sphere(centre: Vector, radius: float, o: Vector, d: Vector) -> tuple[float, float]:
    """Nearest hit from outside: (distance, pdf_w of ``sample_sphere_li``); -1 if missed."""
    oc = subtract(centre, o)
    d2 = dot(oc, oc)
    r2 = radius * radius
    along_ray = dot(oc, d)
    if d2 <= r2 or along_ray <= 0.0:
        return -1.0, 0.0
    side = subtract(oc, scale(d, along_ray))
    b2 = dot(side, side)
    if b2 > r2:
        return -1.0, 0.0
    pdf_w = 1.0 / (2.0 * math.pi * one_minus_cos(r2 / d2))
    return along_ray - math.sqrt(r2 - b2), pdf_w


@kernel
def beam_origin(centre: Vector, radius: float, w: Vector, x: float, y: float) -> Vector:
    """Start on the sphere of the ray along ``w`` through disc point (x, y) of radius 1.

    A sphere of constant radiance sends the same parallel beam into every direction.
    """
    depth = math.sqrt(max(0.0, 1.0 - x * x - y * y))
    local = to_world((x, y, depth), w)
    return (
        centre[0] + radius * local[0],
        centre[1] + radius * local[1],
        centre[2] + radius * local[2],
    )
