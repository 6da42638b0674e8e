"""The render settings of the scene."""

from __future__ import annotations

from typing import Any

import bpy


class PhotonMapRenderPanel:
    """Where the panels of this file live, and for which engine."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"PHOTONMAP"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return context.engine in cls.COMPAT_ENGINES

    def column(self, context: Any) -> tuple[Any, Any]:
        """A column of the panel, and the properties that go into it."""
        layout: Any = self.layout  # type: ignore[attr-defined]
        layout.use_property_split = True
        layout.use_property_decorate = False
        return layout.column(), context.scene.photon_map


class PHOTONMAP_RENDER_PT_sampling(PhotonMapRenderPanel, bpy.types.Panel):
    """When a render ends."""

    bl_label = "Sampling"

    def draw(self, context: Any) -> None:
        column, settings = self.column(context)
        column.prop(settings, "passes")
        column.prop(settings, "seconds")
        column.prop(settings, "error_goal")
        column.separator()
        column.prop(settings, "seed")


class PHOTONMAP_RENDER_PT_photons(PhotonMapRenderPanel, bpy.types.Panel):
    """Photons of each pass."""

    bl_label = "Photons"

    def draw(self, context: Any) -> None:
        column, settings = self.column(context)
        column.prop(settings, "photons_global", text="Global per Pass")
        column.prop(settings, "photons_caustic", text="Caustic per Pass")
        column.prop(settings, "gather_rays")
        column.separator()
        column.prop(settings, "caustic_radius")
        column.prop(settings, "alpha")


class PHOTONMAP_RENDER_PT_paths(PhotonMapRenderPanel, bpy.types.Panel):
    """How long paths may get."""

    bl_label = "Light Paths"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        column, settings = self.column(context)
        column.prop(settings, "camera_depth")
        column.prop(settings, "photon_depth")
        column.prop(settings, "min_throughput")


class PHOTONMAP_RENDER_PT_film(PhotonMapRenderPanel, bpy.types.Panel):
    """Pixels."""

    bl_label = "Film"

    def draw(self, context: Any) -> None:
        column, settings = self.column(context)
        column.prop(settings, "pixel_filter")
        column.prop(context.scene.render, "filter_size", text="Width")
        column.separator()
        column.prop(context.scene.render, "film_transparent", text="Transparent")


class PHOTONMAP_RENDER_PT_performance(PhotonMapRenderPanel, bpy.types.Panel):
    """Use of the machine."""

    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        column, settings = self.column(context)
        column.prop(settings, "threads")


PANELS = (
    PHOTONMAP_RENDER_PT_sampling,
    PHOTONMAP_RENDER_PT_photons,
    PHOTONMAP_RENDER_PT_paths,
    PHOTONMAP_RENDER_PT_film,
    PHOTONMAP_RENDER_PT_performance,
)
