"""The rendered viewport: a worker renders the view, drawing shows its newest picture.

Blender's data is read in ``ViewportRender.update`` alone, on Blender's thread, and of that
only what changed. Turning the view re-exports nothing: the scene is rendered again with
another camera, by the photons and the mesh that are there. A worker whose
picture nobody wants any more is told so and ends by itself; the next one waits for it.
"""

from __future__ import annotations

import threading
import traceback
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.scene.scene import SceneError
from ..core.settings import SettingsError
from .export.memory import ExportMemory
from .export.scene import export_scene
from .export.settings import export_settings
from .export.view import view_camera, view_key
from .kernel_cache import use_extension_folder
from .report import ExportError, ExportLog

if TYPE_CHECKING:
    from ..core import CameraData, Kept, Scene, Settings, Update

#: The first picture has one pixel for so many by so many of the region's.
COARSE = 4


class Picture(NamedTuple):
    """Pixels (h, w, 4) float32 for drawing, the bottom row first, and a line about them."""

    pixels: NDArray[np.float32] | None
    line: str


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
        self.picture = Picture(None, "Starting")

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
        """A coarse picture at once, then the fine one."""
        camera = self._scene.camera
        assert camera is not None
        small = replace(
            camera, width=max(1, camera.width // COARSE), height=max(1, camera.height // COARSE)
        )
        # One ray each, and no look at where the noise comes from: the picture is there in
        # 0.6 of the time (glass box, 100x100: 225 -> 132 ms).
        coarse = replace(self._settings, passes=1, gather_rays=1)
        yield replace(self._scene, camera=small), coarse
        yield self._scene, self._settings

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
                    self._show(Picture(pixels, line_of(update, settings)))
                elif update.passes == 0 and self.picture.pixels is None:
                    self._show(Picture(None, line_of(update, settings)))
        finally:
            updates.close()

    def _show(self, picture: Picture) -> None:
        if not self._unwanted.is_set():
            self.picture = picture


def line_of(update: Update, settings: Settings) -> str:
    """What the viewport's corner says."""
    if update.passes == 0:
        return update.message or "Rendering"
    parts = [f"Pass {update.passes}/{settings.passes}"]
    if update.passes >= 2 and update.relative_error < float("inf"):
        parts.append(f"Error {100 * update.relative_error:.1f} %")
    return " | ".join(parts)


class ViewportRender:
    """One viewport's scene, worker and drawn picture."""

    def __init__(self) -> None:
        self._memory = ExportMemory()
        self._kept = KeptBox()
        self._scene: Scene | None = None
        self._settings: Settings | None = None
        self._view: tuple[object, ...] = ()
        self._failure = ""
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
            self._scene = export_scene(
                depsgraph, None, ExportLog(), lambda: False, camera, self._memory
            )
            self._settings = viewport_settings(scene)
            self._start(context, camera)
        except (ExportError, SceneError, SettingsError) as error:
            self._fail(str(error))
        except Exception as error:
            traceback.print_exc()
            self._fail(f"{type(error).__name__}: {error}")

    def draw(self, context: Any, depsgraph: Any) -> str:
        """Draw the newest picture; the line to show. A turned view is rendered anew."""
        if self._scene is not None and view_key(context) != self._view:
            self._start(context, view_camera(context, depsgraph.scene_eval))
        picture = self.picture
        if picture.pixels is not None and picture is not self._drawn:
            self._texture, self._drawn = upload(picture.pixels), picture
        if self._texture is not None:
            draw_texture(self._texture, context.region.width, context.region.height)
        self._line = self._failure or picture.line
        return self._line

    @property
    def picture(self) -> Picture:
        """The newest one."""
        return self._worker.picture if self._worker is not None else Picture(None, "")

    def has_news(self) -> bool:
        """Whether there is more to show than was drawn."""
        picture = self.picture
        news = picture.pixels is not None and picture is not self._drawn
        return news or (self._failure or picture.line) != self._line

    def close(self) -> None:
        """Stop rendering; the worker ends within a moment."""
        if self._worker is not None:
            self._worker.cancel()
            self._worker = None
        self._scene = None

    def _fail(self, words: str) -> None:
        self.close()
        self._failure = words

    def _start(self, context: Any, camera: CameraData) -> None:
        assert self._scene is not None and self._settings is not None
        before = self._worker
        if before is not None:
            before.cancel()
        self._view = view_key(context)
        self._worker = Worker(
            replace(self._scene, camera=camera), self._settings, before, self._kept
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
        # Decided once, and for all cameras: so turning the view keeps the photons.
        gather_rays=settings.rays_each,
    )


def upload(pixels: NDArray[np.float32]) -> Any:
    """The picture as a texture of the graphics card."""
    import gpu

    height, width = pixels.shape[:2]
    data = gpu.types.Buffer("FLOAT", pixels.size, np.ascontiguousarray(pixels).ravel())
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)


def draw_texture(texture: Any, width: int, height: int) -> None:
    """Draw ``texture`` over the whole region."""
    from gpu_extras.presets import draw_texture_2d

    draw_texture_2d(texture, (0, 0), width, height)
