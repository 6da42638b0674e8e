"""Density estimates: reflected radiance from the photons around a point.

Jensen 1996 with the 2-D Epanechnikov kernel k = 2 / (pi r^2) (1 - d^2 / r^2) on the
tangent plane (Silverman 1986, section 4.2): Lo = sum f(wi, wo) flux k. There is no
brightness to set by hand. The same photons are summed for the inner half of the disc too,
which tells the bias (``film``).
"""

from __future__ import annotations

import math

from ..bsdf.dispatch import (
    albedo_nonspecular,
    eval_part,
    is_lambertian,
    is_twosided,
)
from ..geometry.vector import Vector, scale, times, vector
from ..jit import Row, Table, kernel
from ..sampling.warps import INV_PI
from .cells import bucket_of, cell_key
from .sight import SECTORS, is_hidden

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
def cell_range(
    cell: float, p: Vector, radius: float
) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
    """First and last cell that a ball about ``p`` touches."""
    return (
        int(math.floor((p[0] - radius) / cell)),
        int(math.floor((p[1] - radius) / cell)),
        int(math.floor((p[2] - radius) / cell)),
    ), (
        int(math.floor((p[0] + radius) / cell)),
        int(math.floor((p[1] + radius) / cell)),
        int(math.floor((p[2] + radius) / cell)),
    )


@kernel
def bucket_slice(
    photon_map: Row, x: int, y: int, z: int, p: Vector, ng: Vector, radius: float
) -> tuple[int, int, int]:
    """Photons that may lie in a cell: (first, last + 1, key); those of other keys are not."""
    if not _may_hold(x, y, z, photon_map.cell, p, ng, radius, MOST_HEIGHT * radius):
        return 0, 0, 0
    key = cell_key(x, y, z)
    bucket = bucket_of(key, len(photon_map.start) - 1)
    return photon_map.start[bucket], photon_map.start[bucket + 1], key


@kernel
def photon_weight(
    photon: Row, p: Vector, ng: Vector, radius: float, both: bool
) -> tuple[float, float]:
    """(1 - d^2 / r^2 on the tangent plane, cosine of the normals); 0 outside the disc.

    The weight is 0 on another surface too. A curved surface has more area, and so more
    photons, than its shadow on the tangent plane by the inverse of that cosine. ``both``:
    photons that came from the other side of the surface count too.
    """
    dx = photon.position[0] - p[0]
    dy = photon.position[1] - p[1]
    dz = photon.position[2] - p[2]
    height = dx * ng[0] + dy * ng[1] + dz * ng[2]
    d2 = dx * dx + dy * dy + dz * dz - height * height
    r2 = radius * radius
    if d2 >= r2 or abs(height) > MOST_HEIGHT * radius:
        return 0.0, 0.0
    normal = photon.normal
    cosine = normal[0] * ng[0] + normal[1] * ng[1] + normal[2] * ng[2]
    if both:
        cosine = abs(cosine)
    if cosine < LEAST_COSINE:
        return 0.0, 0.0
    return 1.0 - d2 / r2, cosine


@kernel
def _to(photon: Row, p: Vector) -> Vector:
    """The way from ``p`` to a photon."""
    x = photon.position
    return x[0] - p[0], x[1] - p[1], x[2] - p[2]


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
    surface: Row,
    lobes: Table,
    sight: Table,
) -> tuple[Vector, Vector, int]:
    """Radiance sent to ``wo`` from ``p`` by the photons within ``radius``.

    Returns (Lo, Lo by those in half the area, count). ``surface`` has the lobes, of which the
    ``part`` of each photon answers to it. ``sight`` (SIGHT,): how
    far the disc sees to each side, if its last entry is not 0.
    """
    if is_lambertian(surface, lobes):
        e, inner, found = gather_irradiance(photon_map, p, ng, radius, sight)
        a = scale(albedo_nonspecular(surface, lobes), INV_PI)
        return times(a, e), times(a, inner), found
    both = is_twosided(surface, lobes)
    r = g = b = 0.0
    r_in = g_in = b_in = 0.0
    found = 0
    parted = sight[SECTORS] != 0.0
    radius = min(radius, largest_radius(photon_map.cell))
    low, high = cell_range(photon_map.cell, p, radius)
    for z in range(low[2], high[2] + 1):
        for y in range(low[1], high[1] + 1):
            for x in range(low[0], high[0] + 1):
                first, last, key = bucket_slice(photon_map, x, y, z, p, ng, radius)
                for k in range(first, last):
                    photon = photon_map.photons[k]
                    weight, cosine = photon_weight(photon, p, ng, radius, both)
                    if weight <= 0.0 or photon_map.keys[k] != key:
                        continue
                    if parted and is_hidden(sight, _to(photon, p), ng, radius):
                        continue
                    found += 1
                    wi = vector(photon.direction)
                    f = eval_part(surface, lobes, ns, wo, wi, photon.part)
                    # 1 - d^2 / (r^2 / 2), the same kernel on half the area.
                    inner = cosine * max(0.0, 2.0 * weight - 1.0)
                    weight *= cosine
                    r += weight * f[0] * photon.flux[0]
                    g += weight * f[1] * photon.flux[1]
                    b += weight * f[2] * photon.flux[2]
                    r_in += inner * f[0] * photon.flux[0]
                    g_in += inner * f[1] * photon.flux[1]
                    b_in += inner * f[2] * photon.flux[2]
    norm = 2.0 / (math.pi * radius * radius)
    return scale((r, g, b), norm), scale((r_in, g_in, b_in), 2.0 * norm), found


@kernel
def gather_irradiance(
    photon_map: Row, p: Vector, ng: Vector, radius: float, sight: Table
) -> tuple[Vector, Vector, int]:
    """Irradiance at ``p`` on the side of ``ng`` [W/m^2].

    Returns (E, E by the photons in half the area, photons counted). ``sight``: see
    ``gather_radiance``.
    """
    r = g = b = 0.0
    r_in = g_in = b_in = 0.0
    found = 0
    parted = sight[SECTORS] != 0.0
    radius = min(radius, largest_radius(photon_map.cell))
    low, high = cell_range(photon_map.cell, p, radius)
    for z in range(low[2], high[2] + 1):
        for y in range(low[1], high[1] + 1):
            for x in range(low[0], high[0] + 1):
                first, last, key = bucket_slice(photon_map, x, y, z, p, ng, radius)
                for k in range(first, last):
                    photon = photon_map.photons[k]
                    weight, cosine = photon_weight(photon, p, ng, radius, False)
                    if weight <= 0.0 or photon_map.keys[k] != key:
                        continue
                    if parted and is_hidden(sight, _to(photon, p), ng, radius):
                        continue
                    found += 1
                    inner = cosine * max(0.0, 2.0 * weight - 1.0)
                    weight *= cosine
                    r += weight * photon.flux[0]
                    g += weight * photon.flux[1]
                    b += weight * photon.flux[2]
                    r_in += inner * photon.flux[0]
                    g_in += inner * photon.flux[1]
                    b_in += inner * photon.flux[2]
    norm = 2.0 / (math.pi * radius * radius)
    return scale((r, g, b), norm), scale((r_in, g_in, b_in), 2.0 * norm), found
