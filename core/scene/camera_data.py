"""What a scene says of its camera; the rays are made in ``core/camera``."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

SensorFit = Literal["AUTO", "HORIZONTAL", "VERTICAL"]
CameraKind = Literal["PERSPECTIVE", "ORTHOGRAPHIC"]


@dataclass(frozen=True, eq=False, kw_only=True)
class CameraData:
    """A camera with a thin lens, looking along its local -Z.

    ``matrix`` (4, 4) float64 takes camera space to world space (scale is ignored).
    ``lens``, ``sensor_width`` and ``sensor_height`` are millimetres, ``lens_radius`` and
    ``focus_distance`` (along the axis) metres, ``blade_rotation`` radians. Shifts count in
    the sensor's fitted side. ``blades`` below 3 means a round aperture; ``blade_ratio``
    above 1 squeezes it horizontally (anamorphic bokeh). An orthographic camera sees
    ``ortho_scale`` metres along the fitted side. Camera rays see nothing nearer than
    ``clip_start`` or farther than ``clip_end``, metres along the axis.
    """

    width: int
    height: int
    kind: CameraKind = "PERSPECTIVE"
    matrix: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    lens: float = 50.0
    sensor_width: float = 36.0
    sensor_height: float = 24.0
    sensor_fit: SensorFit = "AUTO"
    shift_x: float = 0.0
    shift_y: float = 0.0
    ortho_scale: float = 6.0
    clip_start: float = 0.0
    clip_end: float = math.inf
    pixel_aspect_x: float = 1.0
    pixel_aspect_y: float = 1.0
    lens_radius: float = 0.0
    focus_distance: float = 1.0
    blades: int = 0
    blade_rotation: float = 0.0
    blade_ratio: float = 1.0
