"""A material's surface, what fills the space behind it, and where bodies overlap."""

from __future__ import annotations

from typing import Any

import bpy

from ..export.trees import tree_of
from .panel import PhotonMapPanel, draw_nodes


class MaterialPanel(PhotonMapPanel):
    """Where the panels of this file live."""

    bl_context = "material"

    @classmethod
    def poll(cls, context: Any) -> bool:
        if not context.material or context.material.grease_pencil:
            return False
        return context.engine in cls.COMPAT_ENGINES


class PHOTONMAP_MATERIAL_PT_surface(MaterialPanel, bpy.types.Panel):
    """The shader."""

    bl_label = "Surface"

    def draw(self, context: Any) -> None:
        material = context.material
        tree = tree_of(material)
        draw_nodes(self.layout, material, tree, "Surface")
        if tree is None:
            self.column().prop(material, "diffuse_color", text="Base Color")


class PHOTONMAP_MATERIAL_PT_volume(MaterialPanel, bpy.types.Panel):
    """Absorption, and which of two bodies counts."""

    bl_label = "Volume"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        material = context.material
        tree = tree_of(material)
        if tree is not None:
            draw_nodes(self.layout, material, tree, "Volume")
        self.column().prop(material.photon_map, "priority")


class PHOTONMAP_MATERIAL_PT_settings(MaterialPanel, bpy.types.Panel):
    """What the Material Index pass shows."""

    bl_label = "Settings"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        self.column().prop(context.material, "pass_index")


PANELS = (
    PHOTONMAP_MATERIAL_PT_surface,
    PHOTONMAP_MATERIAL_PT_volume,
    PHOTONMAP_MATERIAL_PT_settings,
)
