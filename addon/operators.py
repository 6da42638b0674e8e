"""What the user can ask: what the scene needs, and why an object has no caustic."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

from ..core.scene.errors import SceneError
from ..core.settings import SettingsError
from .insight import remember
from .kernel_cache import use_extension_folder
from .report import ExportError, ExportLog
from .ui.object import SURFACES
from .ui.panel import ENGINE

if TYPE_CHECKING:
    from ..core import Scene, Settings

NOTHING_FOUND = (
    "Nothing stands in its way. Its caustic may be faint beside other light, lie out of the "
    "picture, or need more passes"
)


def exported(context: Any) -> tuple[Scene, Settings]:
    """The scene as the viewport has it, with its plan remembered; raises as the export does."""
    use_extension_folder()
    from ..core import Plan
    from .export.scene import export_scene
    from .export.settings import export_settings

    log = ExportLog()
    depsgraph = context.evaluated_depsgraph_get()
    scene = export_scene(depsgraph, None, log, lambda: False)
    settings = export_settings(context.scene, {})
    remember(context.scene, Plan.of(scene, settings), log.messages)
    return scene, settings


def object_of(context: Any) -> Any:
    """The object of the properties editor, which may be pinned; else the active one."""
    return getattr(context, "object", None) or context.view_layer.objects.active


def redraw(context: Any) -> None:
    """Show the answer in every properties editor."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "PROPERTIES":
                area.tag_redraw()


class Question(bpy.types.Operator):
    """An operator that exports the scene and tells something about it."""

    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.scene) and context.engine == ENGINE

    def execute(self, context: Any) -> set[str]:
        try:
            scene, settings = exported(context)
            self.answer(context, scene, settings)
        except (ExportError, SceneError, SettingsError, ImportError) as error:
            self.report({"ERROR"}, f"Photon Map: {error}")
            return {"CANCELLED"}
        redraw(context)
        return {"FINISHED"}

    def answer(self, context: Any, scene: Scene, settings: Settings) -> None:
        """Tell it."""


class PHOTONMAP_OT_plan(Question):
    """Look at the scene and say what a render will do, and what it will leave out"""

    bl_idname = "photon_map.plan"
    bl_label = "Look at the Scene"


class PHOTONMAP_OT_why_no_caustic(Question):
    """Name what keeps the active object from casting a caustic"""

    bl_idname = "photon_map.why_no_caustic"
    bl_label = "Why Is There No Caustic?"

    @classmethod
    def poll(cls, context: Any) -> bool:
        obj = object_of(context)
        return bool(super().poll(context)) and obj is not None and obj.type in SURFACES

    def answer(self, context: Any, scene: Scene, settings: Settings) -> None:
        from ..core import why_no_caustic

        obj = object_of(context)
        lines = [
            f"{finding.cause.capitalize()}: {finding.words}"
            for finding in why_no_caustic(scene, settings, obj.name)
        ]
        if obj.hide_render:
            lines.insert(0, "Not rendered: it is disabled for renders")
        obj.photon_map.answer = "\n".join(lines or [NOTHING_FOUND])
        for line in lines or [NOTHING_FOUND]:
            self.report({"INFO"}, f"'{obj.name}': {line}")


CLASSES = (PHOTONMAP_OT_plan, PHOTONMAP_OT_why_no_caustic)


def register() -> None:
    """Register the operators."""
    for operator in CLASSES:
        bpy.utils.register_class(operator)


def unregister() -> None:
    """Unregister them."""
    for operator in reversed(CLASSES):
        bpy.utils.unregister_class(operator)
