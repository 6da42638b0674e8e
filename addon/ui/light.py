"""The lamp's settings, without those that only other engines honour."""

from __future__ import annotations

from typing import Any

import bpy

from ..export.trees import tree_of
from .panel import PhotonMapPanel, draw_nodes


class LightPanel(PhotonMapPanel):
    """Where the panels of this file live."""

    bl_context = "data"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.light) and context.engine in cls.COMPAT_ENGINES


class PHOTONMAP_LIGHT_PT_light(LightPanel, bpy.types.Panel):
    """Type, colour, power and size."""

    bl_label = "Light"

    def draw(self, context: Any) -> None:
        layout, light = self.layout, context.light
        layout.row().prop(light, "type", expand=True)
        layout.use_property_split = True
        column = layout.column()
        if hasattr(light, "use_temperature"):  # since 4.5
            row = column.column(align=True, heading="Temperature").row(align=True)
            row.prop(light, "use_temperature", text="")
            value = row.row()
            value.active = light.use_temperature
            value.prop(light, "temperature", text="")
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
        column.prop(light, "use_soft_falloff")
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


class PHOTONMAP_LIGHT_PT_beam_shape(LightPanel, bpy.types.Panel):
    """The cone of a spot, the slats of an area lamp."""

    bl_label = "Beam Shape"
    bl_parent_id = "PHOTONMAP_LIGHT_PT_light"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return super().poll(context) and context.light.type in ("SPOT", "AREA")

    def draw(self, context: Any) -> None:
        column, light = self.column(), context.light
        if light.type == "SPOT":
            column.prop(light, "spot_size", text="Angle")
            column.prop(light, "spot_blend", text="Blend", slider=True)
            column.prop(light, "show_cone")
        else:
            column.prop(light, "spread")


class PHOTONMAP_LIGHT_PT_settings(LightPanel, bpy.types.Panel):
    """Shadows and photons."""

    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        column, light = self.column(), context.light
        column.prop(light, "use_shadow", text="Cast Shadow")
        column.prop(light.photon_map, "photons")


class PHOTONMAP_LIGHT_PT_nodes(LightPanel, bpy.types.Panel):
    """The emission that colours the lamp."""

    bl_label = "Nodes"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        draw_nodes(self.layout, context.light, tree_of(context.light), "Surface")


PANELS = (
    PHOTONMAP_LIGHT_PT_light,
    PHOTONMAP_LIGHT_PT_beam_shape,
    PHOTONMAP_LIGHT_PT_settings,
    PHOTONMAP_LIGHT_PT_nodes,
)
