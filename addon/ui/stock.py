"""Blender's own panels that this engine shows.

A panel names the engines that it is for in ``COMPAT_ENGINES``. Those for the engine
"BLENDER_RENDER" are general, except a few whose settings would do nothing here; others name
only EEVEE, although what they show is general as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from .panel import ENGINE

#: Stock panels that list only other engines and are right for this one.
JOINED = (
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "MATERIAL_PT_preview",
)

#: General panels that this engine replaces (lamps, visibility), or whose settings would do
#: nothing here.
LEFT_OUT = (
    "DATA_PT_camera_stereoscopy",
    "DATA_PT_light",
    "DATA_PT_lightprobe",
    "DATA_PT_lightprobe_parallax",
    "DATA_PT_lightprobe_visibility",
    "DATA_PT_spot",
    "DATA_PT_volume_render",
    "NODE_DATA_PT_light",
    "NODE_DATA_PT_spot",
    "OBJECT_PT_shading",
    "OBJECT_PT_visibility",
    "PARTICLE_PT_render_path",
    "PARTICLE_PT_render_path_timing",
    "RENDER_PT_gpencil",
    "RENDER_PT_grease_pencil_render",
    "RENDER_PT_grease_pencil_viewport",
    "RENDER_PT_output_views",
    "RENDER_PT_simplify_greasepencil",
    "RENDER_PT_stereoscopy",
)


def join() -> None:
    """Show the engine's choice of stock panels."""
    for panel in _panels():
        general = "BLENDER_RENDER" in panel.COMPAT_ENGINES and not _left_out(panel)
        if general or panel.__name__ in JOINED:
            panel.COMPAT_ENGINES.add(ENGINE)


def leave() -> None:
    """Undo ``join``."""
    for panel in _panels():
        panel.COMPAT_ENGINES.discard(ENGINE)


def _left_out(panel: Any) -> bool:
    return panel.__name__ in LEFT_OUT or "freestyle" in panel.__name__


def _panels() -> Iterator[Any]:
    """Every foreign panel class with a list of engines that can be changed."""
    waiting = [bpy.types.Panel]
    while waiting:
        for panel in waiting.pop().__subclasses__():
            waiting.append(panel)
            own = panel.__name__.startswith("PHOTONMAP_")
            if not own and isinstance(getattr(panel, "COMPAT_ENGINES", None), set):
                yield panel
