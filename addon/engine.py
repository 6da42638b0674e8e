"""The render engine as Blender sees it: attributes and callbacks, nothing else."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

import bpy

from .passes import register_passes
from .report import ExportError, guarded

#: Seconds between two looks at a viewport's worker.
WATCH = 0.02


class PhotonMapEngine(bpy.types.RenderEngine):
    """Renders with ``photon_map.core``; one object lives for one render of one frame."""

    bl_idname = "PHOTONMAP"
    bl_label = "Photon Map"
    bl_use_preview = True
    bl_use_postprocess = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.failure = ""
        self.failure_shown = False
        self.viewport: Any = None

    def __del__(self) -> None:
        viewport = getattr(self, "viewport", None)
        if viewport is not None:
            viewport.close()
        parent = getattr(super(), "__del__", None)  # since 4.4
        if parent is not None:
            parent()

    def update_render_passes(self, scene: Any = None, renderlayer: Any = None) -> None:
        """Tell Blender the passes of a view layer, for its compositor and its files."""
        with guarded(self):
            register_passes(self, scene, renderlayer)

    def render(self, depsgraph: Any) -> None:
        """Render one view layer of one frame, unless an earlier one failed."""
        if self.failure_shown:
            return
        with guarded(self):
            if self.failure:  # Blender drops what was reported before this callback
                raise ExportError(self.failure)
            from .final import render_final

            render_final(self, depsgraph)
        self.failure_shown = bool(self.failure)

    def view_update(self, context: Any, depsgraph: Any) -> None:
        """Something in the scene of a rendered viewport has changed."""
        if self.viewport is None:
            from .viewport import ViewportRender

            self.viewport = ViewportRender()
            bpy.app.timers.register(watch(weakref.ref(self)), first_interval=WATCH)
        self.viewport.update(context, depsgraph)

    def view_draw(self, context: Any, depsgraph: Any) -> None:
        """Draw what is there of a rendered viewport."""
        if self.viewport is None:
            return
        import gpu

        gpu.state.blend_set("ALPHA_PREMULT")
        self.bind_display_space_shader(depsgraph.scene_eval)
        line = self.viewport.draw(context, depsgraph)
        self.unbind_display_space_shader()
        gpu.state.blend_set("NONE")
        self.update_stats("", line)


def watch(engine: weakref.ref[PhotonMapEngine]) -> Callable[[], float | None]:
    """A timer that has the viewport drawn when its worker has something new.

    Workers may not call Blender: the engine could be freed meanwhile.
    """

    def look() -> float | None:
        found = engine()
        if found is None or found.viewport is None:
            return None
        if found.viewport.has_news():
            found.tag_redraw()
        return WATCH

    return look
