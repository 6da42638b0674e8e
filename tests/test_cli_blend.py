"""The command line on .blend files: through Blender, the add-on and back, in a new process."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.test_cli_render import COMMAND, CTRL_C, LONGEST, channels, run

pytestmark = pytest.mark.blender

MAKE_SCENE = """
import bpy, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.resolution_x, scene.render.resolution_y = 24, 16
scene.render.resolution_percentage = 100
bpy.ops.mesh.primitive_plane_add(size=4)
bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(0, 0, 1))
lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
lamp.location, lamp.data.energy = (1, -1, 3), 200
scene.collection.objects.link(lamp)
if sys.argv[2] == "camera":
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0, 0, 7)
    scene.collection.objects.link(camera)
    scene.camera = camera
scene.frame_set(1)
lamp.keyframe_insert("location", frame=1)
lamp.location.x = -1
lamp.keyframe_insert("location", frame=2)
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1], compress=True)
"""


def make_blend(path: Path, kind: str) -> Path:
    command = [sys.executable, "-c", MAKE_SCENE, str(path), kind]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert path.exists(), done.stdout + done.stderr
    return path


@pytest.fixture(scope="module")
def blend(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_blend(tmp_path_factory.mktemp("blend") / "room.blend", "camera")


def test_blend_and_saved_scene_give_the_same_bits(blend: Path, tmp_path: Path):
    done = run(
        tmp_path, "render", blend, "-o", "a.png", "-o", "a.exr", "--passes", 2, "--seed", 4,
        "--report", "a.json", "--save-scene", "a.npz",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    names = ["a.csv", "a.exr", "a.json", "a.npz", "a.png", "a.svg"]
    assert sorted(os.listdir(tmp_path)) == names
    report = json.loads((tmp_path / "a.json").read_text())
    assert (report["width"], report["height"], report["passes"]) == (24, 16, 2)
    assert report["seed"] == 4
    done = run(tmp_path, "render", "a.npz", "-o", "b.exr")
    assert done.returncode == 0, done.stderr
    first, second = channels(tmp_path / "a.exr"), channels(tmp_path / "b.exr")
    assert first.keys() == second.keys()
    assert all(first[name].tobytes() == second[name].tobytes() for name in first)
    with Image.open(tmp_path / "a.png") as image:
        picture = np.asarray(image.convert("RGB")).astype(float)
    assert picture.shape == (16, 24, 3)
    # The same rows on top: bright where the EXR is bright.
    assert np.corrcoef(picture[..., 0].ravel(), first["R"].ravel())[0, 1] > 0.7


def test_size_and_frame_are_taken(blend: Path, tmp_path: Path):
    for frame in (1, 2):
        done = run(
            tmp_path, "render", blend, "-o", f"{frame}.exr", "--frame", frame,
            "--size", "12x10", "--passes", 1,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
    first, second = channels(tmp_path / "1.exr"), channels(tmp_path / "2.exr")
    assert first["R"].shape == (10, 12)
    # The lamp wanders from right to left.
    assert first["direct.R"][:, 6:].sum() > first["direct.R"][:, :6].sum()
    assert second["direct.R"][:, 6:].sum() < second["direct.R"][:, :6].sum()


def test_plan_of_a_blend(blend: Path, tmp_path: Path):
    done = run(tmp_path, "plan", blend)
    assert done.returncode == 0, done.stderr
    assert re.search(r"^direct +on ", done.stdout, re.MULTILINE)


def assert_fails(folder: Path, blend: Path, message: str) -> None:
    before = sorted(os.listdir(folder))
    done = run(folder, "render", blend, "-o", "a.png", "-o", "a.exr", "--passes", 1)
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert last.startswith("photonmap: error: ")
    assert message in last
    assert "Traceback" not in done.stderr
    assert sorted(os.listdir(folder)) == before


def test_a_file_that_is_no_blend_fails(tmp_path: Path):
    path = tmp_path / "text.blend"
    path.write_text("not Blender's")
    assert_fails(tmp_path, path, "cannot open")


def test_a_blend_without_camera_fails(tmp_path: Path):
    path = make_blend(tmp_path / "blind.blend", "none")
    assert_fails(tmp_path, path, "no camera")


def test_ctrl_c_keeps_the_picture(blend: Path, tmp_path: Path):
    command = [*COMMAND, "render", str(blend), "-o", "a.png", "-o", "a.exr", "--seconds", "60"]
    with subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        try:
            for line in process.stdout:
                if line.startswith("pass "):
                    break
            begin = time.monotonic()
            process.send_signal(signal.SIGINT)
            _, stderr = process.communicate(timeout=LONGEST)
        finally:
            process.kill()
    assert process.returncode == 130, stderr
    assert time.monotonic() - begin < CTRL_C
    assert sorted(os.listdir(tmp_path)) == ["a.exr", "a.png"]
    assert channels(tmp_path / "a.exr")["R"].max() > 0
    with Image.open(tmp_path / "a.png") as image:
        assert np.asarray(image.convert("RGB")).max() > 0
