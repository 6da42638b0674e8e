"""Drives the photon view in a window: `python tools/photon_window.py BLENDER OUT`.

Installs the archive that fits into an empty profile, opens a sample, shows its photons, picks
places by operator and by a click, has the rendered viewport go on under them without being
started anew, undoes an edit and disables the extension; says what the photons add to the time
of drawing the window. Screenshots go to the folder OUT. Ends with 1 at the first thing that is
wrong.

Needs a display (`xvfb-run` will do) and `xwd`, which takes what the server shows: Blender's
own screenshots are black with Mesa's software renderer. As for `acceptance.py`, TMPDIR
chooses a folder that a Blender in a chroot sees under the same path. This file is both the
trial and the script that Blender runs.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
MODULE = "bl_ext.user_default.photon_map"
SAMPLE = "glass_caustics"
SIZE = (1280, 800)
#: Longest wait [s] for one thing: the first one compiles.
PATIENCE = 600.0
DONE = "PHOTON_WINDOW_DONE"


def drive(folder: Path) -> Iterator[float]:
    """Inside of Blender: do one thing after the other; yields the seconds to wait after it."""
    import bpy

    look = sys.modules[f"{MODULE}.addon.photon_view.look"].LOOK
    panel = sys.modules[f"{MODULE}.addon.photon_view.panel"]
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    sidebar = next(region for region in area.regions if region.type == "UI")
    space = area.spaces.active
    own = bpy.context.window_manager.photon_map_photons

    def within() -> Any:
        return bpy.context.temp_override(window=window, area=area, region=region)

    def shot(name: str) -> None:
        subprocess.run(
            ["xwd", "-root", "-silent", "-out", str(folder / f"{name}.xwd")], check=True
        )

    def until_done() -> Iterator[float]:
        waited = 0.0
        while look.doing:
            assert waited < PATIENCE, look.doing
            waited += 0.5
            yield 0.5
        assert not look.failure, look.failure

    space.region_3d.view_perspective = "CAMERA"
    space.shading.type = "SOLID"
    space.show_region_ui = True
    yield 1.0
    sidebar.active_panel_category = "Photon Map"
    with within():
        bpy.ops.view3d.view_center_camera()
        assert bpy.ops.photon_map.toggle_photons() == {"FINISHED"}
    yield from until_done()
    yield 1.5
    shot("photons")
    with within():
        count = len(look.viewed.view.position)
        print(f"window drawn with {count} photons in {redraw_time():.0f} ms", flush=True)
        number, look.scene_uid = look.scene_uid, 0
        print(f"without them in {redraw_time():.0f} ms", flush=True)
        look.scene_uid = number
    own.colour = "caster"
    with within():
        # The lens' caustic on the wall, then by a click that of the sphere on the floor.
        x, y = int(0.255 * region.width), int(0.785 * region.height)
        assert bpy.ops.photon_map.pick_photons(place=(x, y)) == {"FINISHED"}
    yield from until_done()
    assert look.picked is not None and panel.lines_of_place()
    first = panel.lines_of_place()
    print("\n".join(first), flush=True)
    yield 1.5
    shot("disc")
    with within():
        assert bpy.ops.photon_map.pick_photons("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield 0.5
    x, y = region.x + int(0.32 * region.width), region.y + int(0.35 * region.height)
    for kind, value in (
        ("MOUSEMOVE", "NOTHING"), ("LEFTMOUSE", "PRESS"), ("LEFTMOUSE", "RELEASE")
    ):  # fmt: skip
        window.event_simulate(type=kind, value=value, x=x, y=y)
        yield 0.3
    yield from until_done()
    assert panel.lines_of_place() not in ([], first), "the click picked nothing"
    print("\n".join(panel.lines_of_place()), flush=True)
    own.kind, own.in_front = "CAUSTIC", True
    yield 1.5
    shot("click")
    starts, lines = watched(import_module(f"{MODULE}.addon.viewport").ViewportRender)
    begin = time.monotonic()
    space.shading.type = "RENDERED"
    # A coarse picture is the only pass of its own.
    while not any(re.match(r"Pass \d+/(?!1\b)", line) for line in lines):
        assert time.monotonic() - begin < PATIENCE, lines
        yield 0.5
    print(f"whole picture after {time.monotonic() - begin:.0f} s: {lines}", flush=True)
    yield 10.0
    assert len(starts) == 1, f"the photons start the render anew: {starts}"
    shot("rendered")
    space.shading.type = "SOLID"
    with within():
        bpy.ops.ed.undo_push(message="before")
        bpy.data.objects[0].location.x += 0.1
        bpy.ops.ed.undo_push(message="after")
        yield 0.5
    with within():
        bpy.ops.ed.undo()
    yield 1.0
    assert look.viewed is None, "an undo leaves the photons"
    with within():
        assert bpy.ops.photon_map.toggle_photons() == {"FINISHED"}
    yield from until_done()
    bpy.ops.preferences.addon_disable(module=MODULE)
    yield 1.5
    assert look.viewed is None
    shot("disabled")


def redraw_time() -> float:
    """Milliseconds that drawing the window takes."""
    import bpy

    begin = time.monotonic()
    bpy.ops.wm.redraw_timer(type="DRAW_WIN", iterations=20)
    return 50.0 * (time.monotonic() - begin)


def watched(viewport: Any) -> tuple[list[float], list[str]]:
    """When renders of the ``viewport`` class begin from now on, and lines that it shows."""
    starts: list[float] = []
    lines: list[str] = []
    start, draw = viewport._start, viewport.draw

    def noted_start(view: Any, *rest: Any) -> None:
        starts.append(time.monotonic())
        start(view, *rest)

    def noted_draw(view: Any, *rest: Any) -> str:
        line: str = draw(view, *rest)
        if line not in lines:
            lines.append(line)
        return line

    viewport._start, viewport.draw = noted_start, noted_draw
    return starts, lines


def run_in_blender(folder: Path) -> None:
    """Have a timer do the steps of ``drive``; leave Blender after the last one."""
    import bpy

    bpy.context.preferences.view.show_splash = False
    steps: list[Iterator[float]] = []

    def step() -> float | None:
        try:
            if not steps:
                steps.append(drive(folder))
            return next(steps[0])
        except StopIteration:
            print(DONE, flush=True)
        except BaseException:
            traceback.print_exc()
        bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(step, first_interval=3.0, persistent=True)


def main() -> None:
    """Outside of Blender: install, run, look at what came out."""
    from acceptance import (  # type: ignore[import-not-found]
        Blender,
        check,
        fitting_archive,
    )
    from PIL import Image
    from xwd import read_xwd  # type: ignore[import-not-found]

    command, out = sys.argv[1], Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="photon_map_window_") as name:
        folder = Path(name)
        blender = Blender(command, folder)
        archive = fitting_archive(blender.probe("--factory-startup"), folder)
        blender.run(
            "--command", "extension", "install-file", "-r", "user_default", "-e", str(archive)
        )
        for file in (ROOT / "sample_blends" / f"{SAMPLE}.blend", Path(__file__)):
            shutil.copy(file, folder)
        blender.environment |= {
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "PHOTON_WINDOW_FOLDER": str(folder),
        }
        shown = blender.run(
            "--enable-event-simulate", "--window-geometry", "0", "0", *map(str, SIZE),
            str(folder / f"{SAMPLE}.blend"), "-P", str(folder / Path(__file__).name),
        )  # fmt: skip
        print(shown)
        dumps = sorted(folder.glob("*.xwd"))
        for dump in dumps:
            Image.fromarray(read_xwd(dump)).save(out / f"{dump.stem}.png")
        check(DONE in shown, "the trial did not come to its end")
    print(json.dumps([dump.stem for dump in dumps]))


if "bpy" in sys.modules:
    run_in_blender(Path(os.environ["PHOTON_WINDOW_FOLDER"]))
elif __name__ == "__main__":
    main()
