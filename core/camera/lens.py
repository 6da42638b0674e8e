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
