"""The thin lens: where on the aperture a ray starts and where it is in focus.

Every ray through the lens meets the pinhole's ray on the plane of focus, which is
perpendicular to the axis (Cook, Porter & Carpenter 1984).
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector, along, dot, normalize, read, subtract
from ..jit import Row, Table, kernel
from ..sampling.warps import sample_disk, sample_polygon


@kernel
def sample_lens(camera: Row, u: float, v: float) -> tuple[float, float]:
    """Point of the aperture in camera x and y [m]: disc or polygon, turned, squeezed."""
    turn = camera.blade_rotation
    if camera.blades >= 3:
        x, y = sample_polygon(camera.blades, u, v)
        # Not turned, Cycles' polygon has the middle of a side to its right.
        turn += math.pi / camera.blades
    else:
        x, y = sample_disk(u, v)
    c = math.cos(turn)
    s = math.sin(turn)
    x, y = x * c - y * s, x * s + y * c
    return camera.lens_radius * x / camera.blade_ratio, camera.lens_radius * y


@kernel
def filter_offset(table: Table, u: float) -> float:
    """Offset from the pixel's middle [pixels] with the filter's distribution."""
    low = 0
    high = table.shape[1] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if table[1, middle] <= u:
            low = middle
        else:
            high = middle
    share = table[1, high] - table[1, low]
    t = (u - table[1, low]) / share if share > 0.0 else 0.5
    return table[0, low] * (1.0 - t) + table[0, high] * t


@kernel
def camera_ray(
    camera: Row, x: int, y: int, u_x: float, u_y: float, u_lens: float, v_lens: float
) -> tuple[Vector, Vector, float, float]:
    """Ray of pixel (x, y), counted from the bottom left.

    Gives (origin, unit direction, way from the lens to the origin, farthest way from the
    origin): what lies nearer than the clipping start or farther than its end is not seen.
    """
    right = read(camera.axes, 0)
    up = read(camera.axes, 1)
    forward = read(camera.axes, 2)
    across = (x + 0.5 + filter_offset(camera.filter_table, u_x)) * camera.step_x + camera.left
    above = (y + 0.5 + filter_offset(camera.filter_table, u_y)) * camera.step_y + camera.bottom
    origin = read(camera.position.reshape(1, 3), 0)
    d = forward
    if camera.orthographic:
        origin = along(along(origin, right, across), up, above)
    else:
        d = along(along(forward, right, across), up, above)
    # Cycles measures clipping along the ray through the middle of the lens.
    cosine = 1.0 / math.sqrt(dot(d, d))
    if camera.lens_radius > 0.0:
        lx, ly = sample_lens(camera, u_lens, v_lens)
        focus = along(origin, d, camera.focus_distance)
        origin = along(along(origin, right, lx), up, ly)
        d = subtract(focus, origin)
    d = normalize(d)
    before = camera.clip_start / cosine
    return along(origin, d, before), d, before, (camera.clip_end - camera.clip_start) / cosine


@kernel
def towards(
    camera: Row, p: Vector, u_lens: float, v_lens: float
) -> tuple[float, float, Vector, Vector, float, float, float]:
    """Ray from a point of the lens towards ``p``, and where it crosses the film.

    Gives (x, y [pixels], origin, unit direction, way from the lens to the origin, farthest way
    from the origin, area of the film [pixels^2] per solid angle at the lens [sr], or per area
    across the rays [m^2] of an orthographic camera); the last is 0 behind the camera.
    """
    right = read(camera.axes, 0)
    up = read(camera.axes, 1)
    forward = read(camera.axes, 2)
    origin = read(camera.position.reshape(1, 3), 0)
    focus = camera.focus_distance
    lx = ly = 0.0
    if camera.lens_radius > 0.0:
        lx, ly = sample_lens(camera, u_lens, v_lens)
    ahead = subtract(p, origin)
    across, above, depth = dot(ahead, right), dot(ahead, up), dot(ahead, forward)
    d = forward
    if camera.orthographic:
        # The lens lies about the place where the ray of the lens' middle starts.
        if camera.lens_radius > 0.0:
            across -= lx * (1.0 - depth / focus)
            above -= ly * (1.0 - depth / focus)
            d = normalize(
                along(along(along((0.0, 0.0, 0.0), forward, focus), right, -lx), up, -ly)
            )
        origin = along(along(origin, right, across), up, above)
        origin = along(along(origin, right, lx), up, ly)
    else:
        if depth <= 0.0:
            return 0.0, 0.0, origin, forward, 0.0, 0.0, 0.0
        origin = along(along(origin, right, lx), up, ly)
        across, above = (across - lx) / depth, (above - ly) / depth
        if camera.lens_radius > 0.0:
            across += lx / focus
            above += ly / focus
        d = normalize(subtract(p, origin))
    x = (across - camera.left) / camera.step_x
    y = (above - camera.bottom) / camera.step_y
    # Clipping is measured along the ray through the middle of the lens.
    middle = 1.0
    if not camera.orthographic:
        middle = 1.0 / math.sqrt(1.0 + across * across + above * above)
    before = camera.clip_start / middle
    reach = (camera.clip_end - camera.clip_start) / middle
    cosine = dot(d, forward)
    area = camera.step_x * camera.step_y * cosine
    if not camera.orthographic:
        area *= cosine * cosine
    return x, y, along(origin, d, before), d, before, reach, 1.0 / area
