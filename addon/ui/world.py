"""The world's shader and who sees it."""

from __future__ import annotations

from typing import Any

import bpy

from ..export.trees import tree_of
from .panel import PhotonMapPanel, draw_light_group, draw_nodes


class WorldPanel(PhotonMapPanel):
    """Where the panels of this file live."""

    bl_context = "world"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.world) and context.engine in cls.COMPAT_ENGINES


class PHOTONMAP_WORLD_PT_surface(WorldPanel, bpy.types.Panel):
    """The light from all around."""

    bl_label = "Surface"

    def draw(self, context: Any) -> None:
        world = context.world
        tree = tree_of(world)
        draw_nodes(self.layout, world, tree, "Surface")
        if tree is None:
            self.column().prop(world, "color")


class PHOTONMAP_WORLD_PT_light_group(WorldPanel, bpy.types.Panel):
    """The light group of the world."""

    bl_label = "Light Group"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        draw_light_group(self.column(), context, context.world)


class PHOTONMAP_WORLD_PT_ray_visibility(WorldPanel, bpy.types.Panel):
    """Cycles' own switches, which are there while Cycles is enabled."""

    bl_label = "Ray Visibility"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return super().poll(context) and hasattr(context.world, "cycles_visibility")

    def draw(self, context: Any) -> None:
        column, switches = self.column(), context.world.cycles_visibility
        for name in ("camera", "diffuse", "glossy", "transmission"):
            column.prop(switches, name)


class PHOTONMAP_WORLD_PT_mist(WorldPanel, bpy.types.Panel):
    """Where the Mist pass begins and ends, while a view layer has it."""

    bl_label = "Mist Pass"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        layers = context.scene.view_layers
        return bool(super().poll(context)) and any(layer.use_pass_mist for layer in layers)

    def draw(self, context: Any) -> None:
        mist = context.world.mist_settings
        ends = self.column().column(align=True)
        ends.prop(mist, "start")
        ends.prop(mist, "depth")
        self.column().prop(mist, "falloff")


PANELS = (
    PHOTONMAP_WORLD_PT_surface,
    PHOTONMAP_WORLD_PT_light_group,
    PHOTONMAP_WORLD_PT_ray_visibility,
    PHOTONMAP_WORLD_PT_mist,
)
