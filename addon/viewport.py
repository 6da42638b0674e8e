"""The rendered viewport: a worker renders the view, drawing shows its newest picture.

Blender's data is read in ``ViewportRender.update`` alone, on Blender's thread, and of that
only what changed. Turning the view re-exports nothing: the scene is rendered again with
another camera, by the photons and the mesh that are there. A worker whose
picture nobody wants any more is told so and ends by itself; the next one waits for it.
"""

from __future__ import annotations

import traceback
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..core.scene.errors import SceneError
from ..core.settings import SettingsError
from .export.memory import ExportMemory
from .export.scene import export_scene
from .export.settings import export_settings
from .export.view import view_border, view_camera, view_key
from .insight import counted, remember_export
from .kernel_cache import use_extension_folder
from .report import ExportError, ExportLog
from .worker import BETWEEN, KeptBox, Picture, Worker

if TYPE_CHECKING:
    from ..core import Scene, Settings

#: Paths worked on at a time: an edit waits for as many. (8192 take a tenth of a second.)
CHUNK = 2048


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
        self._ending: Worker | None = None
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
            self._ending, self._worker = self._worker, None
        self._scene = None

    def is_ending(self) -> bool:
        """Whether the worker of a closed view still runs."""
        return self._ending is not None and self._ending.is_alive()

    def forget(self) -> None:
        """Keep nothing of what was rendered and converted."""
        self._memory, self._kept = ExportMemory(), KeptBox()
        self._ending = self._texture = self._drawn = None

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
