"""What is shown of photons: one pass of one scene, and a place of it that was picked.

Tracing and picking run in a thread that never calls Blender; a timer on Blender's thread
fetches what it has found.
"""

from __future__ import annotations

import threading
import traceback
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import bpy

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ...core import Disc, Scene, Settings, ViewedPass

#: Seconds between two looks at the thread.
WATCH = 0.1
#: Paths that are drawn, those of the photons that weigh most.
MOST_PATHS = 300


class Picked(NamedTuple):
    """A place's discs, rows of their photons whose paths are known, and those paths."""

    discs: tuple[Disc, ...]
    object: str
    rows: NDArray[np.intp]
    paths: list[NDArray[np.float64]]


class Task(threading.Thread):
    """Does one thing after the thing before it."""

    def __init__(self, work: Callable[[], Any], before: Task | None) -> None:
        super().__init__(name="photon_map_photons", daemon=True)
        self._work = work
        self._before = before
        self.result: Any = None
        self.failure = ""

    def run(self) -> None:
        if self._before is not None:
            self._before.join()
            self._before = None
        try:
            self.result = self._work()
        except Exception as error:
            from ...core import SceneError

            if not isinstance(error, SceneError):
                traceback.print_exc()
            self.failure = str(error) or type(error).__name__


class Look:
    """State of the photon view. ``serial`` grows with everything that there is to draw."""

    def __init__(self) -> None:
        self.serial = 0
        self.clear()

    def clear(self) -> None:
        """Show nothing; what a thread still finds is forgotten."""
        self.serial += 1
        self.scene_uid = 0
        self.viewed: ViewedPass | None = None
        self.picked: Picked | None = None
        self.doing = ""
        self.failure = ""
        self.stale = False
        self._task: Task | None = None
        self._then: Callable[[Any], None] = lambda result: None
        redraw()

    def is_on(self, scene: Any) -> bool:
        """Whether photons of ``scene`` are shown, or on their way, or could not be had."""
        return scene is not None and self.scene_uid == scene.session_uid

    def trace(self, uid: int, scene: Scene, settings: Settings, number: int) -> None:
        """Show pass ``number`` of ``scene``, whose number in Blender is ``uid``."""

        def work() -> Any:
            from ...core import ViewedPass

            return ViewedPass(scene, settings, number)

        self.scene_uid, self.stale = uid, False
        self._start("Tracing photons", work, self._show)

    def pick(self, origin: NDArray[np.float64], direction: NDArray[np.float64]) -> None:
        """Show the discs where a ray [world] meets the scene first."""
        viewed = self.viewed
        if viewed is None:
            return
        self._start("Gathering", lambda: pick(viewed, origin, direction), self._show_place)

    def fail(self, uid: int, words: str) -> None:
        """Show ``words`` in place of photons."""
        self.clear()
        self.scene_uid, self.failure = uid, words

    def look(self) -> float | None:
        """Fetch what the thread has found; the seconds until the next look."""
        task = self._task
        if task is None:
            return None
        if task.is_alive():
            return WATCH
        self._task, self.doing, self.failure = None, "", task.failure
        if not task.failure:
            self._then(task.result)
        self.serial += 1
        redraw()
        return None

    def scene_changed(self, scene: Any, depsgraph: Any) -> None:
        """Note that the photons are those of the scene before."""
        if self.viewed is None or not self.is_on(scene) or self.stale:
            return
        self.stale = any(_matters(update) for update in depsgraph.updates)

    def _show(self, viewed: ViewedPass) -> None:
        self.viewed, self.picked = viewed, None

    def _show_place(self, picked: Picked | None) -> None:
        self.picked = picked
        if picked is None:
            self.failure = "There is no surface there"

    def _start(self, doing: str, work: Callable[[], Any], then: Callable[[Any], None]) -> None:
        self.doing, self.failure, self._then = doing, "", then
        self._task = Task(work, self._task)
        self._task.start()
        if not bpy.app.timers.is_registered(watch):
            bpy.app.timers.register(watch, first_interval=WATCH)
        redraw()


def pick(
    viewed: ViewedPass, origin: NDArray[np.float64], direction: NDArray[np.float64]
) -> Picked | None:
    """The discs at the first surface of a ray, and the paths that bring most of their light."""
    import numpy as np

    place = viewed.place_at(origin, direction)
    if place is None:
        return None
    discs = viewed.discs(place)
    rows = np.concatenate([np.zeros(0, np.intp), *(disc.rows for disc in discs)])
    weight = np.concatenate([np.zeros(0), *(disc.weight for disc in discs)])
    light = weight * viewed.view.flux[rows].max(axis=1, initial=0)
    rows = rows[np.argsort(-light, kind="stable")[:MOST_PATHS]]
    return Picked(discs, place.object, rows, viewed.paths(rows))


def _matters(update: Any) -> bool:
    """Whether photons may fly otherwise after ``update``; they know nothing of cameras."""
    thing = update.id
    if isinstance(thing, bpy.types.Scene) or getattr(thing, "type", "") == "CAMERA":
        return False
    return bool(
        update.is_updated_geometry or update.is_updated_transform or update.is_updated_shading
    )


def redraw() -> None:
    """Have every 3D view drawn."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager is not None else ():
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def watch() -> float | None:
    """The timer."""
    return LOOK.look()


LOOK = Look()
