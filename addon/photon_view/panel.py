"""The panel in the 3D view's sidebar, and the switch among its overlays."""

from __future__ import annotations

from typing import Any

import bpy

from ..ui.plan import draw_text
from .look import LOOK
from .operators import (
    PHOTONMAP_OT_pick_photons,
    PHOTONMAP_OT_toggle_photons,
    PHOTONMAP_OT_trace_photons,
    obstacle,
)

#: Lines of a legend.
_NAMED = 6


class PHOTONMAP_VIEW3D_PT_photons(bpy.types.Panel):
    """Photons of a pass."""

    bl_label = "Photons"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Photon Map"

    def draw(self, context: Any) -> None:
        layout: Any = self.layout
        words = obstacle(context)
        if words:
            draw_text(layout, context, words, "INFO")
            return
        own = context.window_manager.photon_map_photons
        layout.use_property_split = True
        layout.use_property_decorate = False
        on = LOOK.is_on(context.scene)
        row = layout.row(align=True)
        row.operator(
            PHOTONMAP_OT_toggle_photons.bl_idname,
            text="Hide Photons" if on else "Show Photons",
            depress=on,
        )
        if on:
            row.operator(PHOTONMAP_OT_trace_photons.bl_idname, text="", icon="FILE_REFRESH")
        layout.prop(own, "source")
        layout.prop(own, "number")
        column = layout.column()
        column.prop(own, "kind")
        column.prop(own, "colour")
        column.prop(own, "size")
        column.prop(own, "in_front")
        if on:
            _draw_state(layout, context)


class PHOTONMAP_VIEW3D_PT_disc(bpy.types.Panel):
    """A picked place's gather discs."""

    bl_label = "Gather Disc"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Photon Map"
    bl_parent_id = "PHOTONMAP_VIEW3D_PT_photons"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return LOOK.is_on(context.scene) and not obstacle(context)

    def draw(self, context: Any) -> None:
        layout: Any = self.layout
        layout.operator(PHOTONMAP_OT_pick_photons.bl_idname, icon="EYEDROPPER")
        layout.prop(context.window_manager.photon_map_photons, "paths")
        for line in lines_of_place():
            draw_text(layout, context, line)


def _draw_state(layout: Any, context: Any) -> None:
    if LOOK.doing:
        draw_text(layout, context, f"{LOOK.doing}; the first time takes a minute", "TIME")
    if LOOK.failure:
        draw_text(layout, context, LOOK.failure, "ERROR")
    if LOOK.stale:
        draw_text(layout, context, "The scene has changed since", "FILE_REFRESH")
    if LOOK.viewed is not None:
        view = LOOK.viewed.view
        caustic = int(view.caustic.sum())
        words = f"{caustic} caustic and {len(view.caustic) - caustic} global photons"
        draw_text(layout, context, words)


def lines_of_place() -> list[str]:
    """The numbers of the picked place's discs."""
    viewed, picked = LOOK.viewed, LOOK.picked
    if viewed is None or picked is None:
        return []
    from ...core import photon_legend

    lines = [f"On '{picked.object}'"]
    for disc in picked.discs:
        kind = "Caustic" if disc.caustic else "Global"
        light = ", ".join(f"{value:.3g}" for value in disc.irradiance)
        lines.append(f"{kind}: {len(disc.rows)} photons, radius {disc.radius:.3g} m")
        lines.append(f"Irradiance {light} W/m²")
        view = viewed.view.only(disc.rows)
        for by in ("light", "caster"):
            for entry in photon_legend(view, by, disc.weight)[:_NAMED]:
                share = f"{100 * entry.share:.0f} %"
                lines.append(f"  {entry.number} ({share}) by {by} {entry.name}")
    return lines


def draw_switch(self: Any, context: Any) -> None:
    """A line among the overlays, for this engine's scenes."""
    if not obstacle(context):
        on = LOOK.is_on(context.scene)
        self.layout.operator(PHOTONMAP_OT_toggle_photons.bl_idname, depress=on)


CLASSES = (PHOTONMAP_VIEW3D_PT_photons, PHOTONMAP_VIEW3D_PT_disc)


def join() -> None:
    """Add the switch to Blender's overlays."""
    bpy.types.VIEW3D_PT_overlay.append(draw_switch)


def leave() -> None:
    """Take it away."""
    bpy.types.VIEW3D_PT_overlay.remove(draw_switch)
