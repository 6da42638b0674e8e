"""What `tools/cycles_test.py` has a Blender with a window do; runs inside of it.

Renders by F12 that are ended in five ways while a viewport shows its own, with edits between
them: see ``ended``. When each ended and what it left goes to `found.json`. The same with
Blender's own engine where the job names that one.
"""

from __future__ import annotations

import faulthandler
import gc
import importlib
import os
import random
import sys
import threading
import time
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import bpy

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
from screenshots import region_of  # type: ignore[import-not-found]
from x_server import press_escape  # type: ignore[import-not-found]

#: A render that never ends by itself.
ENDLESS = 1_000_000
#: How a cycle's render ends.
WAYS = ("escape", "twice", "undo", "load", "whole")
#: Seconds of rest in which the memory is looked at.
REST = 0.3
#: PHOTONMAP or, for comparison, CYCLES.
ENGINE = JOB["engine"]
#: Seconds that Cycles has for a picture: it does not tell of it.
CYCLES_PICTURE = 0.5
#: What the job has each cancelled render leave behind, to see whether that is noticed.
PLANTED: list[bytes] = []


def within() -> Any:
    """The context of the 3D view, for operators."""
    area = views()[0]
    return bpy.context.temp_override(window=window(), area=area, region=region_of(area))


def lamp() -> Any:
    """The first one."""
    return next(o for o in bpy.context.scene.objects if o.type == "LIGHT")


def renders() -> bool:
    """Whether F12 is rendering."""
    return bool(bpy.app.is_job_running("RENDER"))


def ours() -> list[str]:
    """Threads of the extension."""
    return [t.name for t in threading.enumerate() if t.name.startswith("photon_map")]


def press_f12() -> set[str]:
    """What the key does."""
    with bpy.context.temp_override(window=window()):
        answer: set[str] = bpy.ops.render.render("INVOKE_DEFAULT")
    return answer


def step_back() -> None:
    """Undo, as the key does."""
    with within():
        bpy.ops.ed.undo()


def edited(name: str) -> None:
    """A step of the user's that can be undone."""
    with within():
        bpy.ops.ed.undo_push(message=name)


def load(which: int) -> None:
    """Open a file over this one."""
    with bpy.context.temp_override(window=window()):
        bpy.ops.wm.open_mainfile(filepath=JOB["files"][which], load_ui=False)


def prepare() -> None:
    """Settings of the file that stay the same."""
    scene = bpy.context.scene
    scene.render.engine, scene.render.resolution_percentage = ENGINE, 25
    if ENGINE == "PHOTONMAP":
        scene.photon_map.seconds = 0.0
    else:
        scene.cycles.use_adaptive_sampling = False
        scene.cycles.use_denoising = scene.cycles.use_preview_denoising = False


def set_passes(count: int) -> None:
    """F12 ends by itself after so many."""
    if ENGINE == "PHOTONMAP":
        bpy.context.scene.photon_map.passes = count
    else:
        bpy.context.scene.cycles.samples = count


def until_shown(shown: list[float], pictures: int) -> Steps:
    """Wait until F12 shows more than so many."""
    if ENGINE == "PHOTONMAP":
        yield from until(lambda: len(shown) > pictures, "F12 shows nothing")
    else:
        yield from until(renders, "F12 does not begin")
        yield CYCLES_PICTURE


def allowed(write: Callable[[], None]) -> bool:
    """Do it, unless Blender forbids it: 4.3 may as another thread of Cycles calls Python."""
    try:
        write()
    except AttributeError as error:
        if "not allowed" not in str(error):
            raise
        return False
    return True


def shift(name: str, axis: int, distance: float) -> Steps:
    """Move an object."""

    def write() -> None:
        bpy.data.objects[name].location[axis] += distance

    yield from until(lambda: allowed(write), f"{name} cannot be moved")


def edit_in_viewport(rng: random.Random) -> Steps:
    """Move a lamp, add, move and delete an object, undo and redo, as the viewport renders."""
    yield from shift(lamp().name, 0, rng.uniform(-0.1, 0.1))
    edited("move a lamp")
    yield rng.choice((0.0, 0.1, 0.3))
    with within():
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.1)
    name = bpy.context.view_layer.objects.active.name
    edited("add a ball")
    yield rng.choice((0.0, 0.1, 0.3))
    step_back()
    yield rng.choice((0.0, 0.1))
    with within():
        bpy.ops.ed.redo()
    yield rng.choice((0.0, 0.1))
    yield from shift(name, 2, 0.1)
    yield rng.choice((0.0, 0.1))
    bpy.data.objects.remove(bpy.data.objects[name])
    edited("delete it")
    yield rng.choice((0.1, 0.2, 0.4))


