"""What the scene needs, with reasons, and what the export had to leave out."""

from __future__ import annotations

import textwrap
from typing import Any

import bpy

from ..insight import counted, insight_of
from .panel import PhotonMapPanel

#: About the width of a letter [pixels at scale 1].
_LETTER = 7.0


def draw_text(layout: Any, context: Any, text: str, icon: str = "NONE") -> None:
    """``text`` in as many lines as the region's width asks for."""
    scale = context.preferences.system.ui_scale or 1.0  # 0 without a window
    letters = max(20, int(context.region.width / (_LETTER * scale)) - 8)
    column = layout.column(align=True)
    column.scale_y = 0.8
    for number, line in enumerate(textwrap.wrap(text, letters)):
        column.label(text=line, icon=icon if number == 0 else "BLANK1")


class PHOTONMAP_RENDER_PT_plan(PhotonMapPanel, bpy.types.Panel):
    """The stages of a render."""

    bl_label = "What the Scene Needs"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.operator("photon_map.plan", icon="VIEWZOOM")
        found = insight_of(context.scene)
        if found is None:
            return
        for name, on, reason in found.stages:
            icon = "CHECKMARK" if on else "X"
            draw_text(layout, context, f"{name.capitalize()}: {reason}", icon)
        if found.result:
            draw_text(layout, context, f"Last render: {found.result}", "RENDER_RESULT")


class PHOTONMAP_RENDER_PT_warnings(PhotonMapPanel, bpy.types.Panel):
    """What the export had to leave out: at the top, and there only when there is something."""

    bl_label = ""
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        found = insight_of(context.scene) if super().poll(context) else None
        return found is not None and bool(found.warnings)

    def draw_header(self, context: Any) -> None:
        found = insight_of(context.scene)
        text = counted(found.warnings if found else ())
        self.layout.label(text=f"{text} during export", icon="ERROR")

    def draw(self, context: Any) -> None:
        found = insight_of(context.scene)
        for message in found.warnings if found else ():
            draw_text(self.layout, context, message, "DOT")


PANELS = (PHOTONMAP_RENDER_PT_plan,)
