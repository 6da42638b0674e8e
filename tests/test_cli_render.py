"""The command line with the real engine on small saved scenes, in a process of its own."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.dump import save_scene
from photon_map.core.scene.scene import Scene
from photon_map.core.settings import Settings
from tests.scenes import camera, cornell_glass, floor_scene

COMMAND = [sys.executable, "-m", "photon_map.cli"]
#: The first render of a machine compiles the kernels.
LONGEST = 420
#: Seconds from Ctrl-C to the end: 0.5 for the render, the rest for writing and leaving.
CTRL_C = 10
README = Path(__file__).parents[1] / "README.md"


def saved(path: Path, scene: Scene, **settings: object) -> Path:
    save_scene(path, scene, Settings(**settings))
    return path


def run(folder: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [*COMMAND, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, cwd=folder)


def channels(path: Path) -> dict[str, np.ndarray]:
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels.copy() for name, channel in file.channels().items()}


def test_layers_add_up_and_the_report_counts(tmp_path: Path):
    saved(tmp_path / "box.npz", cornell_glass(16), passes=4, pixel_filter="BOX")
    done = run(
        tmp_path, "render", "box.npz", "-o", "b.exr", "-o", "b.png", "--report", "b.json"
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert sorted(os.listdir(tmp_path)) == [
        "b.csv",
        "b.exr",
        "b.json",
        "b.png",
        "b.svg",
        "box.npz",
    ]
    pixels = channels(tmp_path / "b.exr")
    for letter in "RGB":
        parts = [pixels[f"{name}.{letter}"] for name in ("emission", "direct", "caustics")]
        total = sum(parts) + pixels[f"indirect.{letter}"]
        # Each layer is rounded to float32 by itself.
        np.testing.assert_allclose(total, pixels[letter], rtol=1e-5, atol=1e-6)
    assert pixels["caustics.R"].max() > 0
    assert pixels["depth.Z"].shape == (16, 16)
    report = json.loads((tmp_path / "b.json").read_text())
    assert (report["passes"], report["width"], report["height"]) == (4, 16, 16)
    assert report["photons_emitted"] > 0
    assert report["photons_stored"] > 0
    assert report["rays"] > 16 * 16 * 4
    assert report["non_finite"] == 0
    assert report["curve"][-1]["pass"] == 4
    assert 0 < report["relative_error"] == report["curve"][-1]["relative_error"]
    assert report["noise"] > 0 and report["bias"] >= 0
    squares = report["noise"] ** 2 + report["bias"] ** 2
    assert report["relative_error"] ** 2 == pytest.approx(squares, rel=1e-9)
    rows = (tmp_path / "b.csv").read_text().splitlines()
    assert rows[0] == "pass,seconds,relative_error,noise,bias"
    assert rows[-1].startswith("4,") and len(rows) == len(report["curve"]) + 1
    plot = ElementTree.parse(tmp_path / "b.svg").getroot()
    assert plot.tag.endswith("svg")
    drawn = next(e for e in plot.iter() if e.get("id") == "noise and bias")
    known = [point for point in report["curve"] if point["relative_error"] is not None]
    assert len(drawn.findall(".//{*}use")) == len(known) >= 1
    assert pixels["error.V"].shape == (16, 16) and pixels["error.V"].min() > 0
    assert {stage["stage"] for stage in report["plan"] if stage["on"]} >= {"direct", "caustics"}
    with Image.open(tmp_path / "b.png") as image:
        assert image.size == (16, 16)
        assert len(np.unique(np.asarray(image))) > 50


def test_short_of_memory_there_are_fewer_photons_and_one_warning(tmp_path: Path):
    saved(tmp_path / "box.npz", cornell_glass(8), passes=2, photons_global=60_000)
    done = run(
        tmp_path, "render", "box.npz", "-o", "b.exr", "--memory", 16, "--report", "b.json"
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("more than 16 MB") == 1
    report = json.loads((tmp_path / "b.json").read_text())
    assert 0 < report["photon_megabytes"] < 16
    assert report["photons_emitted"] < 2 * 60_000
    refused = run(tmp_path, "render", "box.npz", "-o", "c.exr", "--memory", 1)
    assert refused.returncode == 2
    assert "photon_memory is 1, it must be from 16" in refused.stderr


def test_threads_change_no_bit_and_the_seed_does(tmp_path: Path):
    saved(tmp_path / "box.npz", cornell_glass(12), passes=2)
    for name, *arguments in (("a", "--threads", 1), ("b", "--threads", 2), ("c", "--seed", 1)):
        done = run(tmp_path, "render", "box.npz", "-o", f"{name}.exr", *arguments)
        assert done.returncode == 0, done.stderr
    a, b, c = (channels(tmp_path / f"{name}.exr") for name in "abc")
    assert all(a[name].tobytes() == b[name].tobytes() for name in a)
    assert a["R"].tobytes() != c["R"].tobytes()


@pytest.mark.parametrize(
    ("arguments", "key", "most"),
    [
        # Past the limit a chunk may still end; a machine that does other work needs room.
        (["--seconds", "1"], "seconds", 3.0),
        (["--error", "0.5"], "relative_error", 0.5),
    ],
)
def test_it_stops_at_the_limit(arguments: list[str], key: str, most: float, tmp_path: Path):
    saved(tmp_path / "box.npz", cornell_glass(16), passes=1)
    done = run(tmp_path, "render", "box.npz", "-o", "a.png", "--report", "r.json", *arguments)
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "r.json").read_text())
    assert report[key] <= most
    assert report["passes"] > 1


def test_a_scene_without_camera_is_an_error(tmp_path: Path):
    builder = SceneBuilder("attic")
    builder.add_point_light("lamp", (0, 0, 0), 1.0)
    saved(tmp_path / "attic.npz", builder.build())
    done = run(tmp_path, "render", "attic.npz", "-o", "a.png")
    assert done.returncode == 1
    assert re.fullmatch(r"photonmap: error: .*'attic' has no camera.*\n", done.stderr)
    assert os.listdir(tmp_path) == ["attic.npz"]


def test_without_light_it_warns_and_renders_black(tmp_path: Path):
    builder = floor_scene([], size=4)
    saved(tmp_path / "dark.npz", builder.build(), passes=1)
    done = run(tmp_path, "render", "dark.npz", "-o", "a.exr")
    assert done.returncode == 0, done.stderr
    assert "warning" in done.stderr
    assert "no light" in done.stderr
    pixels = channels(tmp_path / "a.exr")
    assert not any(pixels[letter].any() for letter in "RGB")
    assert (pixels["A"] == 1).all()


def test_an_empty_scene_shows_its_background(tmp_path: Path):
    builder = SceneBuilder("empty")
    builder.set_world((0.25, 0.5, 1.0))
    builder.set_camera(camera((0, 0, 1), (0, 0, 0), 4, 3, up=(0, 1, 0)))
    saved(tmp_path / "empty.npz", builder.build(), passes=1)
    done = run(tmp_path, "render", "empty.npz", "-o", "a.exr")
    assert done.returncode == 0, done.stderr
    assert "no faces" in done.stderr
    pixels = channels(tmp_path / "a.exr")
    for letter, value in zip("RGB", (0.25, 0.5, 1.0), strict=True):
        np.testing.assert_allclose(pixels[letter], value, rtol=1e-6)


def test_plan_of_a_saved_scene(tmp_path: Path):
    saved(tmp_path / "box.npz", cornell_glass(8))
    done = run(tmp_path, "plan", "box.npz")
    assert done.returncode == 0, done.stderr
    rows = [
        re.fullmatch(r"(\w+(?: \w+)?) +(on |off)  (.+)", line)
        for line in done.stdout.splitlines()
    ]
    assert all(rows)
    assert {row[1] for row in rows if row and row[2] == "on "} >= {"direct", "caustics"}


def test_ctrl_c_writes_the_picture_so_far(tmp_path: Path):
    scene = cornell_glass(16)
    assert scene.camera is not None
    bigger = replace(scene, camera=replace(scene.camera, width=64, height=64))
    saved(tmp_path / "box.npz", bigger)
    command = [*COMMAND, "render", "box.npz", "-o", "a.png", "--seconds", "300"]
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
            _, stderr = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 130, stderr
    assert time.monotonic() - begin < CTRL_C
    assert sorted(os.listdir(tmp_path)) == ["a.png", "box.npz"]


def test_the_python_of_the_readme_runs(tmp_path: Path):
    blocks = re.findall(r"```python\n(.*?)```", README.read_text("utf-8"), re.DOTALL)
    assert len(blocks) == 1
    code = blocks[0] + "\nassert pixels.shape == (48, 64, 4) and pixels[..., 3].max() == 1"
    command = [sys.executable, "-c", code]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=LONGEST, cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr


def test_the_readme_names_every_option_and_no_other(tmp_path: Path):
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", README.read_text("utf-8")))
    commands = ("render", "bake", "photons", "plan")
    texts = [run(tmp_path, name, "--help").stdout for name in commands]
    known = set(re.findall(r"--[a-z][a-z-]+", "".join(texts)))
    assert named == known - {"--help", "--output"}
