"""The rendered viewport: a worker renders the view, drawing shows its newest picture.

Blender's data is read in ``ViewportRender.update`` alone, on Blender's thread, and of that
only what changed. Turning the view re-exports nothing: the scene is rendered again with
another camera, by the photons and the mesh that are there. A worker whose
picture nobody wants any more is told so and ends by itself; the next one waits for it.
"""

from __future__ import annotations

import math
import threading
import traceback
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.scene.errors import SceneError
from ..core.settings import AUTOMATIC, SettingsError
from .export.memory import ExportMemory
from .export.scene import export_scene
from .export.settings import export_settings
from .export.view import view_border, view_camera, view_key
from .insight import counted, remember_export
from .kernel_cache import use_extension_folder
from .report import ExportError, ExportLog

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
#: Paths worked on at a time: an edit waits for as many. (8192 take a tenth of a second.)
CHUNK = 2048


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


class ViewportRender:
    """One viewport's scene, worker and drawn picture."""

    def __init__(self) -> None:
        self._memory = ExportMemory()
        self._kept = KeptBox()
        self._scene: Scene | None = None
        self._settings: Settings | None = None
        self._view: tuple[object, ...] = ()
        self._failure = ""
        self._warnings: tuple[str, ...] = ()
        self._worker: Worker | None = None
        self._texture: Any = None
        self._drawn: Picture | None = None
        self._line = ""

    def update(self, context: Any, depsgraph: Any) -> None:
        """Read the scene as it is now, and render it."""
        use_extension_folder()
        self._failure = ""
        try:
            scene = depsgraph.scene_eval
            camera = view_camera(context, scene)
            self._memory.forget_changes(depsgraph)
            log = ExportLog()
            self._scene = export_scene(
                depsgraph, None, log, lambda: False, camera, self._memory
            )
            self._warnings = log.messages
            remember_export(depsgraph.scene, log.messages)
            self._settings = viewport_settings(scene)
            self._start(context, scene)
        except (ExportError, SceneError, SettingsError) as error:
            self._fail(str(error))
        except Exception as error:
            traceback.print_exc()
            self._fail(f"{type(error).__name__}: {error}")

    def draw(self, context: Any, depsgraph: Any) -> str:
        """Draw the newest picture; the line to show. A turned view is rendered anew."""
        try:
            self._draw(context, depsgraph.scene_eval)
        except (SceneError, SettingsError) as error:  # a view that cannot be rendered
            self._fail(str(error))
        except Exception as error:  # once: it would come again with every drawing
            traceback.print_exc()
            self._texture = None
            self._fail(f"{type(error).__name__}: {error}")
        self._line = self.line or self._line
        return self._line

    def _draw(self, context: Any, scene: Any) -> None:
        if self._scene is not None and view_key(context, scene) != self._view:
            self._start(context, scene)
        picture = self.picture
        if picture.pixels is not None and self._is_new(picture):
            self._texture, self._drawn = upload(picture.pixels), picture
        if self._texture is not None and self._drawn is not None:
            size = (context.region.width, context.region.height)
            draw_texture(self._texture, self._drawn.place, size)

    @property
    def picture(self) -> Picture:
        """The newest one."""
        return self._worker.picture if self._worker is not None else Picture(None, "")

    @property
    def line(self) -> str:
        """What the corner has to say: a failure, else of the picture and of the export."""
        line = self._failure or self.picture.line
        if line and self._warnings and not self._failure:
            line += f"{BETWEEN}{counted(self._warnings)}: see Render Properties"
        return line

    def has_news(self) -> bool:
        """Whether there is more to show than was drawn."""
        line = self.line
        return self._is_new(self.picture) or bool(line and line != self._line)

    def _is_new(self, picture: Picture) -> bool:
        """Whether its pixels are others than those that were drawn."""
        drawn = self._drawn
        return picture.pixels is not None and (
            drawn is None or picture.pixels is not drawn.pixels
        )

    def close(self) -> None:
        """Stop rendering; the worker ends within a moment."""
        if self._worker is not None:
            self._worker.cancel()
            self._worker = None
        self._scene = None

    def _fail(self, words: str) -> None:
        self.close()
        self._failure = words

    def _start(self, context: Any, scene: Any) -> None:
        assert self._scene is not None and self._settings is not None
        before = self._worker
        if before is not None:
            before.cancel()
        self._view = view_key(context, scene)
        self._worker = Worker(
            replace(self._scene, camera=view_camera(context, scene)),
            replace(self._settings, region=view_border(context, scene)),
            before,
            self._kept,
        )
        self._worker.start()


def viewport_settings(scene: Any) -> Settings:
    """Settings of ``scene`` for a viewport, which leaves one processor to Blender."""
    settings = export_settings(
        scene, {"passes": scene.photon_map.viewport_passes, "region": None, "seconds": 0.0}
    )
    return replace(
        settings,
        threads=settings.threads or max(1, settings.thread_count - 1),
        chunk_size=min(settings.chunk_size, CHUNK),
        # Decided once, and for all cameras: so turning the view keeps the photons.
        learn_aim=False,
        gather_rays=settings.rays_each,
    )


def upload(pixels: NDArray[np.float32]) -> Any:
    """The picture as a texture of the graphics card."""
    import gpu

    height, width = pixels.shape[:2]
    data = gpu.types.Buffer("FLOAT", pixels.size, np.ascontiguousarray(pixels).ravel())
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)


def draw_texture(
    texture: Any, place: tuple[float, float, float, float], size: tuple[int, int]
) -> None:
    """Draw ``texture`` over ``place`` of a region of ``size`` pixels."""
    from gpu_extras.presets import draw_texture_2d

    x0, y0, x1, y1 = (part * extent for part, extent in zip(place, (*size, *size), strict=True))
    draw_texture_2d(texture, (x0, y0), x1 - x0, y1 - y0)
