"""What `tools/window_test.py` has a Blender with a window do; runs inside of it.

`blender SAMPLE -P window_steps.py -- JOB.json`. The job names the
folder for screenshots, a headless picture of the sample, and the samples to time. What is
found goes to `found.json` there; an exception ends Blender with code 3.
"""

from __future__ import annotations

import importlib
import itertools
import json
import os
import sys
import time
import traceback
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from screenshots import (  # type: ignore[import-not-found]
    cut,
    likeness,
    pixels_of,
    region_of,
    screenshot,
)
from x_server import press_escape, resize_windows  # type: ignore[import-not-found]

JOB = json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text())
FOLDER = Path(JOB["folder"])
MODULE = "bl_ext.user_default.photon_map"
#: Longest wait for anything [s].
PATIENCE = 240.0
TABS = ("RENDER", "OUTPUT", "VIEW_LAYER", "SCENE", "WORLD", "OBJECT", "MATERIAL", "DATA")

Steps = Generator[float, None, None]


class Frames:
    """When viewports have drawn which picture of which worker."""

    def __init__(self) -> None:
        self.drawn: list[tuple[float, int, str]] = []
        # Numbers of workers: Python gives the identity of one that has ended to another one.
        numbers: WeakKeyDictionary[Any, int] = WeakKeyDictionary()
        viewport = importlib.import_module(f"{MODULE}.addon.viewport").ViewportRender
        original = viewport.draw
        count = itertools.count(1)

        def draw(view: Any, context: Any, depsgraph: Any) -> str:
            before = view._drawn
            line: str = original(view, context, depsgraph)
            if view._drawn is not before and view._drawn is not None:
                worker = numbers.setdefault(view._worker, next(count))
                self.drawn.append((time.monotonic(), worker, view._drawn.line))
            return line

        viewport.draw = draw

    def passes(self, since: float) -> int:
        """Passes of the newest picture drawn after ``since``, 0 when there is none."""
        lines = [line for at, _, line in self.drawn if at > since]
        return int(lines[-1].split()[1].split("/")[0]) if lines else 0

    def first(self, since: float, old: int) -> float:
        """Seconds from ``since`` to the first picture by another worker than ``old``."""
        for at, worker, _ in self.drawn:
            if at > since and worker != old:
                return at - since
        return 0.0

    def until(self, passes: int, what: str) -> Steps:
        """Wait for a picture of so many passes, drawn from now on."""
        begin = time.monotonic()
        yield from until(lambda: self.passes(begin) >= passes, f"{passes} passes {what}")

    @property
    def worker(self) -> int:
        """The one that drew last."""
        return self.drawn[-1][1] if self.drawn else 0


def until(condition: Callable[[], object], what: str, patience: float = PATIENCE) -> Steps:
    """Wait for ``condition``."""
    end = time.monotonic() + patience
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(what)
        yield 0.02


def window(which: int = 0) -> Any:
    """A window of Blender's."""
    return bpy.context.window_manager.windows[which]


def views() -> list[Any]:
    """The 3D viewports of the first window."""
    return [area for area in window().screen.areas if area.type == "VIEW_3D"]


def shot(name: str) -> Any:
    """What the window shows now; the whole display is kept under ``name``."""
    return screenshot(FOLDER / f"{name}.xwd")[-window().height :]


def show_rendered(area: Any) -> None:
    """Rendered shading through the camera, and nothing over it."""
    space = area.spaces.active
    space.region_3d.view_perspective = "CAMERA"
    space.show_gizmo = space.overlay.show_overlays = False
    space.show_region_toolbar = space.show_region_ui = False
    space.shading.type = "RENDERED"
    area.tag_redraw()


def edits(scene: Any) -> dict[str, Callable[[], None]]:
    """Small edits of a scene by their names."""
    found: dict[str, Callable[[], None]] = {}
    movable = [o for o in scene.objects if o.type == "MESH" and not o.hide_render]
    if movable:
        smallest = min(movable, key=lambda o: max(o.dimensions))
        found["object"] = lambda: _move(smallest)
    lamps = [o for o in scene.objects if o.type == "LIGHT"]
    if lamps:
        found["light"] = lambda: setattr(lamps[0].data, "energy", 1.3 * lamps[0].data.energy)
    sockets = [
        socket
        for material in bpy.data.materials
        if material.node_tree
        for node in material.node_tree.nodes
        for socket in node.inputs
        if socket.name in ("Color", "Base Color") and not socket.is_linked
    ]
    if sockets:
        found["colour"] = lambda: _tint(sockets[0])
    found["camera"] = lambda: _move(scene.camera, 0.002)
    return found


