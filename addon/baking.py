"""Baked photon maps in Blender: bake them beside the file, and take them in final renders."""

# No "from __future__ import annotations" here: Blender reads the annotations as properties.
from pathlib import Path
from typing import Any

import bpy
from bpy.props import EnumProperty, IntProperty, PointerProperty

from ..core.scene.errors import SceneError
from ..core.settings import MAPS_SUFFIX
from .job import Job, running
from .kernel_cache import use_extension_folder
from .ui.panel import ENGINE, PhotonMapPanel

#: Baked maps are not looked for.
IGNORE = "IGNORE"


class PhotonMapBakingProperties(bpy.types.PropertyGroup):
    """What final renders do about baked photon maps; at ``Scene.photon_map_baking``."""

    stale: EnumProperty(  # type: ignore[valid-type]
        name="Baked Maps",
        description="Photon maps beside the file are used while only the camera changes; "
        "this is done when something else has changed",
        items=(
            ("TRACE", "Trace if Stale", "Trace the photons as without maps, and warn", 0),
            (
                "REBUILD",
                "Bake if Stale",
                "Bake them again before the render, as missing ones",
                1,
            ),
            ("REFUSE", "Refuse if Stale", "Do not render, and say what has changed", 2),
            (IGNORE, "Ignore", "Trace photons always", 3),
        ),
        default="TRACE",
    )
    passes: IntProperty(  # type: ignore[valid-type]
        name="Passes",
        description="Passes whose photons are baked, rounded up to a multiple of 4; a render "
        "with more passes uses them again",
        default=64,
        min=1,
        max=65_536,
    )


def maps_path() -> Path | None:
    """Where the maps of the open file lie; None for one that was never saved."""
    return Path(bpy.data.filepath).with_suffix(MAPS_SUFFIX) if bpy.data.filepath else None


def maps_settings(scene: Any) -> dict[str, str]:
    """Fields of ``Settings`` for a final render of ``scene``."""
    stale = scene.photon_map_baking.stale
    path = maps_path()
    if stale == IGNORE or path is None or not (path.is_file() or stale == "REBUILD"):
        return {}
    return {"photon_maps": str(path), "stale_maps": stale}


class PHOTONMAP_OT_bake(bpy.types.Operator):
    """Trace the photons once and keep them beside the file, for renders from any camera.

    The scene is exported as for a final render, which clears the last render's image"""

    bl_idname = "photon_map.bake"
    bl_label = "Bake Photon Maps"

    @classmethod
    def poll(cls, context: Any) -> bool:
        return bool(context.scene) and context.engine == ENGINE

    def execute(self, context: Any) -> set[str]:
        path = maps_path()
        if path is None:
            self.report({"ERROR"}, "Photon Map: save the file first, its maps lie beside it")
            return {"CANCELLED"}
        job = Job(export_only=True)
        try:
            with running(job):
                bpy.ops.render.render(scene=context.scene.name)
            if job.scene is None or job.settings is None:
                raise RuntimeError("no view layer is enabled for rendering")
            header = self._bake(context, job, path)
        except (SceneError, ImportError, OSError, RuntimeError) as error:
            self.report({"ERROR"}, f"Photon Map: {job.failure or error}")
            return {"CANCELLED"}
        stored = sum(map(sum, header.stored))
        size = path.stat().st_size / 1e6
        told = f"{header.passes} passes, {stored} photons, {size:.1f} MB: {path.name}"
        self.report({"INFO"}, told)
        return {"FINISHED"}

    def _bake(self, context: Any, job: Job, path: Path) -> Any:
        use_extension_folder()
        from ..core import bake

        manager = context.window_manager
        passes = context.scene.photon_map_baking.passes
        manager.progress_begin(0, passes)
        try:
            assert job.scene is not None and job.settings is not None  # execute has looked
            return bake(job.scene, job.settings, path, passes, manager.progress_update)
        finally:
            manager.progress_end()


class PHOTONMAP_RENDER_PT_baking(PhotonMapPanel, bpy.types.Panel):
    """Photon maps in a file."""

    bl_label = "Baked Photon Maps"
    bl_context = "render"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        column, own = self.column(), context.scene.photon_map_baking
        column.prop(own, "stale")
        column.prop(own, "passes")
        column.operator(PHOTONMAP_OT_bake.bl_idname)
        path = maps_path()
        if path is not None:
            found = "lie beside the file" if path.is_file() else "are not baked yet"
            column.label(text=f"{path.name}: they {found}")


CLASSES = (PhotonMapBakingProperties, PHOTONMAP_OT_bake, PHOTONMAP_RENDER_PT_baking)


def register() -> None:
    """Register the operator, its panel and its properties."""
    for own in CLASSES:
        bpy.utils.register_class(own)
    bpy.types.Scene.photon_map_baking = PointerProperty(type=PhotonMapBakingProperties)


def unregister() -> None:
    """Undo it."""
    del bpy.types.Scene.photon_map_baking
    for own in reversed(CLASSES):
        bpy.utils.unregister_class(own)
