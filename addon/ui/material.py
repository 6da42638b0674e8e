"""Settings of a material that no node carries."""

from __future__ import annotations

from typing import Any

import bpy


class PHOTONMAP_MATERIAL_PT_medium(bpy.types.Panel):
    """What counts where transparent bodies overlap."""

    bl_label = "Medium"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    bl_options = {"DEFAULT_CLOSED"}
    COMPAT_ENGINES = {"PHOTONMAP"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.material) and context.engine in cls.COMPAT_ENGINES

    def draw(self, context: Any) -> None:
        self.layout.use_property_split = True
        self.layout.prop(context.material.photon_map, "priority")


PANELS = (PHOTONMAP_MATERIAL_PT_medium,)
