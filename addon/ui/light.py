"""The lamp's settings, without those that only other engines honour."""

from __future__ import annotations

from typing import Any

import bpy


class PHOTONMAP_LIGHT_PT_light(bpy.types.Panel):
    """Type, colour, power and size."""

    bl_label = "Light"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"
    COMPAT_ENGINES = {"PHOTONMAP"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.light) and context.engine in cls.COMPAT_ENGINES

    def draw(self, context: Any) -> None:
        layout, light = self.layout, context.light
        layout.row().prop(light, "type", expand=True)
        layout.use_property_split = True
        column = layout.column()
        if hasattr(light, "use_temperature"):  # since 4.5
            column.prop(light, "use_temperature")
            row = column.row()
            row.active = light.use_temperature
            row.prop(light, "temperature")
        column.prop(light, "color")
        column.separator()
        column.prop(light, "energy")
        if hasattr(light, "exposure"):  # since 4.5
            column.prop(light, "exposure")
            column.prop(light, "normalize")
        column.separator()
        draw_size(column, light)


def draw_size(column: Any, light: Any) -> None:
    """The size of the lamp, which depends on its type."""
    if light.type in ("POINT", "SPOT"):
        column.prop(light, "shadow_soft_size", text="Radius")
    elif light.type == "SUN":
        column.prop(light, "angle")
    elif light.type == "AREA":
        column.prop(light, "shape")
        sub = column.column(align=True)
        if light.shape in ("SQUARE", "DISK"):
            sub.prop(light, "size")
        else:
            sub.prop(light, "size", text="Size X")
            sub.prop(light, "size_y", text="Y")


PANELS = (PHOTONMAP_LIGHT_PT_light,)
