"""Photons in the 3D view: where they land, what a gather disc holds, and how they came."""

from __future__ import annotations

import bpy

from . import drawing, operators, panel, properties
from .look import LOOK

#: Blender has other data after these.
_FORGETTING = ("load_pre", "undo_post", "redo_post")


@bpy.app.handlers.persistent
def _forget(*_: object) -> None:
    LOOK.clear()


@bpy.app.handlers.persistent
def _changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    LOOK.scene_changed(scene, depsgraph)


def register() -> None:
    """Register properties, operators, the panel, the drawing and the handlers."""
    properties.register()
    for own in (*operators.CLASSES, *panel.CLASSES):
        bpy.utils.register_class(own)
    panel.join()
    drawing.start()
    for name in _FORGETTING:
        getattr(bpy.app.handlers, name).append(_forget)
    bpy.app.handlers.depsgraph_update_post.append(_changed)


def unregister() -> None:
    """Leave nothing behind."""
    bpy.app.handlers.depsgraph_update_post.remove(_changed)
    for name in _FORGETTING:
        getattr(bpy.app.handlers, name).remove(_forget)
    LOOK.clear()
    drawing.stop()
    panel.leave()
    for own in reversed((*operators.CLASSES, *panel.CLASSES)):
        bpy.utils.unregister_class(own)
    properties.unregister()
