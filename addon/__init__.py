"""The Blender add-on: everything that imports ``bpy``, and no light transport.

Importing and registering it loads neither numba, scipy nor embreex: those come with the
first render.
"""

from __future__ import annotations

import bpy

from . import baking, insight, operators, photon_view, properties, ui
from .engine import PhotonMapEngine
from .export import memory


def register() -> None:
    """Register properties, operators, panels and the engine."""
    properties.register()
    operators.register()
    ui.register()
    baking.register()
    photon_view.register()
    insight.register()
    memory.register()
    bpy.utils.register_class(PhotonMapEngine)


def unregister() -> None:
    """Undo ``register`` in reverse order."""
    bpy.utils.unregister_class(PhotonMapEngine)
    memory.unregister()
    insight.unregister()
    photon_view.unregister()
    baking.unregister()
    ui.unregister()
    operators.unregister()
    properties.unregister()


def is_registered() -> bool:
    """Whether Blender knows the engine, from this package or from an installed extension."""
    return any(
        getattr(engine, "bl_idname", "") == PhotonMapEngine.bl_idname and engine.is_registered
        for engine in bpy.types.RenderEngine.__subclasses__()
    )
