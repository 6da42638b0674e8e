"""What a scene asks for and does not get: each is said once, with names."""

from __future__ import annotations

from typing import Any

import bpy

from ..report import ExportLog


def warn_object(obj: Any, log: ExportLog) -> None:
    """Say which switches of the object ``obj`` with faces have no effect."""
    name = f"object '{obj.name}'"
    if obj.is_shadow_catcher:
        log.warn_group("shadow catchers are rendered as usual", name)
    if any(system.settings.render_type == "PATH" for system in obj.particle_systems):
        log.warn_group("hair is left out", name)
    warn_linking(obj, log)


def warn_linking(obj: Any, log: ExportLog) -> None:
    """Say that ``obj``, a lamp or a surface, lights more than it was told to."""
    linking = obj.light_linking
    if linking.receiver_collection is not None or linking.blocker_collection is not None:
        log.warn_group("light linking is ignored", f"object '{obj.name}'")


def warn_missing(log: ExportLog) -> None:
    """Say what the file links to and Blender did not find: it is absent from the picture."""
    for library in bpy.data.libraries:
        if library.is_missing:
            log.warn(f"library '{library.filepath}' is missing, what it holds is left out")
    data = bpy.data
    for kind in (data.objects, data.collections, data.meshes, data.materials, data.lights):
        for entry in kind:
            if entry.is_missing:
                log.warn_group("linked data is missing", f"'{entry.name}'")


def warn_scene(scene: Any, layer: Any, log: ExportLog) -> None:
    """Say which switches of the scene and its view layer have no effect."""
    if scene.render.use_motion_blur:
        log.warn(f"scene '{scene.name}': motion blur is not supported yet and ignored")
    off = [
        text
        for flag, text in (("use_sky", "Environment"), ("use_solid", "Surfaces"))
        if not getattr(layer, flag)
    ]
    if off:
        log.warn(
            f"view layer '{layer.name}': the filter that leaves out {' and '.join(off)} is "
            "not supported yet and ignored"
        )
