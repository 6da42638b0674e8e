"""Pictures of materials, lamps and the world in their tabs."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from ..preview import WAITING
from .panel import ENGINE
from .world import WorldPanel

#: Blender's own panels with a preview.
STOCK = ("MATERIAL_PT_preview", "DATA_PT_preview")


class PHOTONMAP_WORLD_PT_preview(WorldPanel, bpy.types.Panel):
    """What the world looks like."""

    bl_label = "Preview"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        self.layout.template_preview(context.world)
        draw_note(self, context)


def draw_note(panel: Any, context: Any) -> None:
    """Why there is no picture yet."""
    if context.engine == ENGINE and WAITING.is_set():
        panel.layout.label(text="Compiling the kernels, once: up to a minute", icon="INFO")


def join() -> None:
    """Add the note to Blender's own panels."""
    for panel in _stock():
        panel.append(draw_note)


def leave() -> None:
    """Undo ``join``."""
    for panel in _stock():
        panel.remove(draw_note)


def _stock() -> Iterator[Any]:
    for name in STOCK:
        panel = getattr(bpy.types, name, None)
        if panel is not None:
            yield panel


PANELS = (PHOTONMAP_WORLD_PT_preview,)
