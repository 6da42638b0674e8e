"""The render settings of the scene."""

from __future__ import annotations

from typing import Any

import bpy

from .panel import PhotonMapPanel
from .presets import PHOTONMAP_PT_sampling_presets


class RenderPanel(PhotonMapPanel):
    """Where the panels of this file live."""

    bl_context = "render"


class PHOTONMAP_RENDER_PT_sampling(RenderPanel, bpy.types.Panel):
    """When a render ends."""

    bl_label = "Sampling"

    def draw_header_preset(self, context: Any) -> None:
        PHOTONMAP_PT_sampling_presets.draw_panel_header(self.layout)

    def draw(self, context: Any) -> None:
        column, settings = self.column(), context.scene.photon_map
        column.prop(settings, "passes")
        column.prop(settings, "seconds")
        column.prop(settings, "error_goal")
        column.prop(settings, "adaptive")
        column.separator()
        draw_denoise(column, settings)
        column.separator()
        column.prop(settings, "viewport_passes")
        column.prop(settings, "seed")


def draw_denoise(column: Any, settings: Any) -> None:
    """The switch, and what is amiss where this Blender cannot do it."""
    from ..denoise import is_available

    able = is_available()
    row = column.row()
    row.active = able
    row.prop(settings, "use_denoise")
    if settings.use_denoise and not able:
        column.label(text="This Blender has no Open Image Denoise", icon="ERROR")


class PHOTONMAP_RENDER_PT_photons(RenderPanel, bpy.types.Panel):
    """How many photons each pass has."""

    bl_label = "Photons"
    bl_parent_id = "PHOTONMAP_RENDER_PT_sampling"

    def draw(self, context: Any) -> None:
        column, settings = self.column(), context.scene.photon_map
        column.prop(settings, "photons_automatic")
        counts = column.column(align=True)
        counts.active = not settings.photons_automatic
        counts.prop(settings, "photons_caustic", text="Caustic")
        counts.prop(settings, "photons_global", text="Global")
        counts.prop(settings, "light_samples")
        counts.prop(settings, "gather_rays")
        column.separator()
        column.prop(settings, "caustic_radius")
        column.prop(settings, "alpha")
        column.separator()
        column.prop(settings, "shadow_photons")
        if settings.shadow_photons:
            shares = column.column(align=True)
            shares.prop(settings, "shadow_lit")
            shares.prop(settings, "shadow_dark")


class PHOTONMAP_RENDER_PT_paths(RenderPanel, bpy.types.Panel):
    """How long paths may get."""

    bl_label = "Light Paths"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        column, settings = self.column(), context.scene.photon_map
        depths = column.column(align=True)
        depths.prop(settings, "camera_depth")
        depths.prop(settings, "photon_depth")
        column.prop(settings, "min_throughput")
        splits = column.column(align=True)
        splits.prop(settings, "split_depth")
        if settings.split_depth:
            splits.prop(settings, "split_least")


class PHOTONMAP_RENDER_PT_film(RenderPanel, bpy.types.Panel):
    """Pixels."""

    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        column, settings = self.column(), context.scene.photon_map
        column.prop(settings, "exposure")
        column.prop(context.scene.render, "film_transparent", text="Transparent")
        column.separator()
        column.prop(settings, "pixel_filter")
        if settings.pixel_filter != "BOX":
            column.prop(context.scene.render, "filter_size", text="Width")


class PHOTONMAP_RENDER_PT_performance(RenderPanel, bpy.types.Panel):
    """Use of the machine; the threads are Blender's, which `blender -t` sets too."""

    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        column, render = self.column(), context.scene.render
        column.prop(render, "threads_mode")
        threads = column.column()
        threads.enabled = render.threads_mode == "FIXED"
        threads.prop(render, "threads")
        column.prop(context.scene.photon_map, "photon_memory")


PANELS = (
    PHOTONMAP_RENDER_PT_sampling,
    PHOTONMAP_RENDER_PT_photons,
    PHOTONMAP_RENDER_PT_paths,
    PHOTONMAP_RENDER_PT_film,
    PHOTONMAP_RENDER_PT_performance,
)
