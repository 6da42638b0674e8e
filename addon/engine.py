"""The render engine as Blender sees it: attributes and callbacks, nothing else."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import bpy

from .passes import register_passes
from .report import ExportError, guarded

if TYPE_CHECKING:
    from .viewport import ViewportRender

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
            from .allocator import give_back
            from .final import render_final

            render_final(self, depsgraph)
            if not self.is_preview:
                give_back()
        self.failure_shown = bool(self.failure)

    def view_update(self, context: Any, depsgraph: Any) -> None:
        """Something in the scene of a rendered viewport has changed."""
        if self.viewport is None:
            from .viewport import ViewportRender

            self.viewport = ViewportRender()
            # Not ``__del__``: Blender has taken the engine away by then, and Python knows no
            # attribute of it any more.
            weakref.finalize(self, self.viewport.close)
            look = watch(weakref.ref(self), self.viewport)
            bpy.app.timers.register(look, first_interval=WATCH)
        self.viewport.update(context, depsgraph)

    def view_draw(self, context: Any, depsgraph: Any) -> None:
        """Draw what is there of a rendered viewport."""
        if self.viewport is None:
            return
        import gpu

        gpu.state.blend_set("ALPHA_PREMULT")
        self.bind_display_space_shader(depsgraph.scene_eval)
        try:
            line = self.viewport.draw(context, depsgraph)
        finally:
            self.unbind_display_space_shader()
            gpu.state.blend_set("NONE")
        self.update_stats("", line)


def watch(
    engine: weakref.ref[PhotonMapEngine], viewport: ViewportRender
) -> Callable[[], float | None]:
    """A timer that has ``viewport`` drawn when its worker has something new.

    Workers may not call Blender: the engine could be freed meanwhile. Where Python has kept
    what Blender has freed, the timer ends the worker. At last it gives back their memory.
    """

    def look() -> float | None:
        from .allocator import give_back

        found = engine()
        try:
            if found is not None:
                if viewport.has_news():
                    found.tag_redraw()
                return WATCH
        except ReferenceError:
            viewport.close()
        if viewport.is_ending():
            return WATCH
        viewport.forget()
        give_back()
        return None

    return look
