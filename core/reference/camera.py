"""Primary rays of the perspective and the orthographic camera with a round thin lens."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..jit import allocating_kernel as kernel
from ..scene.camera_data import CameraData
from .vector import TWO_PI, Stream, Vec, along, uniform, unit, vec


def film_plane(camera: CameraData) -> NDArray[np.float64]:
    """The camera as rows (8, 3).

    Axes x, y, z; position; at distance 1 the film's (left, bottom, 0) and its (step x,
    step y, 0) per pixel; (lens radius x, lens radius y, focus distance); (1 when the film
    itself looks out, near, far).

    Raises ``ValueError`` for an aperture with blades, which the reference does not know.
    """
    if camera.blades >= 3 and camera.lens_radius > 0:
        raise ValueError("the reference path tracer knows round apertures only")
    side_x = camera.width * camera.pixel_aspect_x
    side_y = camera.height * camera.pixel_aspect_y
    fit = camera.sensor_fit
    if fit == "AUTO":
        fit = "HORIZONTAL" if side_x >= side_y else "VERTICAL"
    # AUTO counts the sensor's width along whichever side is fitted, as Blender does.
    sensor = camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width
    fitted = side_x if fit == "HORIZONTAL" else side_y
    parallel = camera.kind == "ORTHOGRAPHIC"
    scale = camera.ortho_scale / fitted if parallel else sensor / camera.lens / fitted
    shift = np.array([camera.shift_x, camera.shift_y]) * fitted * scale
    sides = np.array([side_x, side_y]) * scale
    matrix = np.asarray(camera.matrix, dtype=np.float64)
    table = np.zeros((8, 3))
    table[:3] = (matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)).T
    table[3] = matrix[:3, 3]
    table[4, :2] = shift - sides / 2
    table[5, :2] = sides / (camera.width, camera.height)
    table[6, :2] = camera.lens_radius / camera.blade_ratio, camera.lens_radius
    table[6, 2] = camera.focus_distance
    table[7] = parallel, camera.clip_start, camera.clip_end
    return table


@kernel
def primary_ray(
    camera: NDArray[np.float64], column: int, line: int, stream: Stream
) -> tuple[Vec, Vec, float]:
    """Origin, unit direction, and how far it sees: a uniform point of pixel and lens."""
    x = camera[4, 0] + (column + uniform(stream)) * camera[5, 0]
    y = camera[4, 1] + (line + uniform(stream)) * camera[5, 1]
    slant = math.sqrt(1.0 + x * x + y * y)
    base_x, base_y = 0.0, 0.0
    if camera[7, 0] > 0.0:
        base_x, base_y, x, y, slant = x, y, 0.0, 0.0, 1.0
    u, v, focus = 0.0, 0.0, 1.0
    if camera[6, 1] > 0.0:
        radius, phi = math.sqrt(uniform(stream)), TWO_PI * uniform(stream)
        u = camera[6, 0] * radius * math.cos(phi)
        v = camera[6, 1] * radius * math.sin(phi)
        focus = camera[6, 2]
    origin = along(
        along(vec(camera[3]), vec(camera[0]), base_x + u), vec(camera[1]), base_y + v
    )
    a, b = x * focus - u, y * focus - v
    direction = (
        a * camera[0, 0] + b * camera[1, 0] - focus * camera[2, 0],
        a * camera[0, 1] + b * camera[1, 1] - focus * camera[2, 1],
        a * camera[0, 2] + b * camera[1, 2] - focus * camera[2, 2],
    )
    way = unit(direction)
    near, far = camera[7, 1] * slant, camera[7, 2] * slant
    return along(origin, way, near), way, far - near
