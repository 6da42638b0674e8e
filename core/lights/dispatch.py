"""The only code that knows which kind a light is: being lit by one, and seeing one.

Entries: lamps 0..N-1, emissive faces N, world N+1 (``light_set``). Radiance and
intensities are per channel. Emission of photons is in ``emission``.
"""

from __future__ import annotations

import math
from typing import Any

from ..geometry.vector import Vector, dot, scale, subtract, to_world, vector
from ..jit import Row, Table, kernel
from ..sampling.warps import sample_cone, sample_triangle
from ..scene.tables import LightKind
from . import area, sun
from .mesh import face_normal, glow, pdf_area, sample_emitter
from .point import hit_soft, hit_sphere, sample_soft_li, sample_sphere_li
from .spot import cone_share
from .world import sample_world, world_radiance

POINT = int(LightKind.POINT)
SPOT = int(LightKind.SPOT)
SUN = int(LightKind.SUN)
RECTANGLE = int(LightKind.RECTANGLE)
DISK = int(LightKind.DISK)

hit_area = area.hit_area
sample_area_point = area.sample_point
sample_seen_point = area.sample_seen_point
spread_share = area.spread_share
sample_shine = area.sample_shine
area_of = area.area
sun_in_disc = sun.in_disc
sun_versine = sun.versine
sun_radiance = sun.radiance_scale

#: Distance of what is infinitely far away.
FAR = 1e30


@kernel
def spot_scale(lamp: Row, w: Vector) -> float:
    """Fraction of the axial intensity that a point or spot sends along ``w``."""
    if lamp.kind != SPOT:
        return 1.0
    return cone_share(lamp, w)


@kernel
def is_delta(lamp: Row) -> bool:
    """Whether no ray can hit the lamp by chance."""
    if lamp.kind == SUN:
        return lamp.angle <= 0.0
    return (lamp.kind == POINT or lamp.kind == SPOT) and lamp.radius <= 0.0


@kernel
def _sample_point_like(lamp: Row, p: Vector, u: float, v: float) -> Any:
    """``sample_lamp`` of a point or spot."""
    e = vector(lamp.emission)
    centre = vector(lamp.position)
    if lamp.radius <= 0.0:
        to_light = subtract(centre, p)
        d2 = dot(to_light, to_light)
        if d2 <= 0.0:
            return to_light, 0.0, e, 0.0
        d = math.sqrt(d2)
        wi = scale(to_light, 1.0 / d)
        return wi, d, scale(e, spot_scale(lamp, scale(wi, -1.0)) / d2), 1.0
    if lamp.soft != 0:
        wi, d, pdf_w = sample_soft_li(centre, lamp.radius, p, u, v)
    else:
        wi, d, pdf_w = sample_sphere_li(centre, lamp.radius, p, u, v)
    return wi, d, scale(e, _surface_share(lamp, p, wi)), pdf_w


@kernel
def _surface_share(lamp: Row, o: Vector, d: Vector) -> float:
    """Radiance per axial intensity of a point's or spot's shape, seen from ``o`` along ``d``.

    From inside of its sphere a spot shines everywhere, in Cycles 5.0 and 5.2.
    """
    share = 1.0 / (math.pi * lamp.radius * lamp.radius)
    to_centre = subtract(vector(lamp.position), o)
    if lamp.soft == 0 and dot(to_centre, to_centre) <= lamp.radius * lamp.radius:
        return share
    return share * spot_scale(lamp, scale(d, -1.0))


@kernel
def sample_lamp(lamp: Row, p: Vector, u: float, v: float) -> Any:
    """Light from a lamp at ``p``: (wi, distance, radiance (3,), pdf_w).

    For delta lamps ``pdf_w`` is 1 and the radiance is the irradiance on a facing plane.
    ``pdf_w`` 0 means that no light comes.
    """
    e = vector(lamp.emission)
    if lamp.kind == SUN:
        to_sun = vector(lamp.axis_z)
        if lamp.angle <= 0.0:
            return to_sun, FAR, e, 1.0
        versine = sun_versine(lamp.angle)
        wi = cone_direction(to_sun, versine, u, v)
        return (
            wi,
            FAR,
            scale(e, sun_radiance(lamp.angle)),
            1.0 / (2.0 * math.pi * versine),
        )
    if lamp.kind == RECTANGLE or lamp.kind == DISK:
        q, pdf_a = sample_seen_point(lamp, lamp.kind == DISK, p, u, v)
        to_light = subtract(q, p)
        d2 = dot(to_light, to_light)
        if d2 <= 0.0 or pdf_a <= 0.0:
            return to_light, 0.0, e, 0.0
        d = math.sqrt(d2)
        wi = scale(to_light, 1.0 / d)
        cos_light = dot(wi, vector(lamp.axis_z))
        if cos_light <= 0.0:
            return wi, d, e, 0.0
        return wi, d, scale(e, spread_share(lamp, cos_light)), pdf_a * d2 / cos_light
    return _sample_point_like(lamp, p, u, v)