def _move(obj: Any, share: float = 0.1) -> None:
    obj.location.x += share * max(*obj.dimensions, 1.0)


def _tint(socket: Any) -> None:
    red, green, blue, alpha = socket.default_value
    socket.default_value = (blue, 0.8 * green, red, alpha)


def timed(frames: Frames, edit: Callable[[], None], what: str) -> Generator[float, None, float]:
    """Make an edit; the seconds until a picture of it is drawn."""
    old, begin = frames.worker, time.monotonic()
    edit()
    yield from until(lambda: frames.first(begin, old), f"no picture after the edit: {what}")
    return frames.first(begin, old)


def latencies(frames: Frames, found: dict[str, Any]) -> Steps:
    """Edits of each sample in the rendered viewport, which is rendering meanwhile."""
    for sample in JOB["samples"]:
        with bpy.context.temp_override(window=window()):
            bpy.ops.wm.open_mainfile(filepath=sample, load_ui=False)
        # The samples are not bound to an engine: they open with Blender's own.
        bpy.context.scene.render.engine = "PHOTONMAP"
        yield 0.2
        begin = time.monotonic()
        show_rendered(max(views(), key=lambda a: a.width))
        yield from frames.until(1, sample)
        name = Path(sample).stem
        found[name] = {"first": round(time.monotonic() - begin, 3)}
        for what, edit in edits(bpy.context.scene).items():
            seconds = yield from timed(frames, edit, f"{name}: {what}")
            found[name][what] = round(seconds, 3)
            yield 0.3


def told(steps: Steps, what: str, found: dict[str, Any]) -> Steps:
    """Say that a part begins, for whoever reads the output after a failure; keep its end."""
    print(f"window test: {what}", flush=True)
    yield from steps
    (FOLDER / "found.json").write_text(json.dumps(found, indent=1))


def viewport(frames: Frames, found: dict[str, Any]) -> Steps:
    """The rendered viewport: its picture, edits, another size, two of them."""
    area = views()[0]
    show_rendered(area)
    yield from frames.until(JOB["passes"], "in the viewport")
    before = cut(shot("viewport"), area)
    found["viewport"] = likeness(before, pixels_of(Path(JOB["headless"])))
    found["viewport"]["contrast"] = float(before.std())
    yield from resized(frames, found)
    yield from bordered(frames, found)
    for name, edit in edits(bpy.context.scene).items():
        yield from timed(frames, edit, name)
        yield from frames.until(2, f"after the edit: {name}")
        after = cut(shot(f"edit_{name}"), area)
        found[f"edit {name}"] = {"change": float(np.abs(after - before).mean())}
        before = after
    begin = time.monotonic()
    with bpy.context.temp_override(window=window(), area=area, region=region_of(area)):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.45)
    yield 0.5
    for view in views():
        show_rendered(view)
    yield from until(
        lambda: len({worker for at, worker, _ in frames.drawn if at > begin}) >= 2,
        "pictures in two viewports",
    )
    yield from frames.until(2, "in two viewports")
    pixels = shot("two_viewports")
    for k, view in enumerate(views()):
        found[f"split view {k}"] = {"contrast": float(cut(pixels, view).std())}
    for view in views():
        view.spaces.active.shading.type = "SOLID"
    yield 0.5


def resized(frames: Frames, found: dict[str, Any]) -> Steps:
    """The window becomes smaller while its viewport renders."""
    area, old = views()[0], (window().width, window().height)
    before = region_of(area).width
    resize_windows(old[0] - 150, old[1] - 110)
    yield from until(lambda: region_of(area).width < before, "the window keeps its size")
    yield from frames.until(JOB["passes"], "in the smaller window")
    picture = cut(shot("resized"), area)
    found["resized"] = likeness(picture, pixels_of(Path(JOB["headless"])))
    resize_windows(*old)
    yield from until(lambda: region_of(area).width == before, "the window stays small")
    yield from frames.until(2, "in the larger window")


