"""What the scripts that drive Blender's window have in common; runs inside of Blender.

`blender SAMPLE -P STEPS.py -- JOB.json`: the job names the folder for screenshots and for
`found.json`, which tells what was found.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
from frames import Steps  # type: ignore[import-not-found]
from screenshots import screenshot  # type: ignore[import-not-found]

JOB = json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text())
FOLDER = Path(JOB["folder"])
MODULE = "bl_ext.user_default.photon_map"


def window(which: int = 0) -> Any:
    """A window of Blender's."""
    return bpy.context.window_manager.windows[which]


def views() -> list[Any]:
    """The 3D viewports of the first window."""
    return [area for area in window().screen.areas if area.type == "VIEW_3D"]


def shot(name: str) -> Any:
    """What the window shows now; the whole display is kept under ``name``."""
    return screenshot(FOLDER / f"{name}.xwd")[-window().height :]


def part(pixels: Any, area: Any) -> Any:
    """What an area shows."""
    return pixels[area.y : area.y + area.height, area.x : area.x + area.width]


def show_rendered(area: Any) -> None:
    """Rendered shading through the camera, and nothing over it."""
    space = area.spaces.active
    space.region_3d.view_perspective = "CAMERA"
    space.show_gizmo = space.overlay.show_overlays = False
    space.show_region_toolbar = space.show_region_ui = False
    space.shading.type = "RENDERED"
    area.tag_redraw()


def told(steps: Steps, what: str, found: dict[str, Any]) -> Steps:
    """Say that a part begins, for whoever reads the output after a failure; keep its end."""
    print(f"window test: {what}", flush=True)
    yield from steps
    (FOLDER / "found.json").write_text(json.dumps(found, indent=1))


def start(steps: Steps) -> None:
    """Have a timer take the steps; an exception ends Blender with code 3."""
    bpy.app.timers.register(_stepper(steps), first_interval=1.0, persistent=True)


def _stepper(steps: Steps) -> Callable[[], float | None]:
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
