"""Blender's camera to the core's: units and lens, no rays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.camera_data import CameraData, CameraKind
from ..report import ExportError

#: Blender's own lower limit in renders: below it the lens would be without bounds.
_MIN_FSTOP = 1e-5

#: The core's word for each lens type that it knows.
_KINDS: dict[str, CameraKind] = {"PERSP": "PERSPECTIVE", "ORTHO": "ORTHOGRAPHIC"}


def export_camera(
    camera: Any, scene: Any, size: tuple[int, int], engine: Any | None = None
) -> CameraData:
    """The camera object ``camera`` at the image ``size`` (width, height) in pixels.

    ``engine`` knows the matrix of a stereo view; without one the object's own is taken.
    Raises ``ExportError`` for a panoramic camera, a custom one, and what is no camera.
    """
    data = camera.data
    kind = _KINDS.get(data.type) if camera.type == "CAMERA" else None
    if kind is None:
        found = data.type.lower() if camera.type == "CAMERA" else camera.type.lower()
        raise ExportError(
            f"camera '{camera.name}' is {found}; only perspective and orthographic cameras "
            "can be rendered, change its lens type"
        )
    matrix = np.array(
        engine.camera_model_matrix(camera) if engine is not None else camera.matrix_world,
        dtype=np.float64,
    )
    dof = data.dof
    lens_radius = 0.0
    if dof.use_dof:
        # Cycles counts the f-stop of an orthographic camera as if its lens were 1 m.
        length = 1.0 if kind == "ORTHOGRAPHIC" else data.lens * 1e-3
        lens_radius = length / (2.0 * max(dof.aperture_fstop, _MIN_FSTOP))
    return CameraData(
        width=size[0],
        height=size[1],
        kind=kind,
        matrix=matrix,
        lens=data.lens,
        sensor_width=data.sensor_width,
        sensor_height=data.sensor_height,
        sensor_fit=data.sensor_fit,
        shift_x=engine.camera_shift_x(camera) if engine is not None else data.shift_x,
        shift_y=data.shift_y,
        ortho_scale=data.ortho_scale,
        clip_start=data.clip_start,
        clip_end=data.clip_end,
        pixel_aspect_x=scene.render.pixel_aspect_x,
        pixel_aspect_y=scene.render.pixel_aspect_y,
        lens_radius=lens_radius,
        focus_distance=focus_distance(dof, matrix),
        blades=dof.aperture_blades,
        blade_rotation=dof.aperture_rotation,
        blade_ratio=dof.aperture_ratio,
    )


def focus_distance(dof: Any, matrix: NDArray[np.float64]) -> float:
    """Distance along the axis [m] of the plane in focus; that of the focus object if set."""
    if dof.focus_object is None:
        return max(1e-5, float(dof.focus_distance))
    target = dof.focus_object
    point = np.array(target.matrix_world.translation, dtype=np.float64)
    bones = getattr(target.pose, "bones", None) if target.type == "ARMATURE" else None
    if bones and dof.focus_subtarget in bones:
        local = bones[dof.focus_subtarget].matrix
        point = np.array((target.matrix_world @ local).translation, dtype=np.float64)
    axis = matrix[:3, 2] / np.linalg.norm(matrix[:3, 2])
    return max(1e-5, abs(float((point - matrix[:3, 3]) @ axis)))
