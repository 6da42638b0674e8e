"""Blender's perspective and orthographic cameras: view, sensor fit, shift, pixel aspect.

Checked against Cycles: the axis meets the image at (W/2 - shift_x S, H/2 - shift_y S)
from the bottom left, S being the pixel size of the fitted side.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.mesh import Centre
from ..scene.camera_data import CameraData


class CameraTables(NamedTuple):
    """A camera as kernels see it, in centred coordinates.

    ``axes`` rows: right, up, forward. A pixel position (x, y) from the bottom left looks
    along right (x step_x + left) + up (y step_y + bottom) + forward; an orthographic
    camera looks forward from there instead. ``clip_start`` and ``clip_end`` [m] count along
    the axis. ``filter_table`` (2, n): see ``film/filters``.
    """

    position: NDArray[np.float64]
    axes: NDArray[np.float64]
    orthographic: bool
    left: float
    bottom: float
    step_x: float
    step_y: float
    lens_radius: float
    focus_distance: float
    clip_start: float
    clip_end: float
    blades: int
    blade_rotation: float
    blade_ratio: float
    filter_table: NDArray[np.float64]


def camera_tables(
    camera: CameraData, centre: Centre, filter_table: NDArray[np.float64]
) -> CameraTables:
    """Fit the sensor to the image as Blender does."""
    axes = camera.matrix[:3, :3].T.astype(np.float64).copy()
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    axes[2] *= -1.0
    wide = camera.width * camera.pixel_aspect_x
    tall = camera.height * camera.pixel_aspect_y
    horizontal = camera.sensor_fit == "HORIZONTAL" or (
        camera.sensor_fit == "AUTO" and wide >= tall
    )
    sensor = camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width
    fitted = wide if horizontal else tall
    orthographic = camera.kind == "ORTHOGRAPHIC"
    # Length (perspective: at distance 1) of one unit of the fitted side, pixels times aspect.
    unit = (camera.ortho_scale if orthographic else sensor / camera.lens) / fitted
    left = (-0.5 * wide + camera.shift_x * fitted) * unit
    bottom = (-0.5 * tall + camera.shift_y * fitted) * unit
    return CameraTables(
        position=camera.matrix[:3, 3] - centre.origin,
        axes=axes,
        orthographic=orthographic,
        left=left,
        bottom=bottom,
        step_x=unit * camera.pixel_aspect_x,
        step_y=unit * camera.pixel_aspect_y,
        lens_radius=camera.lens_radius,
        focus_distance=camera.focus_distance,
        clip_start=camera.clip_start,
        clip_end=camera.clip_end,
        blades=camera.blades,
        blade_rotation=camera.blade_rotation,
        blade_ratio=camera.blade_ratio,
        filter_table=filter_table,
    )
