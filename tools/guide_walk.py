"""Follows docs/user_guide.md in a window: `make guide BLENDER=path`.

In an empty profile, offline: installs the archive as "Install from Disk" does, then goes
through "A first caustic" with the keys that it names, renders by F12 and looks for the bright
spot in the sphere's shadow. The picture and screenshots are left in a folder. Ends with 1 at
the first thing that is not as the guide says.

BLENDER and `--xvfb` as for `window_test.py`. This file is both the trial and the script that
Blender runs.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SIZE = (1280, 800)
#: Longest wait [s] for the picture: the first render compiles.
PATIENCE = 900.0
DONE = "GUIDE_WALK_DONE"
#: As many as the picture in the guide has.
PASSES = 32


def walk(folder: Path) -> Iterator[float]:
    """Inside of Blender: one step after the other; yields the seconds to wait after it."""
    import bpy

    def area_of(kind: str) -> Any:
        return next(
            area for area in bpy.context.window_manager.windows[0].screen.areas
            if area.type == kind
        )  # fmt: skip

    def within(kind: str = "VIEW_3D") -> Any:
        area = area_of(kind)
        region = next(region for region in area.regions if region.type == "WINDOW")
        window = bpy.context.window_manager.windows[0]
        return bpy.context.temp_override(window=window, area=area, region=region)

    def press(*keys: str) -> Iterator[float]:
        """Keys over the middle of the 3D view."""
        area = area_of("VIEW_3D")
        where = {"x": area.x + area.width // 2, "y": area.y + area.height // 2}
        window = bpy.context.window_manager.windows[0]
        window.event_simulate(type="MOUSEMOVE", value="NOTHING", **where)
        yield 0.3
        for key in keys:
            digit = {"ZERO": "0", "ONE": "1"}.get(key)
            spelt = {"unicode": digit or key.lower()} if digit or len(key) == 1 else {}
            window.event_simulate(type=key, value="PRESS", **where, **spelt)
            yield 0.2
            window.event_simulate(type=key, value="RELEASE", **where)
            yield 0.3

    def shot(name: str) -> None:
        subprocess.run(
            ["xwd", "-root", "-silent", "-out", str(folder / f"{name}.xwd")], check=True
        )

    # Install, steps 2 and 3.
    archive = os.environ["GUIDE_WALK_ARCHIVE"]
    with within():
        done = bpy.ops.extensions.package_install_files(
            filepath=archive, repo="user_default", enable_on_install=True
        )
    assert done == {"FINISHED"}, done
    yield 1.0
    # A first caustic, step 1.
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.wm.read_homefile(app_template="", load_ui=False)
    yield 1.0
    assert sorted(bpy.data.objects.keys()) == ["Camera", "Cube", "Light"]
    yield from press("X")
    if "Cube" in bpy.context.scene.objects:  # it asks back
        yield from press("RET")
    assert "Cube" not in bpy.context.scene.objects, "X deletes nothing"
    with within():
        bpy.ops.mesh.primitive_plane_add()
    yield from press("S", "ONE", "ZERO", "RET")
    plane = bpy.context.view_layer.objects.active
    assert abs(plane.dimensions.x - 20.0) < 1e-4, plane.dimensions
    # Step 2.
    with within():
        bpy.ops.mesh.primitive_uv_sphere_add()
    yield from press("G", "Z", "ONE", "RET")
    ball = bpy.context.view_layer.objects.active
    assert abs(ball.location.z - 1.0) < 1e-4 and abs(ball.location.x) < 1e-4, ball.location
    with within():
        bpy.ops.object.shade_smooth()
    # Step 3: the engine is among those of the Render tab.
    scene = bpy.context.scene
    scene.render.engine = "PHOTONMAP"
    yield 0.5
    # Step 4.
    properties = area_of("PROPERTIES")
    properties.spaces.active.context = "MATERIAL"
    yield 0.5
    with within("PROPERTIES"):
        assert bpy.ops.material.new.poll()
        bpy.ops.material.new()
    if ball.active_material is None:  # the button sets its slot, the operator alone does not
        ball.data.materials.append(bpy.data.materials[-1])
    tree = ball.active_material.node_tree
    glass = tree.nodes.new("ShaderNodeBsdfGlass")
    glass.inputs["Roughness"].default_value, glass.inputs["IOR"].default_value = 0.0, 1.5
    tree.links.new(glass.outputs[0], tree.get_output_node("ALL").inputs["Surface"])
    yield 0.5
    shot("material")
    # Step 5.
    lamp = bpy.data.objects["Light"]
    bpy.context.view_layer.objects.active = lamp
    yield 0.5
    properties.spaces.active.context = "DATA"
    lamp.data.shadow_soft_size = 0.05
    yield 0.5
    shot("lamp")
    # Step 6.
    scene.photon_map.passes = PASSES
    scene.render.resolution_percentage = 25
    ended: list[float] = []
    bpy.app.handlers.render_complete.append(lambda *_: ended.append(time.monotonic()))
    begin = time.monotonic()
    yield from press("F12")
    while not ended:
        assert time.monotonic() - begin < PATIENCE, "F12 does not end"
        yield 0.5
    yield 1.0
    shot("f12")
    scene.render.image_settings.file_format = "PNG"
    bpy.data.images["Render Result"].save_render(str(folder / "caustic.png"))
    found = {"seconds": round(ended[0] - begin, 1), **brightness(folder / "caustic.png")}
    (folder / "found.json").write_text(json.dumps(found))
    assert found["spot"] > 1.3 * found["floor"] > 2.6 * found["shadow"], found


def brightness(path: Path) -> dict[str, float]:
    """The picture where the sphere focuses the lamp, in its shadow, and beside that."""
    import bpy
    import numpy as np
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

    image = bpy.data.images.load(str(path))
    width, height = image.size
    pixels = np.array(image.pixels[:]).reshape(height, width, -1)[..., :3].mean(axis=2)
    scene = bpy.context.scene

    def around(place: Any, size: int) -> Any:
        x, y, _ = world_to_camera_view(scene, scene.camera, place)
        column, row = int(x * width), int(y * height)
        return pixels[row - size : row + size + 1, column - size : column + size + 1]

    lamp, ball = scene.objects["Light"].location, Vector((0.0, 0.0, 1.0))
    way = (ball - lamp).normalized()
    centre = ball + way * (-ball.z / way.z)
    along = Vector((way.x, way.y, 0.0)).normalized()
    # Across the light the shadow is as wide as the sphere; towards its rim it is dark, as glass
    # bends the light away from there.
    across = along.cross(Vector((0.0, 0.0, -1.0)))
    return {
        "spot": float(around(centre, 8).max()),
        "shadow": float(np.median(around(centre + 0.85 * across, 1))),
        "floor": float(np.median(around(centre + 2.5 * across, 3))),
    }


def run_in_blender(folder: Path) -> None:
    """Have a timer take the steps; leave Blender after the last one."""
    import bpy

    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.view.render_display_type = "AREA"
    steps: list[Iterator[float]] = []

    def step() -> float | None:
        try:
            if not steps:
                steps.append(walk(folder))
            return next(steps[0])
        except StopIteration:
            print(DONE, flush=True)
        except BaseException:
            traceback.print_exc()
        bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(step, first_interval=3.0, persistent=True)


def main() -> None:
    """Outside of Blender: an empty profile and the archive; look at what came out."""
    from acceptance import (  # type: ignore[import-not-found]
        ROOT,
        Blender,
        check,
        fitting_archive,
    )
    from PIL import Image
    from window_test import start_display  # type: ignore[import-not-found]
    from xwd import read_xwd  # type: ignore[import-not-found]

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("blender")
    parser.add_argument("--xvfb", default="Xvfb", help="command that starts Xvfb")
    parser.add_argument("--shots", type=Path, default=ROOT / "renders/guide")
    chosen = parser.parse_args()
    out = chosen.shots
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="photon_map_guide_") as name:
        folder = Path(name)
        blender = Blender(chosen.blender, folder)
        probed = blender.probe("--factory-startup")
        archive = fitting_archive(probed, folder)
        shutil.copy(Path(__file__), folder)
        server, display = start_display(chosen.xvfb, *SIZE)
        blender.environment |= {
            "DISPLAY": display,
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "GUIDE_WALK_FOLDER": str(folder),
            "GUIDE_WALK_ARCHIVE": str(archive),
        }
        try:
            shown = blender.run(
                "--enable-event-simulate", "--window-geometry", "0", "0", *map(str, SIZE),
                "-P", str(folder / Path(__file__).name),
            )  # fmt: skip
        finally:
            server.terminate()
            server.wait()
        for dump in sorted(folder.glob("*.xwd")):
            Image.fromarray(read_xwd(dump)).save(out / f"{dump.stem}.png")
        if (folder / "caustic.png").is_file():
            shutil.copy(folder / "caustic.png", out)
        check(DONE in shown, f"the walk did not come to its end:\n{shown}")
        print(f"Blender {probed['version']}: {(folder / 'found.json').read_text()}")


if "bpy" in sys.modules:
    run_in_blender(Path(os.environ["GUIDE_WALK_FOLDER"]))
elif __name__ == "__main__":
    main()
