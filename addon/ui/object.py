"""What an object is to this engine: who sees it, and its caustics."""

from __future__ import annotations

from typing import Any

import bpy

from .panel import PhotonMapPanel, draw_light_group
from .plan import draw_text

#: Types with a surface that the export takes.
SURFACES = ("MESH", "CURVE", "SURFACE", "FONT", "META")


class ObjectPanel(PhotonMapPanel):
    """Where the panels of this file live."""

    bl_context = "object"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.object) and context.engine in cls.COMPAT_ENGINES


class PHOTONMAP_OBJECT_PT_caustics(ObjectPanel, bpy.types.Panel):
    """The object's part in caustics."""

    bl_label = "Caustics"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(super().poll(context)) and context.object.type in SURFACES

    def draw(self, context: Any) -> None:
        column, settings = self.column(), context.object.photon_map
        column.prop(settings, "casts_caustics")
        column.prop(settings, "shows_caustics")
        self.layout.operator("photon_map.why_no_caustic", icon="QUESTION")
        for line in settings.answer.splitlines():
            draw_text(self.layout, context, line, "INFO")


class PHOTONMAP_OBJECT_PT_light_group(ObjectPanel, bpy.types.Panel):
    """The light group of a lamp or a glowing object."""

    bl_label = "Light Group"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(super().poll(context)) and context.object.type in (*SURFACES, "LIGHT")

    def draw(self, context: Any) -> None:
        draw_light_group(self.column(), context, context.object)


class PHOTONMAP_OBJECT_PT_visibility(ObjectPanel, bpy.types.Panel):
    """As Cycles has it."""

    bl_label = "Visibility"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        obj = context.object
        self.column().prop(
            obj, "hide_select", text="Selectable", invert_checkbox=True, toggle=False
        )
        shown = self.column(heading="Show In")
        shown.prop(obj, "hide_viewport", text="Viewports", invert_checkbox=True, toggle=False)
        shown.prop(obj, "hide_render", text="Renders", invert_checkbox=True, toggle=False)


class PHOTONMAP_OBJECT_PT_ray_visibility(ObjectPanel, bpy.types.Panel):
    """Which rays see the object."""

    bl_label = "Ray Visibility"
    bl_parent_id = "PHOTONMAP_OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context: Any) -> bool:
        if not super().poll(context):
            return False
        return context.object.type in (*SURFACES, "LIGHT")

    def draw(self, context: Any) -> None:
        column, obj = self.column(), context.object
        column.prop(obj, "visible_camera", text="Camera")
        column.prop(obj, "visible_diffuse", text="Diffuse")
        column.prop(obj, "visible_glossy", text="Glossy")
        column.prop(obj, "visible_transmission", text="Transmission")
        if obj.type != "LIGHT":
            column.prop(obj, "visible_shadow", text="Shadow")


class PHOTONMAP_OBJECT_PT_mask(ObjectPanel, bpy.types.Panel):
    """The mask that is honoured; shadow catchers are not."""

    bl_label = "Mask"
    bl_parent_id = "PHOTONMAP_OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(super().poll(context)) and context.object.type in SURFACES

    def draw(self, context: Any) -> None:
        self.column().prop(context.object, "is_holdout")


PANELS = (
    PHOTONMAP_OBJECT_PT_caustics,
    PHOTONMAP_OBJECT_PT_light_group,
    PHOTONMAP_OBJECT_PT_visibility,
    PHOTONMAP_OBJECT_PT_ray_visibility,
    PHOTONMAP_OBJECT_PT_mask,
)
