"""The Vector pass: the scene in the frames before and after, exported where it is asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .export.scene import export_scene
from .report import ExportLog

if TYPE_CHECKING:
    from ..core import Film, Scene


class Motion(NamedTuple):
    """The scene one frame earlier and one later."""

    before: Scene
    after: Scene

    def vectors(self, film: Film, scene: Scene) -> NDArray[np.float32]:
        """Pixels (h, w, 4), see ``core.camera.motion``."""
        from ..core import motion_vectors

        return motion_vectors(film, scene, self.before, self.after)


def motion_of(engine: Any, depsgraph: Any, stopped: Callable[[], bool]) -> Motion | None:
    """What the Vector pass of ``depsgraph``'s view layer needs, None when it is off.

    Goes to the other frames and comes back: what of Blender's evaluated data was at hand
    before is not valid any more. Raises as ``export_scene``.
    """
    if not depsgraph.view_layer_eval.use_pass_vector or engine.is_preview:
        return None
    scene = depsgraph.scene
    frame, subframe = scene.frame_current, scene.frame_subframe
    found = []
    try:
        for step in (-1, 1):
            engine.frame_set(frame + step, subframe)
            found.append(export_scene(depsgraph, engine, ExportLog(), stopped))
    finally:
        engine.frame_set(frame, subframe)
    return Motion(*found)
