"""The passes of a view layer."""

from __future__ import annotations

from typing import Any

import bpy

from ..passes import MATTES, PASSES
from .panel import PhotonMapPanel

#: What one switch of several passes is called.
_SHARED = {"pm.use_pass_denoising": "Denoising Data"}


class PHOTONMAP_VIEWLAYER_PT_passes(PhotonMapPanel, bpy.types.Panel):
    """Only the passes that the engine can write."""

    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context: Any) -> None:
        view_layer = context.view_layer
        column = self.column(heading="Include")
        shown = set()
        for entry in PASSES:
            toggle, text = entry.toggle, _SHARED.get(entry.toggle, entry.name)
            if not toggle or toggle in shown:
                continue
            shown.add(toggle)
            owner = view_layer
            if toggle.startswith("pm."):
                owner, toggle = view_layer.photon_map, toggle.removeprefix("pm.")
            column.prop(owner, toggle, text=text)


class PHOTONMAP_VIEWLAYER_PT_cryptomatte(PhotonMapPanel, bpy.types.Panel):
    """Mattes by name."""

    bl_label = "Cryptomatte"
    bl_context = "view_layer"
    bl_parent_id = "PHOTONMAP_VIEWLAYER_PT_passes"

    def draw(self, context: Any) -> None:
        view_layer = context.view_layer
        column = self.column(heading="Include")
        for entry in MATTES:
            column.prop(view_layer, entry.toggle, text=entry.name.removeprefix("Crypto"))
        levels = column.column()
        levels.active = any(getattr(view_layer, entry.toggle) for entry in MATTES)
        levels.prop(view_layer, "pass_cryptomatte_depth", text="Levels")


class PHOTONMAP_VIEWLAYER_PT_light_groups(PhotonMapPanel, bpy.types.Panel):
    """Groups of lights, by Blender's own operators."""

    bl_label = "Light Groups"
    bl_context = "view_layer"
    bl_parent_id = "PHOTONMAP_VIEWLAYER_PT_passes"

    def draw(self, context: Any) -> None:
        view_layer = context.view_layer
        row = self.layout.row()
        row.template_list(
            "UI_UL_list", "photon_map_lightgroups", view_layer, "lightgroups", view_layer,
            "active_lightgroup_index", rows=3,
        )  # fmt: skip
        buttons = row.column(align=True)
        buttons.operator("scene.view_layer_add_lightgroup", icon="ADD", text="")
        buttons.operator("scene.view_layer_remove_lightgroup", icon="REMOVE", text="")
        buttons.separator()
        buttons.menu("VIEWLAYER_MT_lightgroup_sync", icon="DOWNARROW_HLT", text="")


class PHOTONMAP_VIEWLAYER_PT_aovs(PhotonMapPanel, bpy.types.Panel):
    """Values of AOV Output nodes, by Blender's own operators."""

    bl_label = "Shader AOV"
    bl_context = "view_layer"
    bl_parent_id = "PHOTONMAP_VIEWLAYER_PT_passes"

    def draw(self, context: Any) -> None:
        view_layer = context.view_layer
        row = self.layout.row()
        row.template_list(
            "VIEWLAYER_UL_aov", "photon_map_aovs", view_layer, "aovs", view_layer,
            "active_aov_index", rows=3,
        )  # fmt: skip
        buttons = row.column(align=True)
        buttons.operator("scene.view_layer_add_aov", icon="ADD", text="")
        buttons.operator("scene.view_layer_remove_aov", icon="REMOVE", text="")
        active = view_layer.active_aov
        if active is not None and not active.is_valid:
            self.layout.label(text="Conflicts with another pass of the same name", icon="ERROR")


class PHOTONMAP_VIEWLAYER_PT_override(PhotonMapPanel, bpy.types.Panel):
    """Blender's own, without the samples that only its engines have."""

    bl_label = "Override"
    bl_context = "view_layer"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        column = self.column()
        column.prop(context.view_layer, "material_override")
        column.prop(context.view_layer, "world_override")


PANELS = (
    PHOTONMAP_VIEWLAYER_PT_passes,
    PHOTONMAP_VIEWLAYER_PT_cryptomatte,
    PHOTONMAP_VIEWLAYER_PT_light_groups,
    PHOTONMAP_VIEWLAYER_PT_aovs,
    PHOTONMAP_VIEWLAYER_PT_override,
)
