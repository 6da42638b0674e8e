"""The scene's render properties as the core's ``Settings``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...core.settings import AUTOMATIC, Settings
from .scene import image_size

#: Pixels that a filter may be wide.
FILTER_WIDTHS = (0.01, 100.0)
#: Properties of ``Scene.photon_map`` that are fields of ``Settings`` of the same name.
FIELDS = (
    "passes",
    "seconds",
    "error_goal",
    "seed",
    "adaptive",
    "camera_depth",
    "photon_depth",
    "min_throughput",
    "split_depth",
    "split_least",
    "caustic_radius",
    "alpha",
    "photon_memory",
    "shadow_photons",
    "shadow_lit",
    "shadow_dark",
    "pixel_filter",
    "exposure",
)


def export_settings(scene: Any, overrides: Mapping[str, Any]) -> Settings:
    """Settings of ``scene``; ``overrides`` win. Raises ``SettingsError``."""
    values = {name: getattr(scene.photon_map, name) for name in FIELDS}
    values.update(_photons(scene.photon_map))
    render = scene.render
    values["threads"] = render.threads if render.threads_mode == "FIXED" else 0
    # Blender takes widths of 0 to 500 pixels.
    values["filter_width"] = float(np.clip(scene.render.filter_size, *FILTER_WIDTHS))
    if {**values, **overrides}["pixel_filter"] == "BOX":
        # As in Cycles: the stock width is one for filters with tails.
        values["filter_width"] = 1.0
    values["transparent"] = scene.render.film_transparent
    values["region"] = border_region(scene)
    values.update(overrides)
    return Settings(**values)


def _photons(own: Any) -> dict[str, int]:
    """Photons a pass, light samples and gather rays, by hand or automatic."""
    names = ("photons_caustic", "photons_global", "light_samples", "gather_rays")
    return {name: AUTOMATIC if own.photons_automatic else getattr(own, name) for name in names}


def border_region(scene: Any) -> tuple[int, int, int, int] | None:
    """Pixels (x0, y0, x1, y1) of the border, None without one.

    Rounded down from a product in float32 as Blender does it, or the result would not fit
    into its image.
    """
    render = scene.render
    if not render.use_border:
        return None
    width, height = image_size(scene)
    x0, x1 = (_pixel(v, width) for v in (render.border_min_x, render.border_max_x))
    y0, y1 = (_pixel(v, height) for v in (render.border_min_y, render.border_max_y))
    if x0 == 0 and y0 == 0 and x1 == width and y1 == height:
        return None
    return x0, y0, x1, y1


def _pixel(fraction: float, size: int) -> int:
    return int(np.float32(fraction) * np.float32(size))
