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


def view_key(context: Any, scene: Any) -> tuple[object, ...]:
    """What tells a view from another one."""
    view, region = context.region_data, context.region
    matrices = [np.array(m).tobytes() for m in (view.view_matrix, view.window_matrix)]
    border = view_border(context, scene)
    return (*matrices, region.width, region.height, view.view_perspective, border)


def view_border(context: Any, scene: Any) -> tuple[int, int, int, int] | None:
    """Pixels (x0, y0, x1, y1) of the region that alone are to be rendered, None for all.

    In the view of a camera the scene's border, a part of its frame, else that of the view.
    """
    view, region = context.region_data, context.region
    owner = context.space_data
    low, high = np.zeros(2), np.array([region.width, region.height], np.float64)
    if view.view_perspective == "CAMERA" and scene.camera is not None:
        if not scene.render.use_border:
            return None
        owner, prefix = scene.render, "border"
        low, high = _frame(np.array(view.window_matrix, np.float64), scene, high)
    elif owner.use_render_border:
        prefix = "render_border"
    else:
        return None
    begin, end = (
        low + (high - low) * [getattr(owner, f"{prefix}_{side}_{axis}") for axis in "xy"]
        for side in ("min", "max")
    )
    size = [region.width, region.height]
    x0, y0 = (round(v) for v in np.clip(begin, 0, size))
    x1, y1 = (round(v) for v in np.clip(end, 0, size))
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None


def _frame(
    window: NDArray[np.float64], scene: Any, size: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest pixel (2,) of the camera's frame in its view."""
    corners = np.array(scene.camera.data.view_frame(scene=scene), np.float64)
    places = np.column_stack([corners, np.ones(len(corners))]) @ window.T
    pixels = (places[:, :2] / places[:, 3:] + 1.0) * 0.5 * size
    return pixels.min(axis=0), pixels.max(axis=0)


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
