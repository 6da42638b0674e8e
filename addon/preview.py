"""Pictures of materials, lamps and worlds: Blender's little scenes, rendered in a moment."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..core import Scene

#: A preview ends after so many passes, and so long after its first one [s].
PASSES, SECONDS = 16, 1.5
#: The floor's material in pictures as small as icons: cameras do not see it (by a node for
#: kinds of rays), mirrors and glass do.
HIDDEN_FLOOR = "FloorHidden"

#: Set while a preview has not begun after ``LONG`` [s], so that panels can say why: its
#: kernels are being compiled.
LONG = 2.0
WAITING = threading.Event()


def preview_settings() -> dict[str, Any]:
    """Fields of the core's settings for a preview."""
    return {
        "passes": PASSES,
        "seconds": SECONDS,
        "error_goal": 0.0,
        # Decided at once: looking where noise comes from takes longer than it saves here.
        "gather_rays": 1,
        "draft": True,
    }


def preview_scene(scene: Scene) -> Scene:
    """``scene`` with its floor hidden where it is to be."""
    import numpy as np

    from ..core.scene.tables import Visibility

    if HIDDEN_FLOOR not in scene.material_names:
        return scene
    faces = scene.face_material == scene.material_names.index(HIDDEN_FLOOR)
    seen = scene.object_visibility.copy()
    seen[np.unique(scene.face_object[faces])] &= ~int(Visibility.CAMERA)
    return replace(scene, object_visibility=seen)
