"""``photonmap photons``: a cloud that other programs can read, and a picture."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner, Result

from photon_map import cli
from photon_map.core.scene.dump import save_scene
from photon_map.core.settings import Settings
from tests.scenes import cornell_glass


@pytest.fixture(scope="module")
def scene_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("photons") / "box.npz"
    save_scene(path, cornell_glass(24), Settings(photons_global=500, photons_caustic=500))
    return path


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli.app, ["photons", *map(str, arguments)])


def read_ply(path: Path) -> tuple[list[str], np.ndarray]:
    """The header's comments and the table of a binary PLY, read by its own words."""
    head, _, body = path.read_bytes().partition(b"end_header\n")
    lines = head.decode("ascii").splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    types = {"float": "<f4", "uchar": "u1", "int": "<i4"}
    words = [line.split() for line in lines]
    columns = [(word[2], types[word[1]]) for word in words if word[0] == "property"]
    (count,) = [int(word[2]) for word in words if word[0] == "element"]
    table = np.frombuffer(body, np.dtype(columns))
    assert len(table) == count
    return [line[8:] for line in lines if line.startswith("comment ")], table


@pytest.mark.parametrize("color", ["power", "bounce", "caster", "light"])
def test_a_cloud_has_every_photon(color: str, scene_file: Path, tmp_path: Path):
    path = tmp_path / "points.ply"
    done = run(scene_file, "-o", path, "--color", color)
    assert done.exit_code == 0, done.output
    comments, points = read_ply(path)
    assert f"{len(points)} photons: wrote" in done.output
    assert any(line.startswith("caster ") and line.endswith("glass ball") for line in comments)
    assert max(abs(points[axis]).max() for axis in "xyz") < 1.0 + 1e-5
    assert set(points["caustic"]) == {0, 1} and points["power"].min() > 0
    shades = np.stack([points[name] for name in ("red", "green", "blue")], axis=1)
    different = len(np.unique(shades, axis=0))
    assert different == 1 if color == "light" else different > 2


def test_kinds_and_counts_are_heard(scene_file: Path, tmp_path: Path):
    assert run(scene_file, "-o", tmp_path / "a.ply", "--kind", "caustic").exit_code == 0
    done = run(
        scene_file, "-o", tmp_path / "b.ply", "--kind", "caustic", "--count", "2000",
        "--color", "caster",
    )  # fmt: skip
    few, many = (read_ply(tmp_path / name)[1] for name in ("a.ply", "b.ply"))
    assert few["caustic"].all() and 2 * len(few) < len(many)
    assert "glass ball" in done.output and "mirror ball" in done.output


def test_a_picture_shows_photons_on_black(scene_file: Path, tmp_path: Path):
    both = "-o", tmp_path / "a.png", "-o", tmp_path / "a.ply"
    done = run(scene_file, *both, "--size", "40x30")
    assert done.exit_code == 0 and f"a.png, {tmp_path / 'a.ply'}" in done.output, done.output
    assert f"{len(read_ply(tmp_path / 'a.ply')[1])} photons" in done.output
    with Image.open(tmp_path / "a.png") as image:
        pixels = np.asarray(image)
    assert pixels.shape == (30, 40, 3)
    lit = pixels.max(axis=2) > 0
    assert 0.1 < lit.mean() < 1.0


def test_a_pixel_tells_its_discs_and_the_paths_of_their_photons(
    scene_file: Path, tmp_path: Path
):
    """The middle of the lower edge of the picture shows the floor."""
    done = run(scene_file, "--at", "12,22", "--count", "20000")
    assert done.exit_code == 0, done.output
    assert done.output.startswith("'floor' at (")
    global_ = next(line for line in done.output.splitlines() if line.startswith("global: "))
    assert int(global_.split()[1]) > 3 and "W/m^2" in global_
    path = tmp_path / "paths.ply"
    done = run(
        scene_file, "--at", "12,22", "--count", "20000", "--kind", "global", "-o", path
    )  # fmt: skip
    assert done.exit_code == 0 and "caustic: " not in done.output, done.output
    vertices, edges = read_paths(path)
    chains = len(vertices) - len(edges)
    assert f"{chains} paths: wrote" in done.output and chains == int(global_.split()[1])
    assert (edges["vertex2"] == edges["vertex1"] + 1).all()
    ends = np.setdiff1d(np.arange(len(vertices)), edges["vertex1"])
    assert abs(vertices["y"][ends] - vertices["y"][ends].mean()).max() < 1e-5 or (
        abs(vertices["z"][ends] - vertices["z"][ends].mean()).max() < 1e-5
    ), "all paths end on the floor"


def read_paths(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and edges of a PLY of paths."""
    head, _, body = path.read_bytes().partition(b"end_header\n")
    corner = [("x", "<f4"), ("y", "<f4"), ("z", "<f4")]
    corner += [("red", "u1"), ("green", "u1"), ("blue", "u1")]
    lines = head.decode("ascii").splitlines()
    counts = {line.split()[1]: int(line.split()[2]) for line in lines if "element" in line}
    vertices = np.frombuffer(body, np.dtype(corner), counts["vertex"])
    edge = np.dtype([("vertex1", "<i4"), ("vertex2", "<i4")])
    edges = np.frombuffer(body, edge, counts["edge"], vertices.nbytes)
    assert len(body) == vertices.nbytes + edges.nbytes
    return vertices, edges


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--at", "99,2"], "pixel 99,2 is outside of 24x24"),
        (["--at", "3"], "is not like 120,80"),
        (["--at", "3,4", "-o", "a.png"], "paths are written to a .ply"),
        ([], "-o or --at is needed"),
    ],
)
def test_a_pixel_that_is_none_is_said(arguments: list[str], words: str, scene_file: Path):
    done = run(scene_file, *arguments)
    assert done.exit_code in (1, 2)
    assert words in " ".join(done.output.replace("│", " ").split())


def test_what_cannot_be_written_is_said(scene_file: Path, tmp_path: Path):
    done = run(scene_file, "-o", tmp_path / "a.obj")
    assert done.exit_code == 1 and "a .ply or a .png" in done.output
    assert run(scene_file, "-o", tmp_path / "no" / "a.ply").exit_code == 1
    assert os.listdir(tmp_path) == []
