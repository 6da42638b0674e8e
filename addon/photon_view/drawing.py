"""Draws photons, discs and paths into every 3D view; ``gpu`` is there with a window alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

from ..ui.panel import ENGINE
from .look import LOOK

if TYPE_CHECKING:
    from .cloud import Cloud

_DISC = (1.0, 1.0, 1.0, 1.0)
#: Widths of lines, size of words [pixels].
_LINE, _WORDS = 1.5, 12


class Drawer:
    """The draw handlers, and what they last handed to the graphics card."""

    def __init__(self) -> None:
        self._handles: list[Any] = []
        self._key: tuple[object, ...] = ()
        self._batches: list[tuple[Any, Any, str]] = []
        self._words: list[tuple[str, tuple[float, float, float]]] = []

    def start(self) -> None:
        """Draw from now on."""
        space = bpy.types.SpaceView3D
        for draw, when in ((self.draw_view, "POST_VIEW"), (self.draw_words, "POST_PIXEL")):
            self._handles.append(space.draw_handler_add(draw, (), "WINDOW", when))

    def stop(self) -> None:
        """Draw no more."""
        for handle in self._handles:
            bpy.types.SpaceView3D.draw_handler_remove(handle, "WINDOW")
        self._handles.clear()
        self._key, self._batches, self._words = (), [], []

    def _refresh(self, own: Any) -> None:
        """Build the batches when there is something else to draw."""
        key = (LOOK.serial, own.kind, own.colour, own.paths)
        if key != self._key:
            from .cloud import cloud_of

            self._key = key
            cloud = cloud_of(own)
            self._batches = [] if cloud is None else batches_of(cloud)
            self._words = [] if cloud is None else cloud.words

    def draw_view(self) -> None:
        """Points and lines."""
        context = bpy.context
        if not is_shown(context):
            return
        import gpu

        own = context.window_manager.photon_map_photons
        self._refresh(own)
        gpu.state.blend_set("ALPHA")
        gpu.state.depth_test_set("NONE" if own.in_front else "LESS_EQUAL")
        gpu.state.point_size_set(own.size * context.preferences.system.ui_scale)
        for batch, shader, kind in self._batches:
            shader.bind()
            if kind == "LINES":
                shader.uniform_float("lineWidth", _LINE)
                shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
            batch.draw(shader)
        gpu.state.point_size_set(1.0)
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")

    def draw_words(self) -> None:
        """What the colours stand for, in the lower left corner."""
        context = bpy.context
        if not is_shown(context):
            return
        import blf

        words = self._words
        if LOOK.doing:
            words = [(LOOK.doing, (1.0, 1.0, 1.0))]
        elif LOOK.failure:
            words = [(LOOK.failure, (1.0, 0.5, 0.4)), *words]
        scale = context.preferences.system.ui_scale
        blf.size(0, _WORDS * scale)
        wide = max((blf.dimensions(0, text)[0] for text, _ in words), default=0.0)
        if words:
            draw_ground(wide + 20 * scale, (1.5 * _WORDS * len(words) + 10) * scale, scale)
        for line, (text, shade) in enumerate(reversed(words)):
            blf.position(0, 20 * scale, (20 + 1.5 * _WORDS * line) * scale, 0)
            blf.color(0, *shade, 1.0)
            blf.draw(0, text)


def draw_ground(width: float, height: float, scale: float) -> None:
    """Something dark for the words to stand on."""
    import gpu
    from gpu_extras.batch import batch_for_shader

    x, y = 10.0 * scale, 10.0 * scale
    corners = [(x, y), (x + width, y), (x, y + height), (x + width, y + height)]
    shader = builtin("UNIFORM_COLOR")
    gpu.state.blend_set("ALPHA")
    shader.bind()
    shader.uniform_float("color", (0.0, 0.0, 0.0, 0.6))
    batch_for_shader(shader, "TRI_STRIP", {"pos": corners}).draw(shader)
    gpu.state.blend_set("NONE")


def is_shown(context: Any) -> bool:
    """Whether the view that is drawn shows photons."""
    space = context.space_data
    return (
        LOOK.is_on(context.scene)
        and context.scene.render.engine == ENGINE
        and space is not None
        and space.overlay.show_overlays
    )


def batches_of(cloud: Cloud) -> list[tuple[Any, Any, str]]:
    """Batches with their shaders, and whether they are points or lines."""
    import numpy as np
    from gpu_extras.batch import batch_for_shader

    found = []
    points, lines = point_shader(), builtin("POLYLINE_FLAT_COLOR")
    if len(cloud.points):
        columns = {"pos": cloud.points, "color": cloud.shades}
        found.append((batch_for_shader(points, "POINTS", columns), points, "POINTS"))
    if len(cloud.ends):
        columns = {"pos": cloud.ends, "color": cloud.end_shades}
        found.append((batch_for_shader(lines, "LINES", columns), lines, "LINES"))
    for rim in cloud.rings:
        white = np.tile(np.array(_DISC, np.float32), (len(rim), 1))
        columns = {"pos": rim, "color": white}
        found.append((batch_for_shader(lines, "LINE_STRIP", columns), lines, "LINES"))
    return found


def point_shader() -> Any:
    """Blender 4.5 and later have one for points, which Vulkan and Metal ask for."""
    try:
        return builtin("POINT_FLAT_COLOR")
    except ValueError:
        return builtin("FLAT_COLOR")


def builtin(name: str) -> Any:
    """One of Blender's shaders; raises ``ValueError``."""
    import gpu

    return gpu.shader.from_builtin(name)


DRAWER = Drawer()


def start() -> None:
    """Draw from now on."""
    DRAWER.start()


def stop() -> None:
    """Draw no more."""
    DRAWER.stop()
