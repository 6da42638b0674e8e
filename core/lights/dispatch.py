"""The only code that knows which kind a light is: being lit by one, and seeing one.

Entries: lamps 0..N-1, emissive faces N, world N+1 (``light_set``). Radiance and
intensities are per channel. Emission of photons is in ``emission``.
"""

from __future__ import annotations

import math
from typing import Any

from ..geometry.vector import Vector, dot, scale, subtract, to_world, vector
from ..jit import Row, Table, kernel
from ..sampling.warps import sample_cone
from ..scene.tables import LightKind
from . import area, sun
from .mesh import face_normal, pdf_area, sample_emitter
from .point import hit_sphere, sample_sphere_li
from .spot import falloff
from .world import pdf_world, sample_world

POINT = int(LightKind.POINT)
SPOT = int(LightKind.SPOT)
SUN = int(LightKind.SUN)
RECTANGLE = int(LightKind.RECTANGLE)
DISK = int(LightKind.DISK)

hit_area = area.hit_area
sample_area_point = area.sample_point
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
    return falloff(-dot(w, vector(lamp.axis_z)), lamp.cos_outer, lamp.blend)


@kernel
def is_delta(lamp: Row) -> bool:
    """Whether no ray can hit the lamp by chance."""
    if lamp.kind == SUN:
        return lamp.angle <= 0.0
    return (lamp.kind == POINT or lamp.kind == SPOT) and lamp.radius <= 0.0


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
        to_light = subtract(sample_area_point(lamp, lamp.kind == DISK, u, v), p)
        d2 = dot(to_light, to_light)
        if d2 <= 0.0:
            return to_light, 0.0, e, 0.0
        d = math.sqrt(d2)
        wi = scale(to_light, 1.0 / d)
        cos_light = dot(wi, vector(lamp.axis_z))
        if cos_light <= 0.0:
            return wi, d, e, 0.0
        return wi, d, e, d2 / (cos_light * area_of(lamp, lamp.kind == DISK))
    centre = vector(lamp.position)
    if lamp.radius <= 0.0:
        to_light = subtract(centre, p)
        d2 = dot(to_light, to_light)
        if d2 <= 0.0:
            return to_light, 0.0, e, 0.0
        d = math.sqrt(d2)
        wi = scale(to_light, 1.0 / d)
        return wi, d, scale(e, spot_scale(lamp, scale(wi, -1.0)) / d2), 1.0
    wi, d, pdf_w = sample_sphere_li(centre, lamp.radius, p, u, v)
    shine = spot_scale(lamp, scale(wi, -1.0)) / (math.pi * lamp.radius * lamp.radius)
    return wi, d, scale(e, shine), pdf_w


@kernel
def cone_direction(axis: Vector, versine: float, u: float, v: float) -> Vector:
    """Direction uniform in the cone about ``axis`` with 1 - cos = ``versine``."""
    return to_world(sample_cone(versine, u, v), axis)


@kernel
def sample_li(
    lights: Row,
    mesh: Row,
    materials: Table,
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
        wi, pdf_w = sample_world(n, u, v)
        return wi, FAR, vector(lights.world), pdf_w, False
    face, q = sample_emitter(mesh, lights.emitters, u_face, u, v)
    material = mesh.material[face]
    radiance = vector(materials[material].emission)
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
        t, pdf_w = hit_area(lamp, lamp.kind == DISK, o, d)
        return t, e, pdf_w
    t, pdf_w = hit_sphere(vector(lamp.position), lamp.radius, o, d)
    shine = spot_scale(lamp, scale(d, -1.0)) / (math.pi * lamp.radius * lamp.radius)
    return t, scale(e, shine), pdf_w


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


pdf_world_hit = pdf_world
