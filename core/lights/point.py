"""Point lamp: a point, a sphere of constant radiance I / (pi r^2), or a soft disc.

The soft disc (Blender's soft falloff) has the same radiance and stands across the line from
its centre to whoever looks, so it lights what lies within its radius too.
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector, dot, scale, subtract, to_world
from ..jit import kernel
from ..sampling.warps import one_minus_cos, sample_cone, sample_disk, sample_sphere


@kernel
def sample_sphere_li(
    centre: Vector, radius: float, p: Vector, u: float, v: float
) -> tuple[Vector, float, float]:
    """Direction to a sphere, uniform in its solid angle: (wi, distance, pdf_w).

    From inside, the sphere is all around.
    """
    to_centre = subtract(centre, p)
    d2 = dot(to_centre, to_centre)
    if d2 <= radius * radius:
        wi = sample_sphere(u, v)
        across = dot(to_centre, wi)
        far = across + math.sqrt(max(0.0, radius * radius - d2 + across * across))
        return wi, far, 1.0 / (4.0 * math.pi)
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
    """Nearest hit: (distance, pdf_w of ``sample_sphere_li``); -1 if missed."""
    oc = subtract(centre, o)
    d2 = dot(oc, oc)
    r2 = radius * radius
    along_ray = dot(oc, d)
    side = subtract(oc, scale(d, along_ray))
    b2 = dot(side, side)
    if d2 <= r2:
        return along_ray + math.sqrt(max(0.0, r2 - b2)), 1.0 / (4.0 * math.pi)
    if along_ray <= 0.0 or b2 > r2:
        return -1.0, 0.0
    pdf_w = 1.0 / (2.0 * math.pi * one_minus_cos(r2 / d2))
    return along_ray - math.sqrt(r2 - b2), pdf_w


@kernel
def sample_soft_li(
    centre: Vector, radius: float, p: Vector, u: float, v: float
) -> tuple[Vector, float, float]:
    """Direction to the disc that faces ``p``, uniform in area: (wi, distance, pdf_w)."""
    to_centre = subtract(centre, p)
    d2 = dot(to_centre, to_centre)
    if d2 <= 0.0:
        return to_centre, 0.0, 0.0
    d = math.sqrt(d2)
    x, y = sample_disk(u, v)
    to_light = to_world((radius * x, radius * y, d), scale(to_centre, 1.0 / d))
    t2 = d2 + radius * radius * (x * x + y * y)
    t = math.sqrt(t2)
    return scale(to_light, 1.0 / t), t, t2 * t / (d * math.pi * radius * radius)


@kernel
def hit_soft(centre: Vector, radius: float, o: Vector, d: Vector) -> tuple[float, float]:
    """Hit of the disc that faces ``o``: (distance, pdf_w); -1 if missed."""
    oc = subtract(centre, o)
    d2 = dot(oc, oc)
    along_ray = dot(oc, d)
    if along_ray <= 0.0 or d2 <= 0.0:
        return -1.0, 0.0
    t = d2 / along_ray
    side = subtract(oc, scale(d, t))
    if dot(side, side) > radius * radius:
        return -1.0, 0.0
    return t, t * t * t / (math.sqrt(d2) * math.pi * radius * radius)


@kernel
def soft_reaches(centre: Vector, radius: float, start: Vector, p: Vector) -> bool:
    """Whether ``p`` sees the disc along the beam that passes the centre at ``start``.

    The beam's distance b from the centre and that of ``p``, D, tell: on the disc the line
    meets b D / sqrt(D^2 - b^2) from the centre.
    """
    near = subtract(start, centre)
    far = subtract(p, centre)
    b2 = dot(near, near)
    d2 = dot(far, far)
    return b2 * (d2 + radius * radius) <= radius * radius * d2


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


@kernel
def soft_origin(centre: Vector, radius: float, w: Vector, x: float, y: float) -> Vector:
    """Start beside the centre of the beam along ``w`` through disc point (x, y)."""
    side = to_world((radius * x, radius * y, 0.0), w)
    return (centre[0] + side[0], centre[1] + side[1], centre[2] + side[2])
