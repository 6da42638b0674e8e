"""Lamps in plain scalars: light sampling for a point, and what a ray sees of their shapes.

A lamp is no geometry: it blocks nothing, and a ray sees all the shapes that it crosses.
"""

from __future__ import annotations

import math

from ..jit import kernel
from ..scene.tables import LightKind
from .flat import Flat
from .vector import (
    TWO_PI,
    Stream,
    Vec,
    along,
    dot,
    sample_cone,
    scaled,
    uniform,
    unit,
    vec,
)

_POINT, _SPOT, _SUN = int(LightKind.POINT), int(LightKind.SPOT), int(LightKind.SUN)
_DISK = int(LightKind.DISK)

#: What light sampling finds: direction to the light, distance, radiance / density.
LampSample = tuple[Vec, float, Vec]
_NOTHING = ((0.0, 0.0, 1.0), 0.0, (0.0, 0.0, 0.0))


@kernel
def spot_share(s: Flat, lamp: int, leaving: Vec) -> float:
    """Share of the axial intensity in the direction ``leaving`` the lamp; 1 for a point."""
    if s.lamps[lamp].kind != _SPOT:
        return 1.0
    cos_outer, blend = s.lamps[lamp].cos_outer, s.lamps[lamp].blend
    inside = -dot(leaving, vec(s.lamps[lamp].axis_z)) - cos_outer
    if inside <= 0.0:
        return 0.0
    width = (1.0 - cos_outer) * blend
    if inside >= width:
        return 1.0
    t = inside / width
    return t * t * (3.0 - 2.0 * t)


@kernel
def sample_lamp(s: Flat, lamp: int, p: Vec, stream: Stream) -> LampSample:
    """A direction from ``p`` towards the lamp with its radiance over its density."""
    kind = s.lamps[lamp].kind
    if kind == _POINT or kind == _SPOT:
        return _sample_sphere(s, lamp, p, stream)
    if kind == _SUN:
        angle = s.lamps[lamp].angle
        to_sun = vec(s.lamps[lamp].axis_z)
        if angle <= 0.0:
            return to_sun, math.inf, vec(s.lamps[lamp].emission)
        height = 2.0 * math.sin(0.25 * angle) ** 2
        wi = sample_cone(to_sun, height, uniform(stream), uniform(stream))
        density = 1.0 / (TWO_PI * height)
        return wi, math.inf, scaled(_sun_radiance(s, lamp), 1.0 / density)
    return _sample_plate(s, lamp, p, stream)


@kernel
def _sun_radiance(s: Flat, lamp: int) -> Vec:
    sine = math.sin(0.5 * s.lamps[lamp].angle)
    return scaled(vec(s.lamps[lamp].emission), 1.0 / (math.pi * sine * sine))


@kernel
def _sample_sphere(s: Flat, lamp: int, p: Vec, stream: Stream) -> LampSample:
    """A point, or a sphere by the solid angle of its visible cap; none from inside."""
    to_centre = along(vec(s.lamps[lamp].position), p, -1.0)
    square = dot(to_centre, to_centre)
    radius = s.lamps[lamp].radius
    if square <= radius * radius or square == 0.0:
        return _NOTHING
    distance = math.sqrt(square)
    axis = scaled(to_centre, 1.0 / distance)
    intensity = vec(s.lamps[lamp].emission)
    if radius <= 0.0:
        share = spot_share(s, lamp, scaled(axis, -1.0))
        return axis, distance, scaled(intensity, share / square)
    sine_2 = radius * radius / square
    height = sine_2 / (1.0 + math.sqrt(1.0 - sine_2))
    wi = sample_cone(axis, height, uniform(stream), uniform(stream))
    near = _sphere_entry(p, wi, vec(s.lamps[lamp].position), radius)
    if near < 0.0:
        # The edge of the cap, lost to rounding.
        near = math.sqrt(square - radius * radius)
    share = spot_share(s, lamp, scaled(wi, -1.0))
    solid_angle = TWO_PI * height
    return wi, near, scaled(intensity, share * solid_angle / (math.pi * radius * radius))


