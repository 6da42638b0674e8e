"""The whole export: a depsgraph in, a frozen ``Scene`` out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...core.scene.builder import SceneBuilder
from ...core.scene.camera_data import CameraData
from ...core.scene.scene import Scene
from ..passes import wanted_aovs
from ..report import ExportError, ExportLog
from .aovs import world_aovs
from .camera import export_camera
from .instances import ExportCancelledError, add_objects
from .materials import MaterialTable
from .memory import ExportMemory
from .unsupported import warn_missing, warn_scene
from .world import mist_of, world_values

__all__ = ["ExportCancelledError", "export_scene", "image_size"]


def export_scene(
    depsgraph: Any,
    engine: Any | None,
    log: ExportLog,
    stopped: Callable[[], bool],
    view: CameraData | None = None,
    memory: ExportMemory | None = None,
) -> Scene:
    """Everything that ``depsgraph`` shows, in world space.

    Reads Blender on the calling thread and keeps no reference to it. ``engine`` supplies
    the camera of the view being rendered; without one (a script) the scene's camera is
    taken, or ``view``. ``memory`` has what an earlier export converted. Raises
    ``ExportError``, ``SceneError``, and ``ExportCancelledError`` once ``stopped()`` is true.
    """
    scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
    camera = engine.camera_override if engine is not None else None
    camera = camera or scene.camera
    if camera is None and view is None:
        raise ExportError(f"scene '{scene.name}' has no camera; add one to render it")
    if engine is not None and scene.render.use_multiview:
        raise ExportError(
            f"scene '{scene.name}' is stereoscopic, only one eye can be rendered yet; turn "
            "Stereoscopy off in the output properties"
        )
    builder = SceneBuilder(scene.name)
    builder.set_camera(view or export_camera(camera, scene, image_size(scene), engine))
    warn_scene(scene, layer, log)
    warn_missing(log)
    builder.set_world(**world_values(layer.world_override or scene.world, log))
    aovs = wanted_aovs(layer)
    builder.set_world_aovs(world_aovs(layer.world_override or scene.world, aovs, log))
    materials = MaterialTable(builder, log, layer.material_override, memory, aovs)
    shown_uv = materials.pictures.show_active() if layer.use_pass_uv else -1
    builder.set_shown(shown_uv, mist_of(layer.world_override or scene.world))
    add_objects(builder, depsgraph, materials, log, stopped, memory)
    if builder.dropped_faces:
        log.warn(f"faces without an area are left out: {builder.dropped_faces}")
    return builder.build()


def image_size(scene: Any) -> tuple[int, int]:
    """Width and height [pixels] of the whole image, rounded as Blender does."""
    render = scene.render
    width = render.resolution_x * render.resolution_percentage // 100
    height = render.resolution_y * render.resolution_percentage // 100
    return max(1, width), max(1, height)
