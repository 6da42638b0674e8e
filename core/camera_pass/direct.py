"""Direct light: one light is asked at each vertex, weighed against the gather ray."""

from __future__ import annotations

from ..bsdf.dispatch import WIDE, eval_part, part_bit, pdf_part
from ..geometry.interaction import OFFSET, leave
from ..geometry.media import current_medium, medium_around, transmittance
from ..geometry.vector import Vector, along, dot, store, subtract, vector
from ..jit import Row, Table, kernel
from ..lights.dispatch import FAR, casts_shadow, sample_li, visibility_of
from ..lights.selection import select_light
from ..sampling.rng import camera_2d
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
def sample_direct(
    rays_each: int,
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
    (n, 3), ``asking`` the vertices and ``entries`` the lights. Returns their number.
    ``rays_each``: gather rays of a whole path's vertex, the other technique.
    """
    out = 0
    for k in range(count):
        vertex = vertices[k]
        p = vector(vertex.p)
        ns = vector(vertex.ns)
        ng = vector(vertex.ng)
        u_light, u_face = camera_2d(vertex.number, vertex.pixel_key, LIGHT)
        entry, prob = select_light(lights, p, u_light)
        if entry < 0 or prob <= 0.0:
            continue
        u, v = camera_2d(vertex.number, vertex.pixel_key, LIGHT_POINT)
        wi, distance, light, pdf_w, delta = sample_li(
            lights, mesh, materials, shading, entry, p, ns, u_face, u, v
        )
        behind = dot(wi, ng) < 0.0
        if not pdf_w > 0.0 or behind != (dot(wi, ns) < 0.0):
            continue
        if visibility_of(lights, entry) & part_bit(vertex, lobes, vertex.part, behind) == 0:
            continue
        f = eval_part(vertex, lobes, ns, vector(vertex.wo), wi, vertex.part)
        if not max(f) > 0.0:
            continue
        weight = abs(dot(wi, ns)) / (pdf_w * prob)
        shadow = casts_shadow(lights, entry)
        # Light that nothing blocks is found here alone.
        if not delta and shadow:
            pdf_bsdf = pdf_part(vertex, lobes, ns, vector(vertex.wo), wi, vertex.part)
            if vertex.part == WIDE:
                pdf_bsdf *= rays_each * vertex.portion
            weight *= power_heuristic(pdf_w * prob, pdf_bsdf)
        o = leave(p, ng, wi, vertex.offset)
        d = wi
        length = FAR
        if distance < FAR:
            # From the pushed origin to a place just before the light's surface.
            q = along(p, wi, distance)
            d = subtract(q, o)
            # Embree's error grows with the ray's length and with the coordinates at both
            # ends; lamps are often snapped into the plane of a ceiling.
            reach = max(abs(q[0]), abs(q[1]), abs(q[2]))
            gap = 2.0 * max(vertex.offset, OFFSET * reach, 2.0 * OFFSET * distance)
            length = max(0.0, 1.0 - gap / distance)
        if not shadow:
            length = 0.0
        store(origins[out], o)
        store(directions[out], d)
        lengths[out] = length
        slots[out] = vertex.slot
        asking[out] = k
        entries[out] = entry
        left = _transmittance(materials, vertex, behind, distance)
        for c in range(3):
            radiance[out, c] = vertex.beta[c] * f[c] * light[c] * left[c] * weight
        out += 1
    return out


@kernel
def add_direct(free: Table, slots: Table, radiance: Table, count: int, samples: Table) -> None:
    """Add what the shadow rays bring to their pixels; ``free`` (n, 3) is what gets through."""
    for k in range(count):
        target = samples[slots[k]].direct
        for c in range(3):
            target[c] += radiance[k, c] * free[k, c]
