"""Density estimates: reflected radiance from the photons around a point.

Jensen 1996 with the 2-D Epanechnikov kernel k = 2 / (pi r^2) (1 - d^2 / r^2) on the
tangent plane (Silverman 1986, section 4.2): Lo = sum f(wi, wo) flux k. There is no
brightness to set by hand.
"""

from __future__ import annotations

import math

from ..bsdf.dispatch import albedo_nonspecular, eval_nonspecular, is_lambertian
from ..geometry.vector import Vector, vector
from ..jit import Row, Table, kernel
from ..sampling.warps import INV_PI
from .photon_map import bucket_of, cell_key

#: Photons count when their surface's normal is within 45 degrees of the query's, ...
LEAST_COSINE = 0.7
#: ... when they lie within this part of the radius of its tangent plane, ...
MOST_HEIGHT = 0.3
#: ... and a radius covers at most this many cells to each side of its own.
MOST_CELLS = 3


@kernel
def largest_radius(cell: float) -> float:
    """Radius that a query may have at most in a grid of this cell."""
    return cell * MOST_CELLS


@kernel
def _may_hold(
    x: int, y: int, z: int, cell: float, p: Vector, ng: Vector, radius: float, high: float
) -> bool:
    """Whether the cell's box meets the query's slab: cheaper than looking the cell up."""
    half = 0.5 * cell
    dx = (x + 0.5) * cell - p[0]
    dy = (y + 0.5) * cell - p[1]
    dz = (z + 0.5) * cell - p[2]
    reach = half * (abs(ng[0]) + abs(ng[1]) + abs(ng[2])) + high
    if abs(dx * ng[0] + dy * ng[1] + dz * ng[2]) > reach:
        return False
    # The disc's corners stick out of the ball by at most the slab's height.
    ball = radius * radius + high * high
    gap_x = max(0.0, abs(dx) - half)
    gap_y = max(0.0, abs(dy) - half)
    gap_z = max(0.0, abs(dz) - half)
    return gap_x * gap_x + gap_y * gap_y + gap_z * gap_z <= ball


@kernel
def gather_radiance(
    photon_map: Row,
    p: Vector,
    ng: Vector,
    ns: Vector,
    wo: Vector,
    radius: float,
    material: Row,
    lobes: Table,
) -> tuple[Vector, int]:
    """Radiance reflected to ``wo`` at ``p`` by the photons within ``radius``: (Lo, count)."""
    radius = min(radius, largest_radius(photon_map.cell))
    flat = is_lambertian(material, lobes)
    r = g = b = 0.0
    found = 0
    cell = photon_map.cell
    buckets = len(photon_map.start) - 1
    r2 = radius * radius
    high = MOST_HEIGHT * radius
    x0 = int(math.floor((p[0] - radius) / cell))
    x1 = int(math.floor((p[0] + radius) / cell))
    y0 = int(math.floor((p[1] - radius) / cell))
    y1 = int(math.floor((p[1] + radius) / cell))
    z0 = int(math.floor((p[2] - radius) / cell))
    z1 = int(math.floor((p[2] + radius) / cell))
    for z in range(z0, z1 + 1):
        for y in range(y0, y1 + 1):
            for x in range(x0, x1 + 1):
                if not _may_hold(x, y, z, cell, p, ng, radius, high):
                    continue
                key = cell_key(x, y, z)
                bucket = bucket_of(key, buckets)
                for k in range(photon_map.start[bucket], photon_map.start[bucket + 1]):
                    photon = photon_map.photons[k]
                    dx = photon.position[0] - p[0]
                    dy = photon.position[1] - p[1]
                    dz = photon.position[2] - p[2]
                    height = dx * ng[0] + dy * ng[1] + dz * ng[2]
                    d2 = dx * dx + dy * dy + dz * dz - height * height
                    if d2 >= r2 or abs(height) > high or photon_map.keys[k] != key:
                        continue
                    normal = photon.normal
                    if normal[0] * ng[0] + normal[1] * ng[1] + normal[2] * ng[2] < LEAST_COSINE:
                        continue
                    found += 1
                    weight = 1.0 - d2 / r2
                    flux = photon.flux
                    if flat:
                        r += weight * flux[0]
                        g += weight * flux[1]
                        b += weight * flux[2]
                    else:
                        f = eval_nonspecular(material, lobes, ns, wo, vector(photon.direction))
                        r += weight * f[0] * flux[0]
                        g += weight * f[1] * flux[1]
                        b += weight * f[2] * flux[2]
    scale = 2.0 / (math.pi * r2)
    if flat:
        a = albedo_nonspecular(material, lobes)
        scale *= INV_PI
        return (r * scale * a[0], g * scale * a[1], b * scale * a[2]), found
    return (r * scale, g * scale, b * scale), found