def ended(way: str, rng: random.Random, shown: list[float]) -> Generator[float, None, float]:
    """F12 while the viewport renders, and its end: seconds that this took.

    ``shown``: when final renders show pictures. Objects are deleted and undone only between
    renders: Blender itself does not bear it in the moment when one starts.
    """
    pictures = len(shown)
    set_passes(2 if way == "whole" else ENDLESS)
    answer = press_f12()
    if "RUNNING_MODAL" not in answer:
        raise AssertionError(f"F12 does not start: {answer}")
    if way == "whole":
        lamp().data.energy *= rng.uniform(0.9, 1.1)
        yield from until(lambda: not renders(), "F12 does not end")
        return 0.0
    if way == "twice":
        yield rng.choice((0.0, 0.05, 0.2))
        answer = press_f12()
        if answer != {"CANCELLED"}:
            raise AssertionError(f"a second F12 is not refused: {answer}")
        yield rng.choice((0.0, 0.05, 0.2))
    else:
        yield from until_shown(shown, pictures)
        yield from shift(lamp().name, 1, rng.uniform(-0.05, 0.05))
        edited("move a lamp below a render")
        yield rng.choice((0.0, 0.1, 0.3))
    begin = time.monotonic()
    if way == "undo":
        step_back()
    elif way == "load":
        load(rng.randrange(len(JOB["files"])))
    else:
        press_escape()
        yield from until(lambda: not renders(), "Escape does not end F12", 60.0)
    if renders():
        raise AssertionError(f"F12 goes on after: {way}")
    PLANTED.append(os.urandom(int(JOB["planted"] * 2**20)))
    return time.monotonic() - begin


def cycles(found: dict[str, Any]) -> Steps:
    """All of them; each ends with the rendered view off, no thread of ours and a rest."""
    rng = random.Random(5)
    shown = films(MODULE) if ENGINE == "PHOTONMAP" else []
    give_back = importlib.import_module(f"{MODULE}.addon.allocator").give_back
    for k in range(JOB["cycles"]):
        way = WAYS[k % len(WAYS)]
        print(f"cycle {k}: {way}", flush=True)
        show_rendered(views()[0])
        yield rng.choice((0.05, 0.3, 0.6))
        yield from edit_in_viewport(rng)
        seconds = yield from ended(way, rng, shown)
        yield rng.choice((0.0, 0.1, 0.3))
        views()[0].spaces.active.shading.type = "SOLID"
        begin = time.monotonic()
        what = f"threads are left by cycle {k}, {way}"
        yield from until(lambda: not ours(), what, 30.0)
        left = time.monotonic() - begin
        unsettled = yield from resting()  # in which timers let go of the view
        gc.collect()
        found["allocators"] = give_back()
        settled = yield from resting()
        found["cycles"].append(
            {"way": way, "seconds": seconds, "left": left, "unsettled": unsettled,
             "settled": settled, "objects": len(gc.get_objects()), "load": os.getloadavg()[0]}
        )  # fmt: skip


def resting() -> Generator[float, None, list[float]]:
    """Do nothing; from when to when."""
    yield 0.0  # a timer's time counts from the begin of the step before
    begin = time.monotonic()
    yield REST
    return [begin, time.monotonic()]


def right_picture(frames: Frames, found: dict[str, Any]) -> Steps:
    """What F12 and the viewport show after all that."""
    load(0)
    scene = bpy.context.scene
    render, settings = scene.render, scene.photon_map
    settings.passes, settings.seed = JOB["passes"], JOB["seed"]
    render.resolution_x, render.resolution_y = JOB["size"]
    render.resolution_percentage = 100
    render.image_settings.file_format = "PNG"
    press_f12()
    yield from until(lambda: not renders(), "the last F12 does not end")
    bpy.data.images["Render Result"].save_render(str(FOLDER / "last.png"), scene=scene)
    show_rendered(views()[0])
    yield from frames.until(JOB["passes"], "in the viewport, at the end")
    found["viewport"] = {"contrast": float(part(shot("after_cycles"), views()[0]).std())}


def whole() -> Steps:
    """The whole test."""
    found: dict[str, Any] = {"version": bpy.app.version_string, "cycles": []}
    faulthandler.enable()
    preferences = bpy.context.preferences.view
    preferences.show_splash, preferences.render_display_type = False, "NONE"
    yield 1.0
    (FOLDER / "pid").write_text(str(os.getpid()))
    for name in JOB["files"]:
        with bpy.context.temp_override(window=window()):
            bpy.ops.wm.open_mainfile(filepath=name, load_ui=False)
        prepare()
        bpy.ops.wm.save_mainfile()
        yield 0.2
    frames = Frames(MODULE) if ENGINE == "PHOTONMAP" else None
    yield from told(cycles(found), f"cycles with {ENGINE}", found)
    if frames is not None:
        yield from told(right_picture(frames, found), "the last picture", found)
    bpy.ops.wm.quit_blender()


start(whole())
