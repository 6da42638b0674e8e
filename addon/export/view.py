"""The camera of a viewport: a view's matrices as the core's lens."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.camera_data import CameraData
from .camera import export_camera

#: Any film will do, the lens is chosen for it [mm].
_SENSOR = 36.0
#: What a view takes of its camera's lens.
_BLUR = ("lens_radius", "focus_distance", "blades", "blade_rotation", "blade_ratio")
#: Nearest that an orthographic view begins before its camera [m].
_NEAREST = 1e-4


def view_camera(context: Any, scene: Any) -> CameraData:
    """What the 3D view of ``context`` sees; in the view of a camera with its lens blur."""
    view, region = context.region_data, context.region
    camera = camera_of(
        np.array(view.view_matrix, np.float64),
        np.array(view.window_matrix, np.float64),
        region.width,
        region.height,
    )
    if view.view_perspective != "CAMERA" or scene.camera is None:
        return camera
    lens = export_camera(scene.camera, scene, (region.width, region.height))
    return replace(camera, **{name: getattr(lens, name) for name in _BLUR})


def view_key(context: Any) -> tuple[object, ...]:
    """What tells a view from another one."""
    view, region = context.region_data, context.region
    matrices = [np.array(m).tobytes() for m in (view.view_matrix, view.window_matrix)]
    return (*matrices, region.width, region.height, view.view_perspective)


def camera_of(
    view: NDArray[np.float64], window: NDArray[np.float64], width: int, height: int
) -> CameraData:
    """The camera with a view matrix and a projection, in pixels ``width`` x ``height``.

    Rows of the projection: x and y of the lens, shifted off the axis, and the clipping.
    """
    matrix = np.linalg.inv(view)
    aspect = height / width
    common: dict[str, Any] = {
        "width": width,
        "height": height,
        "sensor_width": _SENSOR,
        "sensor_height": _SENSOR,
        "sensor_fit": "HORIZONTAL",
    }
    if window[3, 2] != 0.0:
        return CameraData(
            kind="PERSPECTIVE",
            matrix=matrix,
            lens=0.5 * _SENSOR * window[0, 0],
            shift_x=0.5 * window[0, 2],
            shift_y=0.5 * window[1, 2] * aspect,
            clip_start=window[2, 3] / (window[2, 2] - 1.0),
            clip_end=window[2, 3] / (window[2, 2] + 1.0),
            **common,
        )
    near, far = ((window[2, 3] + side) / window[2, 2] for side in (1.0, -1.0))
    # An orthographic view begins behind its own origin.
    back = max(0.0, _NEAREST - near)
    matrix[:3, 3] += back * matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    return CameraData(
        kind="ORTHOGRAPHIC",
        matrix=matrix,
        ortho_scale=2.0 / window[0, 0],
        shift_x=-0.5 * window[0, 3],
        shift_y=-0.5 * window[1, 3] * aspect,
        clip_start=near + back,
        clip_end=far + back,
        **common,
    )
