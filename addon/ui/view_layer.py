"""The passes of a view layer."""

from __future__ import annotations

from typing import Any

import bpy

from ..passes import PASSES


class PHOTONMAP_VIEWLAYER_PT_passes(bpy.types.Panel):
    """Only the passes that the engine can write."""

    bl_label = "Passes"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "view_layer"
    COMPAT_ENGINES = {"PHOTONMAP"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return context.engine in cls.COMPAT_ENGINES

    def draw(self, context: Any) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        view_layer = context.view_layer
        column = layout.column(heading="Include")
        for entry in PASSES:
            if entry.toggle.startswith("pm."):
                toggle = entry.toggle.removeprefix("pm.")
                column.prop(view_layer.photon_map, toggle, text=entry.name)
            elif entry.toggle:
                column.prop(view_layer, entry.toggle, text=entry.name)


PANELS = (PHOTONMAP_VIEWLAYER_PT_passes,)
