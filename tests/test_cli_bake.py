"""``photonmap bake`` with the real engine, and renders that find maps beside their scene."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

from photon_map.core.scene.dump import save_scene
from photon_map.core.settings import Settings
from tests.scenes import cornell_glass, look_at
from tests.test_cli_render import LONGEST

SETTINGS = Settings(passes=2, photons_global=1000, photons_caustic=1000)


def run(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "photon_map.cli", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, cwd=folder)


def rendered(folder: Path, *arguments: str) -> tuple[str, dict[str, tuple[bool, str]]]:
    done = run(folder, "render", "box.npz", "-o", "a.png", "--report", "a.json", *arguments)
    assert done.returncode == 0, done.stderr
    plan = json.loads((folder / "a.json").read_text())["plan"]
    return done.stderr, {stage["stage"]: (stage["on"], stage["reason"]) for stage in plan}


def test_maps_beside_the_scene_are_used_until_it_changes(tmp_path: Path):
    scene = cornell_glass(12)
    save_scene(tmp_path / "box.npz", scene, SETTINGS)
    assert "photon maps" not in rendered(tmp_path)[1]
    done = run(tmp_path, "bake", "box.npz", "--passes", "3", "--threads", "2")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("4 passes, ") and "box.pmap" in done.stdout
    moved = replace(scene.camera, matrix=look_at((1, -4, 0), (0, 0, 0)))  # type: ignore[type-var]
    save_scene(tmp_path / "box.npz", replace(scene, camera=moved), SETTINGS)
    stderr, plan = rendered(tmp_path, "--maps", "refuse")
    assert (stderr, plan["photon maps"]) == ("", (True, "4 passes from 'box.pmap'"))
    assert "photon maps" not in rendered(tmp_path, "--maps", "ignore")[1]
    save_scene(tmp_path / "box.npz", replace(scene, world=scene.world + 1), SETTINGS)
    stderr, plan = rendered(tmp_path)
    assert "the world has changed" in stderr and not plan["photon maps"][0]
    done = run(tmp_path, "render", "box.npz", "-o", "b.png", "--maps", "refuse")
    assert done.returncode == 1 and "the world has changed" in done.stderr
    assert not (tmp_path / "b.png").exists()
    assert rendered(tmp_path, "--maps", "rebuild")[1]["photon maps"][0]
    assert rendered(tmp_path)[0] == ""


def test_a_bake_that_cannot_be_written_leaves_nothing(tmp_path: Path):
    save_scene(tmp_path / "box.npz", cornell_glass(8), SETTINGS)
    os.mkdir(tmp_path / "box.pmap")
    done = run(tmp_path, "bake", "box.npz")
    assert done.returncode == 1 and "is not a file" in done.stderr
    done = run(tmp_path, "bake", "missing.npz")
    assert done.returncode == 1 and "there is no file" in done.stderr
    assert sorted(os.listdir(tmp_path)) == ["box.npz", "box.pmap"]
