"""What renders a view of a viewport: a coarse picture at once, then finer ones."""

from __future__ import annotations

import math
import threading
import traceback
from collections.abc import Iterator
from concurrent.futures import CancelledError
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.settings import AUTOMATIC

if TYPE_CHECKING:
    from ..core import CameraData, Kept, Scene, Settings, Update

#: Pixels of the first picture, at most: as many as one processor renders in 40 ms.
FIRST_PIXELS = 8192
#: Photons of each kind in it, at most.
FIRST_PHOTONS = 4096
#: Seconds before the corner says what a render is at: each word draws the whole view anew.
QUIET = 1.0
#: Stands between the parts of that line.
BETWEEN = " | "
#: Each picture has at most so many times as many pixels a side as the one before.
FINER = 4


class Picture(NamedTuple):
    """Pixels (h, w, 4) float32 for drawing, the bottom row first, and a line about them.

    ``place``: the part of the region that they show, (left, low, right, high) from 0 to 1.
    """

    pixels: NDArray[np.float32] | None
    line: str
    place: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0)


class KeptBox:
    """What the renders of one viewport leave to each other; workers take turns."""

    def __init__(self) -> None:
        self._kept: Kept | None = None

    def cancel(self) -> None:
        """Have the render that uses it end at its next ray."""
        if self._kept is not None:
            self._kept.cancel()

    def get(self) -> Kept:
        """Made by the first worker: its import takes Numba."""
        if self._kept is None:
            from ..core import Kept

            self._kept = Kept()
        return self._kept


class Worker(threading.Thread):
    """Renders one view until it is done or unwanted."""

    def __init__(
        self, scene: Scene, settings: Settings, before: Worker | None, kept: KeptBox
    ) -> None:
        super().__init__(name="photon_map_viewport", daemon=True)
        self._kept = kept
        self._scene, self._settings = scene, settings
        self._before = before
        self._unwanted = threading.Event()
        self.picture = Picture(None, "")

    def cancel(self) -> None:
        """Have it end; does not wait."""
        self._unwanted.set()
        # Its loop would see that at the next update, a tenth of a second later at worst.
        self._kept.cancel()

    def run(self) -> None:
        try:
            if self._before is not None:
                self._before.join()
                self._before = None
            for scene, settings in self._stages():
                self._render(scene, settings)
        except Exception as error:
            traceback.print_exc()
            self._show(Picture(None, f"Failed: {error}"))

    def _stages(self) -> Iterator[tuple[Scene, Settings]]:
        """A coarse picture at once, finer ones, then the whole one."""
        camera, settings = self._scene.camera, self._settings
        assert camera is not None
        # One ray each, and no look at where the noise comes from or surfaces cross.
        draft = replace(
            settings,
            passes=1,
            gather_rays=1,
            draft=True,
            photons_caustic=fewer(settings.photons_caustic),
            photons_global=fewer(settings.photons_global),
        )
        region = settings.region or (0, 0, camera.width, camera.height)
        for step in steps((region[2] - region[0]) * (region[3] - region[1])):
            small = replace(
                camera, width=max(1, camera.width // step), height=max(1, camera.height // step)
            )
            part = settings.region and shrunk(settings.region, camera, small)
            yield replace(self._scene, camera=small), replace(draft, region=part)
        yield self._scene, settings

    def _render(self, scene: Scene, settings: Settings) -> None:
        if self._unwanted.is_set():
            return
        from ..core import render

        updates: Any = render(scene, settings, self._kept.get())
        shown = 0
        try:
            for update in updates:
                if self._unwanted.is_set():
                    return
                if update.passes > shown:
                    shown = update.passes
                    pixels = update.film.resolve("combined")
                    place = place_of(scene.camera, settings)
                    self._show(Picture(pixels, line_of(update, settings), place))
                elif update.passes == 0 and update.setup_seconds > QUIET:
                    self._say(update.message or "Rendering")
        except CancelledError as error:
            if not self._unwanted.is_set():
                raise
            # Its frames hold the scene, and are held by futures of theirs.
            traceback.clear_frames(error.__traceback__)
        finally:
            updates.close()

    def _say(self, doing: str) -> None:
        """Show what is done, behind the line of a picture that is there."""
        picture = self.picture
        coarse = picture.line.split(BETWEEN)[0]
        line = doing if picture.pixels is None else f"{coarse}{BETWEEN}{doing}"
        if line != picture.line:
            self._show(picture._replace(line=line))

    def _show(self, picture: Picture) -> None:
        if not self._unwanted.is_set():
            self.picture = picture


def fewer(photons: int) -> int:
    """Photons of the first picture, of a setting for them."""
    return FIRST_PHOTONS if photons == AUTOMATIC else min(photons, FIRST_PHOTONS)


def steps(pixels: int) -> Iterator[int]:
    """Pixels a side that one pixel of each coarse picture stands for."""
    step = max(2, math.ceil(math.sqrt(pixels / FIRST_PIXELS)))
    while step > 1:
        yield step
        step //= FINER


def shrunk(
    region: tuple[int, int, int, int], camera: CameraData, small: CameraData
) -> tuple[int, int, int, int]:
    """The pixels of ``small`` that touch ``region`` of ``camera``."""
    x, y = small.width / camera.width, small.height / camera.height
    return (
        int(region[0] * x),
        int(region[1] * y),
        min(small.width, math.ceil(region[2] * x)),
        min(small.height, math.ceil(region[3] * y)),
    )


def place_of(
    camera: CameraData | None, settings: Settings
) -> tuple[float, float, float, float]:
    """The part of the view that a render shows."""
    if settings.region is None or camera is None:
        return 0.0, 0.0, 1.0, 1.0
    x0, y0, x1, y1 = settings.region
    return x0 / camera.width, y0 / camera.height, x1 / camera.width, y1 / camera.height


def line_of(update: Update, settings: Settings) -> str:
    """What the viewport's corner says."""
    if update.passes == 0:
        return update.message or "Rendering"
    parts = [f"Pass {update.passes}/{settings.passes}"]
    if update.passes >= 2 and update.relative_error < float("inf"):
        parts.append(f"Error {100 * update.relative_error:.1f} %")
    return BETWEEN.join(parts)
