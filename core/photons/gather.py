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
from .cells import row_of
from .rows import MOST_HEIGHT, largest_radius, photons_near, rows_near
from .sight import SECTORS, is_hidden

#: Photons count when their surface's normal is within 45 degrees of the query's.
LEAST_COSINE = 0.7


@kernel
def disc_weight(
    places: Table, k: int, p: Vector, ng: Vector, radius: float, inverse: float
) -> float:
    """1 - d^2 / r^2 of place ``k`` on the tangent plane; 0 outside the disc."""
    dx = places[k, 0] - p[0]
    dy = places[k, 1] - p[1]
    dz = places[k, 2] - p[2]
    height = dx * ng[0] + dy * ng[1] + dz * ng[2]
    d2 = dx * dx + dy * dy + dz * dz - height * height
    if abs(height) > MOST_HEIGHT * radius:
        return 0.0
    return 1.0 - d2 * inverse


@kernel
def facing(photon: Row, ng: Vector, both: bool) -> float:
    """Cosine of the normals; 0 on another surface than the disc's.

    A curved surface has more area, and so more photons, than its shadow on the tangent plane
    by the inverse of that cosine. ``both``: photons that came from the other side count too.
    """
    normal = photon.normal
    cosine = normal[0] * ng[0] + normal[1] * ng[1] + normal[2] * ng[2]
    if both:
        cosine = abs(cosine)
    return cosine if cosine >= LEAST_COSINE else 0.0


@kernel
def to_photon(photon: Row, p: Vector) -> Vector:
    """The way from ``p`` to a photon."""
    x = photon.position
    return x[0] - p[0], x[1] - p[1], x[2] - p[2]


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
    radius = min(radius, largest_radius(photon_map.cell))
    parted = sight[SECTORS] != 0.0
    inverse = 1.0 / (radius * radius)
    rows = rows_near(photon_map.cell, p, ng, radius)
    for j in range(rows[3]):
        first, last, row = photons_near(photon_map, rows, j, p, ng, radius)
        for k in range(first, last):
            weight = disc_weight(photon_map.places, k, p, ng, radius, inverse)
            if weight <= 0.0 or row_of(photon_map.keys[k]) != row:
                continue
            photon = photon_map.photons[k]
            cosine = facing(photon, ng, both)
            if cosine == 0.0 or (parted and is_hidden(sight, to_photon(photon, p), ng, radius)):
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
    radius = min(radius, largest_radius(photon_map.cell))
    parted = sight[SECTORS] != 0.0
    inverse = 1.0 / (radius * radius)
    rows = rows_near(photon_map.cell, p, ng, radius)
    for j in range(rows[3]):
        first, last, row = photons_near(photon_map, rows, j, p, ng, radius)
        for k in range(first, last):
            weight = disc_weight(photon_map.places, k, p, ng, radius, inverse)
            if weight <= 0.0 or row_of(photon_map.keys[k]) != row:
                continue
            photon = photon_map.photons[k]
            cosine = facing(photon, ng, False)
            if cosine == 0.0 or (parted and is_hidden(sight, to_photon(photon, p), ng, radius)):
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
