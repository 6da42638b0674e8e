"""What `tools/window_test.py` has a Blender with a window do; runs inside of it.

`blender SAMPLE -P window_steps.py -- JOB.json`. The job names the folder for screenshots and
the samples to time. What is found goes to `found.json` there, and what the camera sees to
`.npy` files; an exception ends Blender with code 3.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from driven import (  # type: ignore[import-not-found]
    FOLDER,
    JOB,
    MODULE,
    part,
    shot,
    show_rendered,
    start,
    told,
    views,
    window,
)
from frames import Frames, Steps, films, until  # type: ignore[import-not-found]
from likeness import parted  # type: ignore[import-not-found]
from screenshots import cut, region_of  # type: ignore[import-not-found]
from x_server import press_escape, resize_windows  # type: ignore[import-not-found]

TABS = ("RENDER", "OUTPUT", "VIEW_LAYER", "SCENE", "WORLD", "OBJECT", "MATERIAL", "DATA")


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


def timed(
    frames: Frames, edit: Callable[[], None], what: str
) -> Generator[float, None, list[float]]:
    """Make an edit; seconds until a picture of it is drawn, and those of the processors."""
    old, begin, used = frames.worker, time.monotonic(), time.process_time()
    edit()
    yield from until(lambda: frames.first(begin, old), f"no picture after the edit: {what}")
    drawn = frames.first(begin, old)
    assert drawn is not None
    return [round(drawn.at - begin, 3), round(drawn.processor - used, 3)]


def latencies(frames: Frames, found: dict[str, Any]) -> Steps:
    """Edits of each sample in the rendered viewport, which is rendering meanwhile."""
    for sample in JOB["samples"]:
        with bpy.context.temp_override(window=window()):
            bpy.ops.wm.open_mainfile(filepath=sample, load_ui=False)
        # The samples are not bound to an engine: they open with Blender's own.
        bpy.context.scene.render.engine = "PHOTONMAP"
        yield 0.2
        begin, used = time.monotonic(), time.process_time()
        show_rendered(max(views(), key=lambda a: a.width))
        yield from frames.until(1, sample)
        name = Path(sample).stem
        seconds = [round(time.monotonic() - begin, 3), round(time.process_time() - used, 3)]
        found[name] = {"first": seconds}
        for what, edit in edits(bpy.context.scene).items():
            seconds = yield from timed(frames, edit, f"{name}: {what}")
            found[name][what] = seconds
            yield 0.3


def viewport(frames: Frames, found: dict[str, Any]) -> Steps:
    """The rendered viewport: its picture, edits, another size, two of them."""
    area = views()[0]
    show_rendered(area)
    yield from frames.until(JOB["passes"], "in the viewport")
    before = cut(shot("viewport"), area)
    keep("viewport", before)
    found["viewport"] = {"contrast": float(before.std())}
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
        lambda: len(frames.workers(begin)) >= 2,
        "pictures in two viewports",
    )
    yield from frames.until(2, "in two viewports")
    pixels = shot("two_viewports")
    for k, view in enumerate(views()):
        found[f"split view {k}"] = {"contrast": float(cut(pixels, view).std())}
    yield from quad_view(frames, found)
    for view in views():
        view.spaces.active.shading.type = "SOLID"
    yield 0.5


def quad_view(frames: Frames, found: dict[str, Any]) -> Steps:
    """Four views in one area, each with a worker of its own."""
    area = max(views(), key=lambda a: a.width)
    for view in views():
        view.spaces.active.shading.type = "RENDERED" if view == area else "SOLID"
    for turn in ("on", "off"):
        with bpy.context.temp_override(window=window(), area=area, region=region_of(area)):
            bpy.ops.screen.region_quadview()
        yield 0.5
        if turn == "off":
            return
        begin = time.monotonic()
        yield from until(
            lambda begin=begin: len(frames.workers(begin)) >= 4, "pictures in the quad view"
        )
        found["quad view"] = {"contrast": float(part(shot("quad_view"), area).std())}


def keep(name: str, picture: Any) -> None:
    """Leave what the camera sees to be compared."""
    np.save(FOLDER / f"{name}.npy", picture)


def resized(frames: Frames, found: dict[str, Any]) -> Steps:
    """The window becomes smaller while its viewport renders."""
    area, old = views()[0], (window().width, window().height)
    before = region_of(area).width
    resize_windows(old[0] - 150, old[1] - 110)
    yield from until(lambda: region_of(area).width < before, "the window keeps its size")
    yield from frames.until(JOB["passes"], "in the smaller window")
    picture = cut(shot("resized"), area)
    keep("resized", picture)
    found["resized"] = {"contrast": float(picture.std())}
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
    picture = cut(shot("border"), area)
    keep("border", picture)
    found["border"] = {"outside": float(parted(picture)[1].std())}
    render.use_border = False
    yield from frames.until(2, "without the border")


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
    contrast = float(part(pixels, pictures[0]).std()) if pictures else 0.0
    found["F12"] = {"contrast": contrast, "pictures": len(pictures)}
    scene.photon_map.passes, shown = 100_000, films(MODULE)
    with bpy.context.temp_override(window=window()):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield from until(lambda: shown, "F12 shows nothing")
    begin = time.monotonic()
    press_escape()
    yield from until(lambda: "render_cancel" in ended, "Escape does not end F12", 60.0)
    seconds = round(ended["render_cancel"] - begin, 3)
    found["cancel"] = {"seconds": seconds, "load": os.getloadavg()[0]}
    yield 1.0
    found["cancelled picture"] = {"contrast": float(part(shot("cancelled"), pictures[0]).std())}
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


def previews(found: dict[str, Any]) -> Steps:
    """Pictures of a material, a lamp and a world, made by Blender's jobs in their tabs."""
    area = max(window().screen.areas, key=lambda a: a.width * a.height)
    scene = bpy.context.scene
    lamp = next(o for o in scene.objects if o.type == "LIGHT")
    chosen = next(o for o in scene.objects if o.type == "MESH")
    scene.world = scene.world or bpy.data.worlds.new("World")
    for tab, owner, active in (
        ("MATERIAL", chosen.material_slots[0].material, chosen),
        ("DATA", lamp.data, lamp),
        ("WORLD", scene.world, chosen),
    ):
        bpy.context.view_layer.objects.active = active
        yield 0.5  # The tabs are those of the object that was drawn last.
        area.spaces.active.context = tab
        yield 0.5
        with bpy.context.temp_override(window=window(), area=area, id=owner):
            bpy.ops.ed.lib_id_generate_preview()
        begin = time.monotonic()
        yield from until(lambda owner=owner: _picture_of(owner).any(), f"preview: {tab}")
        seconds = time.monotonic() - begin
        found[f"preview {tab}"] = {"seconds": seconds, "mean": _picture_of(owner).mean()}
        yield 1.0
        shot(f"preview_{tab.lower()}")


def _picture_of(owner: Any) -> Any:
    return np.array(owner.preview_ensure().image_pixels_float[:])


def whole() -> Steps:
    """The whole test."""
    found: dict[str, Any] = {"version": bpy.app.version_string}
    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.view.render_display_type = "AREA"
    yield 1.0
    frames = Frames(MODULE)
    yield from told(viewport(frames, found), "viewport", found)
    yield from told(final(found), "F12", found)
    yield from told(panels(found), "panels", found)
    yield from told(previews(found), "previews", found)
    area = max(window().screen.areas, key=lambda a: a.width * a.height)
    area.type = "VIEW_3D"
    yield 0.5
    found["latency"], found["load"] = {}, os.getloadavg()[0]
    yield from told(latencies(frames, found["latency"]), "latency", found)
    bpy.ops.wm.quit_blender()


start(whole())
