"""The passes of a view layer."""

from __future__ import annotations

from typing import Any

import bpy

from ..passes import PASSES
from .panel import PhotonMapPanel


class PHOTONMAP_VIEWLAYER_PT_passes(PhotonMapPanel, bpy.types.Panel):
    """Only the passes that the engine can write."""

    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: Any) -> None:
        view_layer = context.view_layer
        column = self.column(heading="Include")
        for entry in PASSES:
            if entry.toggle.startswith("pm."):
                toggle = entry.toggle.removeprefix("pm.")
                column.prop(view_layer.photon_map, toggle, text=entry.name)
            elif entry.toggle:
                column.prop(view_layer, entry.toggle, text=entry.name)


PANELS = (PHOTONMAP_VIEWLAYER_PT_passes,)
