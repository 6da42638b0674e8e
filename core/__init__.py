"""The engine: light transport on arrays. It knows nothing of Blender.

The public names are loaded when they are first used: a scene can be built and checked
without waiting for Numba and Embree.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .baking.bake import bake
    from .camera.motion import motion_vectors
    from .diagnosis import Finding, why_no_caustic
    from .film.film import Film
    from .film.layers import (
        FIRST_HIT_LAYERS,
        KIND_COLORS,
        KIND_LAYERS,
        aov_layer,
        group_layer,
    )
    from .film.mattes import name_bits
    from .kept import Kept
    from .photon_shades import photon_colours, photon_legend, power_scale
    from .plan import Plan
    from .renderer import render
    from .report import completed
    from .scene.builder import SceneBuilder
    from .scene.camera_data import CameraData
    from .scene.scene import Scene, SceneError
    from .settings import LightGroup, Settings, SettingsError
    from .update import Update
    from .viewed_pass import Disc, ViewedPass

_HOMES = {
    "FIRST_HIT_LAYERS": ".film.layers",
    "KIND_COLORS": ".film.layers",
    "KIND_LAYERS": ".film.layers",
    "CameraData": ".scene.camera_data",
    "Disc": ".viewed_pass",
    "Film": ".film.film",
    "Finding": ".diagnosis",
    "Kept": ".kept",
    "LightGroup": ".settings",
    "Plan": ".plan",
    "Scene": ".scene.scene",
    "SceneBuilder": ".scene.builder",
    "SceneError": ".scene.scene",
    "Settings": ".settings",
    "SettingsError": ".settings",
    "Update": ".update",
    "ViewedPass": ".viewed_pass",
    "aov_layer": ".film.layers",
    "bake": ".baking.bake",
    "completed": ".report",
    "group_layer": ".film.layers",
    "motion_vectors": ".camera.motion",
    "name_bits": ".film.mattes",
    "photon_colours": ".photon_shades",
    "photon_legend": ".photon_shades",
    "power_scale": ".photon_shades",
    "render": ".renderer",
    "why_no_caustic": ".diagnosis",
}

__all__ = [
    "FIRST_HIT_LAYERS",
    "KIND_COLORS",
    "KIND_LAYERS",
    "CameraData",
    "Disc",
    "Film",
    "Finding",
    "Kept",
    "LightGroup",
    "Plan",
    "Scene",
    "SceneBuilder",
    "SceneError",
    "Settings",
    "SettingsError",
    "Update",
    "ViewedPass",
    "aov_layer",
    "bake",
    "completed",
    "group_layer",
    "motion_vectors",
    "name_bits",
    "photon_colours",
    "photon_legend",
    "power_scale",
    "render",
    "why_no_caustic",
]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        return getattr(import_module(_HOMES[name], __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
