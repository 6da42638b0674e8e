"""How lights send photons out, for every kind of light.

A *local* entry has an anchor (a point of its surface, or a lamp's centre) and sends
directions from there; a *distant* one (sun, world) has a direction and sends parallel
beams through a disc. Both can be aimed (``photons/aim``): the density is divided out.
"""

from __future__ import annotations

import math
from typing import Any

from ..geometry.vector import Vector, dot, scale, to_world, vector
from ..jit import Row, Table, kernel
from ..sampling.warps import (
    sample_cosine_hemisphere,
    sample_disk,
    sample_sphere,
    sample_triangle,
)
from .dispatch import (
    DISK,
    RECTANGLE,
    SPOT,
    SUN,
    area_of,
    cone_direction,
    sample_area_point,
    sample_shine,
    spot_scale,
    spread_share,
    sun_radiance,
    sun_versine,
)
from .mesh import face_normal, glow, pdf_area, sample_emitter
from .point import beam_origin, soft_origin, soft_reaches
from .spot import sample_in_cone
from .world import sample_beam, world_radiance

_NONE = (0.0, 0.0, 0.0)


@kernel
def sample_anchor(
    lights: Row, mesh: Row, materials: Table, entry: int, u_face: float, u: float, v: float
) -> Any:
    """Where a local entry sends from: (anchor, normal, margin, face).

    ``normal`` is the shining side's, or zero for lamps that shine all around; beams start
    within ``margin`` of the anchor's axis; ``face`` is -1 for lamps.
    """
    if entry == len(lights.lamps):
        face, p = sample_emitter(mesh, lights.emitters, u_face, u, v)
        return p, _NONE, 0.0, face
    lamp = lights.lamps[entry]
    if lamp.kind == RECTANGLE or lamp.kind == DISK:
        p = sample_area_point(lamp, lamp.kind == DISK, u, v)
        return p, scale(vector(lamp.axis_z), -1.0), 0.0, -1
    return vector(lamp.position), _NONE, lamp.radius, -1


@kernel
def sample_natural(
    lights: Row, mesh: Row, entry: int, face: int, u_side: float, u: float, v: float
) -> Any:
    """Direction of an unaimed photon of a local entry, about as it emits: (w, pdf_w)."""
    if entry == len(lights.lamps):
        n = face_normal(mesh, face)
        if u_side < 0.5:
            n = scale(n, -1.0)
        local = sample_cosine_hemisphere(u, v)
        return to_world(local, n), 0.5 * local[2] / math.pi
    lamp = lights.lamps[entry]
    if lamp.kind == RECTANGLE or lamp.kind == DISK:
        return sample_shine(lamp, u, v)
    if lamp.kind == SPOT:
        return sample_in_cone(lamp, u, v)
    return sample_sphere(u, v), 1.0 / (4.0 * math.pi)


@kernel
def emitted(
    lights: Row,
    mesh: Row,
    materials: Table,
    shading: Row,
    entry: int,
    face: int,
    anchor: Vector,
    w: Vector,
    u: float,
    v: float,
) -> Any:
    """Start and power per solid angle of the photon along ``w``: (origin, normal, (3,) W/sr).

    ``u`` and ``v`` are those of ``sample_anchor``. Divide by the ``pdf_w`` of the direction
    for its flux. ``normal`` is that of the
    surface it starts on, zero for lamps (they are no surfaces that rays can hit).
    """
    if entry == len(lights.lamps):
        n = face_normal(mesh, face)
        pdf_a = pdf_area(materials, lights.emitters, mesh.material[face])
        a, b = sample_triangle(u, v)
        e = glow(materials, shading, mesh, face, a, b)
        return anchor, n, scale(e, abs(dot(n, w)) / pdf_a)
    lamp = lights.lamps[entry]
    e = vector(lamp.emission)
    if lamp.kind == RECTANGLE or lamp.kind == DISK:
        cos_light = max(0.0, -dot(w, vector(lamp.axis_z)))
        share = cos_light * spread_share(lamp, cos_light)
        return anchor, _NONE, scale(e, share * area_of(lamp, lamp.kind == DISK))
    x, y = sample_disk(u, v)
    if lamp.soft != 0:
        origin = soft_origin(anchor, lamp.radius, w, x, y)
    else:
        origin = beam_origin(anchor, lamp.radius, w, x, y)
    return origin, _NONE, scale(e, spot_scale(lamp, w))


@kernel
def sample_distant(lights: Row, entry: int, u: float, v: float) -> Any:
    """Direction of a distant entry's beam and its irradiance: (w, (3,) W/m^2)."""
    if entry == len(lights.lamps) + 1:
        wi, pdf_w = sample_beam(lights.world, u, v)
        if pdf_w <= 0.0:
            return wi, _NONE
        return scale(wi, -1.0), scale(world_radiance(lights.world, wi), 1.0 / pdf_w)
    lamp = lights.lamps[entry]
    e = vector(lamp.emission)
    from_sun = scale(vector(lamp.axis_z), -1.0)
    if lamp.angle <= 0.0 or lamp.kind != SUN:
        return from_sun, e
    versine = sun_versine(lamp.angle)
    w = cone_direction(from_sun, versine, u, v)
    return w, scale(e, sun_radiance(lamp.angle) * 2.0 * math.pi * versine)


@kernel
def reaches(lights: Row, entry: int, start: Vector, p: Vector) -> bool:
    """Whether a photon of ``entry`` that starts at ``start`` may light ``p``, its first hit.

    A soft disc turns to whoever looks: beams at its rim are seen from afar only.
    """
    if entry >= len(lights.lamps):
        return True
    lamp = lights.lamps[entry]
    if lamp.soft == 0 or lights.distant[entry] or lamp.radius <= 0.0:
        return True
    return soft_reaches(vector(lamp.position), lamp.radius, start, p)
