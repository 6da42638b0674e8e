"""Screenshots of Blender's window, and what a viewport in them shows."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from xwd import read_xwd  # type: ignore[import-not-found]


def region_of(area: Any) -> Any:
    """The region that a viewport is drawn in."""
    return next(region for region in area.regions if region.type == "WINDOW")


def screenshot(path: Path) -> np.ndarray:
    """What the display shows, kept as a dump: (h, w, 3) from the bottom, 0 to 1.

    Blender's own screenshots are black with Mesa's software renderer.
    """
    subprocess.run(["xwd", "-root", "-silent", "-out", str(path)], check=True)
    return read_xwd(path)[::-1] / np.float32(255)


def cut(pixels: np.ndarray, area: Any) -> np.ndarray:
    """The part of a screenshot that shows what the camera of a viewport sees."""
    region, view = region_of(area), area.spaces.active.region_3d
    camera = bpy.context.scene.camera
    corners = [
        location_3d_to_region_2d(region, view, camera.matrix_world @ corner)
        for corner in camera.data.view_frame(scene=bpy.context.scene)
    ]
    x = sorted(region.x + corner[0] for corner in corners)
    y = sorted(region.y + corner[1] for corner in corners)
    left, right = max(region.x, int(x[0]) + 1), min(region.x + region.width, int(x[-1]))
    low, high = max(region.y, int(y[0]) + 1), min(region.y + region.height, int(y[-1]))
    return pixels[low:high, left:right]
