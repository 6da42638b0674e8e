"""Presets of the sampling panel: ours lie in ``addon/presets``, a user's in their profile."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from .panel import ENGINE

#: Blender looks for presets/photon_map/sampling below it.
FOLDER = str(Path(__file__).parents[1])

#: What a preset says; the seed and the film are no question of quality.
SETTINGS = (
    "passes",
    "seconds",
    "error_goal",
    "adaptive",
    "photons_automatic",
    "photons_caustic",
    "photons_global",
    "caustic_radius",
    "alpha",
    "light_samples",
    "gather_rays",
    "camera_depth",
    "photon_depth",
    "min_throughput",
    "split_depth",
    "split_least",
)


class PHOTONMAP_PT_sampling_presets(PresetPanel, bpy.types.Panel):
    """The menu in the panel's header."""

    bl_label = "Sampling Presets"
    preset_subdir = "photon_map/sampling"
    preset_operator = "script.execute_preset"
    preset_add_operator = "photon_map.sampling_preset_add"
    COMPAT_ENGINES = {ENGINE}


class PHOTONMAP_OT_sampling_preset_add(AddPresetBase, bpy.types.Operator):
    """Add a preset of the present sampling settings, or remove the chosen one"""

    bl_idname = "photon_map.sampling_preset_add"
    bl_label = "Add Sampling Preset"
    preset_menu = "PHOTONMAP_PT_sampling_presets"
    preset_defines = ["settings = bpy.context.scene.photon_map"]
    preset_values = [f"settings.{name}" for name in SETTINGS]
    preset_subdir = PHOTONMAP_PT_sampling_presets.preset_subdir


CLASSES: tuple[Any, ...] = (PHOTONMAP_PT_sampling_presets, PHOTONMAP_OT_sampling_preset_add)


def register() -> None:
    """Show Blender the presets."""
    bpy.utils.register_preset_path(FOLDER)


def unregister() -> None:
    """Hide them again."""
    bpy.utils.unregister_preset_path(FOLDER)
