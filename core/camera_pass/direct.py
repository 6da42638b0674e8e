"""Direct light: lights are asked at each vertex, weighed against the gather rays."""

from __future__ import annotations

from ..bsdf.dispatch import WIDE, eval_part, part_bit, pdf_part
from ..geometry.interaction import OFFSET, leave
from ..geometry.media import current_medium, medium_around, transmittance
from ..geometry.vector import Vector, along, dot, store, subtract, vector
from ..jit import Row, Table, kernel
from ..lights.dispatch import FAR, casts_shadow, sample_li, visibility_of
from ..lights.selection import select_light
from ..sampling.rng import camera_2d
from .guide import guided_ratio, guided_share, zone_of
from .records import LIGHT, LIGHT_POINT
from .seen import power_heuristic


@kernel
def _transmittance(materials: Table, vertex: Row, behind: bool, distance: float) -> Vector:
    """What the medium on the light's side of the vertex leaves over that distance."""
    medium = current_medium(materials, vertex)
    if behind and materials[vertex.row].ior > 0.0:
        medium = vertex.row
        if not vertex.entering:
            medium = medium_around(materials, vertex, vertex.row, False)
    return transmittance(materials, medium, distance)


@kernel
def samples_at(vertex: Row, lights_each: int) -> int:
    """How many points of lights are asked for at a vertex.

    Where a path goes on, one, as it goes on with one ray; a branch of a path its portion.
    """
    if vertex.part != WIDE:
        return 1
    return max(1, int(lights_each * vertex.portion + 0.5))


@kernel
def _send(
    vertex: Row, wi: Vector, distance: float, k: int, origins: Table, directions: Table
) -> float:
    """Write shadow ray ``k``; returns its length in multiples of the direction."""
    p = vector(vertex.p)
    o = leave(p, vector(vertex.ng), wi, vertex.offset)
    store(origins[k], o)
    if not distance < FAR:
        store(directions[k], wi)
        return FAR
    # From the pushed origin to a place just before the light's surface.
    q = along(p, wi, distance)
    store(directions[k], subtract(q, o))
    # Embree's error grows with the ray's length and with the coordinates at both ends;
    # lamps are often snapped into the plane of a ceiling.
    reach = max(abs(q[0]), abs(q[1]), abs(q[2]))
    gap = 2.0 * max(vertex.offset, OFFSET * reach, 2.0 * OFFSET * distance)
    return max(0.0, 1.0 - gap / distance)


@kernel
def _share(
    vertex: Row, lobes: Table, guide: Row, wi: Vector, density: float, rays_each: int
) -> float:
    """Weight of light samples of the ``density`` beside the chain's ray, or all gather rays.

    Of several samples of one technique the densities add up (Veach 1997, 9.2.2).
    """
    ns = vector(vertex.ns)
    pdf_bsdf = pdf_part(vertex, lobes, ns, vector(vertex.wo), wi, vertex.part)
    if vertex.part == WIDE:
        zone = zone_of(guide, vector(vertex.p), ns)
        share = guided_share(zone, vertex, lobes)
        pdf_bsdf *= guided_ratio(guide, zone, share, ns, wi, pdf_bsdf)
        pdf_bsdf *= rays_each * vertex.portion
    return power_heuristic(density, pdf_bsdf)


@kernel
def _same_ray(entries: Table, first: int, end: int, entry: int) -> int:
    """Which of the rays ``first`` to ``end`` goes to ``entry``, or ``end``."""
    for row in range(first, end):
        if entries[row] == entry:
            return row
    return end


@kernel
def sample_direct(
    rays_each: int,
    lights_each: int,
    guide: Row,
    mesh: Row,
    materials: Table,
    lobes: Table,
    shading: Row,
    lights: Row,
    vertices: Table,
    count: int,
    origins: Table,
    directions: Table,
    lengths: Table,
    slots: Table,
    radiance: Table,
    asking: Table,
    entries: Table,
) -> int:
    """Shadow rays of ``count`` vertices and what each one brings if it is free.

    Next-event estimation with multiple importance sampling. Writes compact rows: rays
    (n, 3) f4 with ``lengths`` in multiples of the direction, ``slots``, ``radiance``
    (n, 3), ``asking`` the vertices and ``entries`` the lights. Returns their number, at most
    ``lights_each`` a vertex.
    ``rays_each``: gather rays of a whole path's vertex, the other technique; ``guide`` draws
    them.
    """
    out = 0
    for k in range(count):
        vertex = vertices[k]
        p = vector(vertex.p)
        ns = vector(vertex.ns)
        asked = samples_at(vertex, lights_each)
        first = out
        for j in range(asked):
            u_light, u_face = camera_2d(vertex.number, vertex.pixel_key, LIGHT, j, lights_each)
            entry, prob = select_light(lights, p, u_light)
            if entry < 0 or prob <= 0.0:
                continue
            u, v = camera_2d(vertex.number, vertex.pixel_key, LIGHT_POINT, j, lights_each)
            wi, distance, light, pdf_w, delta = sample_li(
                lights, mesh, materials, shading, entry, p, ns, u_face, u, v
            )
            behind = dot(wi, vector(vertex.ng)) < 0.0
            if not pdf_w > 0.0 or behind != (dot(wi, ns) < 0.0):
                continue
            visible = visibility_of(lights, entry)
            if visible & part_bit(vertex, lobes, vertex.part, behind) == 0:
                continue
            f = eval_part(vertex, lobes, ns, vector(vertex.wo), wi, vertex.part)
            if not max(f) > 0.0:
                continue
            density = asked * pdf_w * prob
            weight = abs(dot(wi, ns)) / density
            shadow = casts_shadow(lights, entry)
            # Light that nothing blocks is found here alone.
            if not delta and shadow:
                weight *= _share(vertex, lobes, guide, wi, density, rays_each)
            left = _transmittance(materials, vertex, behind, distance)
            brings = vector(vertex.beta)
            brings = (
                brings[0] * f[0] * light[0] * left[0] * weight,
                brings[1] * f[1] * light[1] * left[1] * weight,
                brings[2] * f[2] * light[2] * left[2] * weight,
            )
            row = _same_ray(entries, first, out, entry) if delta else out
            if row < out:
                for c in range(3):
                    radiance[row, c] += brings[c]
                continue
            lengths[out] = _send(vertex, wi, distance, out, origins, directions)
            if not shadow:
                lengths[out] = 0.0
            slots[out] = vertex.slot
            asking[out] = k
            entries[out] = entry
            store(radiance[out], brings)
            out += 1
    return out


@kernel
def add_direct(free: Table, slots: Table, radiance: Table, count: int, samples: Table) -> None:
    """Add what the shadow rays bring to their pixels; ``free`` (n, 3) is what gets through."""
    for k in range(count):
        target = samples[slots[k]].direct
        for c in range(3):
            target[c] += radiance[k, c] * free[k, c]