def bordered(frames: Frames, found: dict[str, Any]) -> Steps:
    """The scene's border, in the view of its camera."""
    area, render = views()[0], bpy.context.scene.render
    render.border_min_x, render.border_max_x = render.border_min_y, render.border_max_y = (
        0.25,
        0.75,
    )
    render.use_border = True
    yield from frames.until(JOB["passes"], "in the border")
    inside, outside = parted(cut(shot("border"), area))
    whole = pixels_of(Path(JOB["headless"]))
    found["border"] = {
        **likeness(inside, parted(whole)[0]),
        "outside": float(outside.std()),
    }
    render.use_border = False
    yield from frames.until(2, "without the border")


def parted(pixels: Any) -> tuple[Any, Any]:
    """The middle of a picture, and a part of its rim."""
    height, width = pixels.shape[:2]
    middle = pixels[height // 4 : 3 * height // 4, width // 4 : 3 * width // 4]
    return middle, pixels[:, : width // 4 - 3]


def final(found: dict[str, Any]) -> Steps:
    """F12 to its end, and one that is cancelled by Escape."""
    ended: dict[str, float] = {}
    for name in ("render_complete", "render_cancel"):
        getattr(bpy.app.handlers, name).append(
            lambda *_, name=name: ended.update({name: time.monotonic()})
        )
    scene = bpy.context.scene
    scene.photon_map.seconds = 0.0
    scene.photon_map.passes = JOB["passes"]
    with bpy.context.temp_override(window=window()):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from until(lambda: "render_complete" in ended, "F12 does not end")
    yield 1.0
    pixels = shot("f12")
    pictures = [area for area in window().screen.areas if area.type == "IMAGE_EDITOR"]
    found["F12"] = {"contrast": float(pixels.std()), "pictures": len(pictures)}
    scene.photon_map.passes = 100_000
    with bpy.context.temp_override(window=window()):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield 4.0
    begin = time.monotonic()
    press_escape()
    yield from until(lambda: "render_cancel" in ended, "Escape does not end F12", 60.0)
    found["cancel"] = {"seconds": round(ended["render_cancel"] - begin, 3)}
    yield 1.0
    found["cancelled picture"] = {"contrast": float(shot("cancelled").std())}
    for area in pictures:
        area.type = "VIEW_3D"
    yield 0.5


def panels(found: dict[str, Any]) -> Steps:
    """Each tab of the properties, in the largest area there is."""
    area = max(window().screen.areas, key=lambda a: a.width * a.height)
    area.type = "PROPERTIES"
    # It knows its tabs when it has been drawn.
    yield 0.5
    scene = bpy.context.scene
    chosen = next(o for o in scene.objects if o.type == "MESH")
    lamp = next((o for o in scene.objects if o.type == "LIGHT"), chosen)
    for tab in TABS:
        bpy.context.view_layer.objects.active = lamp if tab == "DATA" else chosen
        area.spaces.active.context = tab
        yield 0.5
        pixels = shot(f"panel_{tab.lower()}")
        found[f"panel {tab}"] = {"contrast": float(pixels.std())}


def whole() -> Steps:
    """The whole test."""
    found: dict[str, Any] = {"version": bpy.app.version_string}
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.view.render_display_type = "AREA"
    yield 1.0
    frames = Frames()
    yield from told(viewport(frames, found), "viewport", found)
    yield from told(final(found), "F12", found)
    yield from told(panels(found), "panels", found)
    area = max(window().screen.areas, key=lambda a: a.width * a.height)
    area.type = "VIEW_3D"
    yield 0.5
    found["latency"], found["load"] = {}, os.getloadavg()[0]
    yield from told(latencies(frames, found["latency"]), "latency", found)
    bpy.ops.wm.quit_blender()


def drive(steps: Steps) -> Callable[[], float | None]:
    """A timer that takes the steps."""

    def step() -> float | None:
        try:
            return next(steps)
        except StopIteration:
            return None
        except BaseException:
            traceback.print_exc()
            shot("failed")
            sys.stdout.flush()
            os._exit(3)

    return step


bpy.app.timers.register(drive(whole()), first_interval=1.0, persistent=True)
