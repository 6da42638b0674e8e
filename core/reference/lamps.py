"""Lamps in plain scalars: light sampling for a point, and what a ray sees of their shapes.

A lamp is no geometry: it blocks nothing, and a ray sees all the shapes that it crosses.
"""

from __future__ import annotations

import math

from ..jit import allocating_kernel as kernel
from ..scene.tables import LightKind
from .flat import Flat
from .vector import (
    TWO_PI,
    Stream,
    Vec,
    along,
    cross,
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
    # In the lamp's own space, where its scale is undone, the cone is round.
    a = dot(leaving, vec(s.lamps[lamp].axis_x)) / s.lamps[lamp].size_x
    b = dot(leaving, vec(s.lamps[lamp].axis_y)) / s.lamps[lamp].size_y
    down = -dot(leaving, vec(s.lamps[lamp].axis_z))
    inside = down / math.sqrt(a * a + b * b + down * down) - cos_outer
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
    """A point, or a sphere by the solid angle of its visible cap, all around from inside."""
    to_centre = along(vec(s.lamps[lamp].position), p, -1.0)
    square = dot(to_centre, to_centre)
    radius = s.lamps[lamp].radius
    intensity = vec(s.lamps[lamp].emission)
    if square == 0.0 and radius <= 0.0:
        return _NOTHING
    if s.lamps[lamp].soft and radius > 0.0:
        return _sample_facing_disc(s, lamp, p, to_centre, stream)
    if square <= radius * radius:
        wi = sample_cone((0.0, 0.0, 1.0), 2.0, uniform(stream), uniform(stream))
        way = _sphere_exit(p, wi, vec(s.lamps[lamp].position), radius)
        return wi, way, scaled(intensity, 4.0 / (radius * radius))
    distance = math.sqrt(square)
    axis = scaled(to_centre, 1.0 / distance)
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
def _sample_facing_disc(
    s: Flat, lamp: int, p: Vec, to_centre: Vec, stream: Stream
) -> LampSample:
    """A uniform point of the disc through the lamp's place across the line of sight."""
    radius = s.lamps[lamp].radius
    square = dot(to_centre, to_centre)
    if square == 0.0:
        return _NOTHING
    axis = scaled(to_centre, 1.0 / math.sqrt(square))
    helper = (1.0, 0.0, 0.0) if abs(axis[0]) < 0.5 else (0.0, 1.0, 0.0)
    right = unit(cross(axis, helper))
    up = cross(right, axis)
    r, phi = radius * math.sqrt(uniform(stream)), TWO_PI * uniform(stream)
    to_light = along(to_centre, right, r * math.cos(phi))
    to_light = along(to_light, up, r * math.sin(phi))
    wi = unit(to_light)
    square = dot(to_light, to_light)
    # Radiance I / (pi r^2) times the disc's area pi r^2.
    share = spot_share(s, lamp, scaled(wi, -1.0)) * dot(wi, axis) / square
    return wi, math.sqrt(square), scaled(vec(s.lamps[lamp].emission), share)


@kernel
def slats(s: Flat, lamp: int, cosine: float) -> float:
    """What a spread makes of the mean radiance at ``cosine`` to the axis."""
    if s.lamps[lamp].spread > 3.1414:
        return 1.0
    limit = math.tan(0.5 * s.lamps[lamp].spread)
    tangent = math.tan(math.acos(min(1.0, cosine)))
    if tangent >= limit:
        return 0.0
    return (1.0 - tangent / limit) / (1.0 - 0.5 * s.lamps[lamp].spread / limit)


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
    share = slats(s, lamp, cosine) * cosine * area / square
    return wi, math.sqrt(square), scaled(vec(s.lamps[lamp].emission), share)


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
def _sphere_exit(o: Vec, d: Vec, centre: Vec, radius: float) -> float:
    """Distance at which the ray leaves the sphere that it starts in."""
    to_centre = along(centre, o, -1.0)
    middle = dot(to_centre, d)
    beside = along(to_centre, d, -middle)
    return middle + math.sqrt(max(0.0, radius * radius - dot(beside, beside)))


@kernel
def seen_lamps(s: Flat, o: Vec, d: Vec, far: float, open_sky: bool, kind_of_ray: int) -> Vec:
    """Sum of the radiances of the shapes crossed before ``far`` that such a ray sees.

    ``open_sky``: the ray hits nothing, so it sees suns as well.
    """
    r, g, b = 0.0, 0.0, 0.0
    for lamp in range(len(s.lamps)):
        if s.lamps[lamp].visibility & kind_of_ray:
            rgb = _seen_lamp(s, lamp, o, d, far, open_sky)
            r, g, b = r + rgb[0], g + rgb[1], b + rgb[2]
    return r, g, b


@kernel
def _round_hit(s: Flat, lamp: int, o: Vec, d: Vec) -> tuple[float, bool]:
    """Distance to the sphere or facing disc, -1 when missed, and whether from inside."""
    centre, radius = vec(s.lamps[lamp].position), s.lamps[lamp].radius
    to_centre = along(centre, o, -1.0)
    square = dot(to_centre, to_centre)
    if s.lamps[lamp].soft:
        forward = dot(to_centre, d)
        if forward <= 0.0:
            return -1.0, False
        t = square / forward
        gap = along(along(o, d, t), centre, -1.0)
        return (t, False) if dot(gap, gap) <= radius * radius else (-1.0, False)
    if square <= radius * radius:
        return _sphere_exit(o, d, centre, radius), True
    return _sphere_entry(o, d, centre, radius), False


@kernel
def _seen_lamp(s: Flat, lamp: int, o: Vec, d: Vec, far: float, open_sky: bool) -> Vec:
    dark = (0.0, 0.0, 0.0)
    kind = s.lamps[lamp].kind
    if kind == _SUN:
        angle = s.lamps[lamp].angle
        if angle <= 0.0 or not open_sky:
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
        t, within = _round_hit(s, lamp, o, d)
        if t <= 0.0 or t >= far:
            return dark
        # From inside, a spot's sphere shines all around (seen in Cycles).
        share = 1.0 if within else spot_share(s, lamp, scaled(d, -1.0))
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
    if outside:
        return dark
    return scaled(vec(s.lamps[lamp].emission), slats(s, lamp, cosine))
