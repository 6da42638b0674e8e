"""Draws photons, discs and paths into every 3D view; ``gpu`` is there with a window alone."""

from __future__ import annotations

from typing import Any, NamedTuple

import bpy
import numpy as np
from numpy.typing import NDArray

from ..ui.panel import ENGINE
from .look import LOOK, Picked

#: Points stand this much off their surface, in radii of the scene, so as to be seen.
_OFF = 1e-3
_DISC = (1.0, 1.0, 1.0, 1.0)
_CORNERS = 64
#: Widths of lines, size of words [pixels].
_LINE, _WORDS = 1.5, 12
_ALPHA = 0.7


class Cloud(NamedTuple):
    """What is drawn: points (N, 3) and colours (N, 4), segments (2S, 3) and theirs, rings."""

    points: NDArray[np.float32]
    shades: NDArray[np.float32]
    ends: NDArray[np.float32]
    end_shades: NDArray[np.float32]
    rings: list[NDArray[np.float32]]
    words: list[tuple[str, tuple[float, float, float]]]


def cloud_of(own: Any) -> Cloud | None:
    """What ``LOOK`` has to draw by the choices in ``own``; None when there is nothing."""
    if LOOK.viewed is None:
        return None
    from ...core import photon_colours, photon_legend, power_scale

    view, size = LOOK.viewed.view, LOOK.viewed.size
    shades = photon_colours(view, own.colour)
    shown = np.ones(len(shades), np.bool_)
    if own.kind != "ALL":
        shown = view.caustic == (own.kind == "CAUSTIC")
    if own.colour == "power":
        words = [(f"{watt:.2g} W", shade) for watt, shade in power_scale(view)]
    else:
        legend = photon_legend(view.only(shown), own.colour)[:10]
        words = [(f"{entry.name}: {entry.number}", entry.colour) for entry in legend]
    ends, end_shades = np.zeros((0, 3)), np.zeros((0, 3))
    rings: list[NDArray[np.float32]] = []
    if LOOK.picked is not None:
        rings = [ring(disc, _OFF * size) for disc in LOOK.picked.discs]
        if own.paths:
            ends, end_shades = segments(LOOK.picked, shades, shown)
    lifted = view.position + _OFF * size * view.normal
    return Cloud(
        points=lifted[shown].astype(np.float32),
        shades=with_alpha(shades[shown], 1.0),
        ends=ends.astype(np.float32),
        end_shades=with_alpha(end_shades, _ALPHA),
        rings=rings,
        words=words,
    )


def with_alpha(shades: NDArray[np.float64], alpha: float) -> NDArray[np.float32]:
    """Colours (N, 3) with how much of them is seen, (N, 4)."""
    return np.column_stack([shades, np.full(len(shades), alpha)]).astype(np.float32)


def segments(
    picked: Picked, shades: NDArray[np.float64], shown: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Ends (2S, 3) of all pieces of the paths of ``shown`` photons, and their colours."""
    ends, colours = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for row, path in zip(picked.rows, picked.paths, strict=True):
        if shown[row] and len(path) > 1:
            pieces = np.repeat(path, 2, axis=0)[1:-1]
            ends.append(pieces)
            colours.append(np.broadcast_to(shades[row], pieces.shape))
    return np.concatenate(ends), np.concatenate(colours)


def ring(disc: Any, off: float) -> NDArray[np.float32]:
    """The rim of a gather disc (C, 3), its first point again at the end."""
    normal = disc.place.normal
    aside = np.cross(normal, np.eye(3)[np.argmin(abs(normal))])
    aside /= np.linalg.norm(aside)
    turn = np.linspace(0, 2 * np.pi, _CORNERS + 1)[:, None]
    rim = np.cos(turn) * aside + np.sin(turn) * np.cross(normal, aside)
    place = disc.place.position + off * normal
    return np.asarray(place + disc.radius * rim, np.float32)


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