@kernel
def _sample_plate(s: Flat, lamp: int, p: Vec, stream: Stream) -> LampSample:
    """A uniform point of the one-sided rectangle or ellipse."""
    size_x, size_y = s.lamps[lamp].size_x, s.lamps[lamp].size_y
    a, b = uniform(stream) - 0.5, uniform(stream) - 0.5
    area = size_x * size_y
    if s.lamps[lamp].kind == _DISK:
        radius, phi = 0.5 * math.sqrt(a + 0.5), TWO_PI * b
        a, b = radius * math.cos(phi), radius * math.sin(phi)
        area *= 0.25 * math.pi
    point = along(vec(s.lamps[lamp].position), vec(s.lamps[lamp].axis_x), a * size_x)
    point = along(point, vec(s.lamps[lamp].axis_y), b * size_y)
    to_light = along(point, p, -1.0)
    square = dot(to_light, to_light)
    if square == 0.0:
        return _NOTHING
    wi = unit(to_light)
    cosine = dot(wi, vec(s.lamps[lamp].axis_z))
    if cosine <= 0.0:
        return _NOTHING
    return wi, math.sqrt(square), scaled(vec(s.lamps[lamp].emission), cosine * area / square)


@kernel
def _sphere_entry(o: Vec, d: Vec, centre: Vec, radius: float) -> float:
    """Distance at which the ray enters the sphere from outside, or -1."""
    to_centre = along(centre, o, -1.0)
    middle = dot(to_centre, d)
    beside = along(to_centre, d, -middle)
    half_2 = radius * radius - dot(beside, beside)
    if half_2 < 0.0 or dot(to_centre, to_centre) <= radius * radius:
        return -1.0
    return middle - math.sqrt(half_2)


@kernel
def seen_lamps(s: Flat, o: Vec, d: Vec, far: float, kind_of_ray: int) -> Vec:
    """Sum of the radiances of the shapes crossed before ``far`` that such a ray sees."""
    r, g, b = 0.0, 0.0, 0.0
    for lamp in range(len(s.lamps)):
        if s.lamps[lamp].visibility & kind_of_ray:
            rgb = _seen_lamp(s, lamp, o, d, far)
            r, g, b = r + rgb[0], g + rgb[1], b + rgb[2]
    return r, g, b


@kernel
def _seen_lamp(s: Flat, lamp: int, o: Vec, d: Vec, far: float) -> Vec:
    dark = (0.0, 0.0, 0.0)
    kind = s.lamps[lamp].kind
    if kind == _SUN:
        angle = s.lamps[lamp].angle
        if angle <= 0.0 or far < math.inf:
            return dark
        # The chord between the directions stays exact for a tiny sun.
        apart = along(d, vec(s.lamps[lamp].axis_z), -1.0)
        if math.sqrt(dot(apart, apart)) > 2.0 * math.sin(0.25 * angle):
            return dark
        return _sun_radiance(s, lamp)
    if kind == _POINT or kind == _SPOT:
        radius = s.lamps[lamp].radius
        if radius <= 0.0:
            return dark
        t = _sphere_entry(o, d, vec(s.lamps[lamp].position), radius)
        if t <= 0.0 or t >= far:
            return dark
        share = spot_share(s, lamp, scaled(d, -1.0))
        return scaled(vec(s.lamps[lamp].emission), share / (math.pi * radius * radius))
    cosine = dot(d, vec(s.lamps[lamp].axis_z))
    if cosine <= 0.0:
        return dark
    from_centre = along(o, vec(s.lamps[lamp].position), -1.0)
    t = -dot(from_centre, vec(s.lamps[lamp].axis_z)) / cosine
    if t <= 0.0 or t >= far:
        return dark
    point = along(from_centre, d, t)
    a = 2.0 * dot(point, vec(s.lamps[lamp].axis_x)) / s.lamps[lamp].size_x
    b = 2.0 * dot(point, vec(s.lamps[lamp].axis_y)) / s.lamps[lamp].size_y
    outside = a * a + b * b > 1.0 if kind == _DISK else max(abs(a), abs(b)) > 1.0
    return dark if outside else vec(s.lamps[lamp].emission)
