"""Show the photons, hide them, and pick the place whose gather discs are shown."""

# No "from __future__ import annotations" here: Blender reads the annotations as properties.
from dataclasses import replace
from typing import Any

import bpy
from bpy.props import IntVectorProperty

from ...core.scene.errors import SceneError
from ...core.settings import SettingsError
from ..baking import maps_path
from ..operators import exported
from ..report import ExportError
from ..ui.panel import ENGINE
from .look import LOOK

OTHER_ENGINE = "The render engine is not Photon Map"
NO_SCENE = "There is no scene"


def obstacle(context: Any) -> str:
    """Why no photons can be shown, in words; "" when they can."""
    if not context.scene:
        return NO_SCENE
    return "" if context.scene.render.engine == ENGINE else OTHER_ENGINE


class PhotonOperator(bpy.types.Operator):
    """What the operators have in common."""

    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        words = obstacle(context)
        if words:
            cls.poll_message_set(words)
        return not words


def show(operator: bpy.types.Operator, context: Any) -> set[str]:
    """Begin to trace the photons that were chosen."""
    own = context.window_manager.photon_map_photons
    uid = context.scene.session_uid
    try:
        scene, settings = exported(context)
        if own.source == "BAKED":
            path = maps_path()
            if path is None or not path.is_file():
                raise ExportError("no photon maps are baked beside the file")
            settings = replace(settings, photon_maps=str(path))
    except (ExportError, SceneError, SettingsError, ImportError) as error:
        LOOK.fail(uid, str(error))
        operator.report({"ERROR"}, f"Photon Map: {error}")
        return {"CANCELLED"}
    LOOK.trace(uid, scene, settings, own.number)
    return {"FINISHED"}


class PHOTONMAP_OT_trace_photons(PhotonOperator):
    """Trace the photons of one pass, of the scene as it is now, and show where they land"""

    bl_idname = "photon_map.trace_photons"
    bl_label = "Show Photons"

    def execute(self, context: Any) -> set[str]:
        return show(self, context)


class PHOTONMAP_OT_toggle_photons(PhotonOperator):
    """Show where photons land, or show them no more"""

    bl_idname = "photon_map.toggle_photons"
    bl_label = "Photons"

    def execute(self, context: Any) -> set[str]:
        if LOOK.is_on(context.scene):
            LOOK.clear()
            return {"FINISHED"}
        return show(self, context)


class PHOTONMAP_OT_pick_photons(PhotonOperator):
    """Click on a surface to see its gather discs, their photons and the ways these came"""

    bl_idname = "photon_map.pick_photons"
    bl_label = "Pick a Place"

    place: IntVectorProperty(  # type: ignore[valid-type]
        size=2, options={"HIDDEN", "SKIP_SAVE"}, description="Pixel of the 3D view's region"
    )

    @classmethod
    def poll(cls, context: Any) -> bool:
        if not super().poll(context):
            return False
        if LOOK.viewed is None or not LOOK.is_on(context.scene):
            cls.poll_message_set("No photons are shown")
            return False
        return context.area is not None and context.area.type == "VIEW_3D"

    def invoke(self, context: Any, event: Any) -> set[str]:
        context.window.cursor_modal_set("EYEDROPPER")
        context.workspace.status_text_set("Click on a surface  |  Right button: cancel")
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Any, event: Any) -> set[str]:
        if event.type in {"RIGHTMOUSE", "ESC"}:
            self._end(context)
            return {"CANCELLED"}
        if event.type != "LEFTMOUSE" or event.value != "PRESS":
            return {"PASS_THROUGH"}
        self._end(context)
        region = view_under(context.area, event.mouse_x, event.mouse_y)
        if region is None:
            return {"CANCELLED"}
        return self._pick(region, event.mouse_x - region.x, event.mouse_y - region.y)

    def execute(self, context: Any) -> set[str]:
        area = context.area
        region = next(region for region in area.regions if region.type == "WINDOW")
        return self._pick(region, *self.place)

    def _pick(self, region: Any, x: int, y: int) -> set[str]:
        import numpy as np
        from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d

        view = region.data
        origin = region_2d_to_origin_3d(region, view, (x, y))
        direction = region_2d_to_vector_3d(region, view, (x, y))
        LOOK.pick(np.array(origin, np.float64), np.array(direction, np.float64))
        return {"FINISHED"}

    def _end(self, context: Any) -> None:
        context.window.cursor_modal_restore()
        context.workspace.status_text_set(None)


def view_under(area: Any, x: int, y: int) -> Any | None:
    """The region of a 3D view's ``area`` under a place of the window; None beside them.

    A sidebar lies over the view and is no part of it.
    """
    found = None
    for region in area.regions:
        inside = 0 <= x - region.x < region.width and 0 <= y - region.y < region.height
        if inside and region.type == "WINDOW":
            found = region
        elif inside and region.type in {"UI", "TOOLS", "HEADER", "TOOL_HEADER"}:
            return None
    return found


CLASSES = (
    PHOTONMAP_OT_trace_photons,
    PHOTONMAP_OT_toggle_photons,
    PHOTONMAP_OT_pick_photons,
)