@kernel
def cone_direction(axis: Vector, versine: float, u: float, v: float) -> Vector:
    """Direction uniform in the cone about ``axis`` with 1 - cos = ``versine``."""
    return to_world(sample_cone(versine, u, v), axis)


@kernel
def sample_li(
    lights: Row,
    mesh: Row,
    materials: Table,
    shading: Row,
    entry: int,
    p: Vector,
    n: Vector,
    u_face: float,
    u: float,
    v: float,
) -> Any:
    """Light from an entry at ``p``: (wi, distance, radiance (3,), pdf_w, delta)."""
    count = len(lights.lamps)
    if entry < count:
        wi, d, radiance, pdf_w = sample_lamp(lights.lamps[entry], p, u, v)
        return wi, d, radiance, pdf_w, is_delta(lights.lamps[entry])
    if entry == count + 1:
        wi, pdf_w = sample_world(lights.world, n, u, v)
        return wi, FAR, world_radiance(lights.world, wi), pdf_w, False
    face, q = sample_emitter(mesh, lights.emitters, u_face, u, v)
    material = mesh.material[face]
    s, t = sample_triangle(u, v)
    radiance = glow(materials, shading, mesh, face, s, t)
    to_light = subtract(q, p)
    d2 = dot(to_light, to_light)
    if d2 <= 0.0:
        return to_light, 0.0, radiance, 0.0, False
    d = math.sqrt(d2)
    wi = scale(to_light, 1.0 / d)
    cos_light = abs(dot(wi, face_normal(mesh, face)))
    if cos_light <= 0.0:
        return wi, d, radiance, 0.0, False
    return (
        wi,
        d,
        radiance,
        d2 * pdf_area(materials, lights.emitters, material) / cos_light,
        False,
    )


@kernel
def see_lamp(lamp: Row, o: Vector, d: Vector) -> Any:
    """A ray's hit of a lamp's shape: (distance, radiance (3,), pdf_w of ``sample_lamp``).

    Distance -1 when missed; delta lamps are never hit.
    """
    e = vector(lamp.emission)
    if is_delta(lamp):
        return -1.0, e, 0.0
    if lamp.kind == SUN:
        if not sun_in_disc(vector(lamp.axis_z), d, lamp.angle):
            return -1.0, e, 0.0
        pdf_w = 1.0 / (2.0 * math.pi * sun_versine(lamp.angle))
        return FAR, scale(e, sun_radiance(lamp.angle)), pdf_w
    if lamp.kind == RECTANGLE or lamp.kind == DISK:
        t, pdf_w, cos_light = hit_area(lamp, lamp.kind == DISK, o, d)
        return t, scale(e, spread_share(lamp, cos_light)), pdf_w
    if lamp.soft != 0:
        t, pdf_w = hit_soft(vector(lamp.position), lamp.radius, o, d)
    else:
        t, pdf_w = hit_sphere(vector(lamp.position), lamp.radius, o, d)
    return t, scale(e, _surface_share(lamp, o, d)), pdf_w


@kernel
def pdf_emitter_hit(
    lights: Row, mesh: Row, materials: Table, face: int, d: Vector, distance: float
) -> float:
    """``pdf_w`` of ``sample_li`` for having sampled the emissive face that a ray hit."""
    cos_light = abs(dot(d, face_normal(mesh, face)))
    if cos_light <= 0.0:
        return 0.0
    pdf_a = pdf_area(materials, lights.emitters, mesh.material[face])
    return pdf_a * distance * distance / cos_light


@kernel
def casts_shadow(lights: Row, entry: int) -> bool:
    """Whether surfaces block the direct light of an entry."""
    return entry >= len(lights.lamps) or lights.lamps[entry].shadow != 0


@kernel
def visibility_of(lights: Row, entry: int) -> int:
    """Visibility bits of an entry (``tables.Visibility``); faces: all."""
    if entry < len(lights.lamps):
        return lights.lamps[entry].visibility
    if entry == len(lights.lamps) + 1:
        return lights.world.visibility
    return 15
