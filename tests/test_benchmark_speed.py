"""The arithmetic of `make bench`: curves, references and the scenes handed to the peers."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from photon_map.core import SceneBuilder, SceneError
from photon_map.core.scene.lobes import diffuse, phong
from tests.scenes import camera, plane


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Imports a script of the benchmarks by its name."""
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "benchmarks"))
    yield import_module
    for name in [n for n in sys.modules if n.startswith("speed") or n == "measure"]:
        del sys.modules[name]


def rows(run: Any, points: list[tuple[float, float]]) -> list[Any]:
    return [run.Row("s", "e", t, error, 1.0, 0.0, 0.0, "v", 0.0) for t, error in points]


def test_times_and_errors_lie_on_straight_lines_in_the_logarithms(bench):
    run = bench("speed_run")
    curve = rows(run, [(1.0, 0.04), (4.0, 0.01), (16.0, 0.0025)])
    assert run.time_to(curve, 0.02) == pytest.approx(2.0)
    assert run.time_to(curve, 0.005) == pytest.approx(8.0)
    assert run.time_to(curve, 0.001) == np.inf
    assert run.error_at(curve, 2.0) == pytest.approx(0.02)
    assert np.isnan(run.error_at(curve, 30.0))
    assert run.slope(curve) == pytest.approx(-1.0)


def test_a_curve_that_comes_back_up_counts_from_its_last_crossing(bench):
    run = bench("speed_run")
    curve = rows(run, [(1.0, 0.02), (2.0, 0.005), (4.0, 0.02), (8.0, 0.005)])
    assert 4.0 < run.time_to(curve, 0.01) < 8.0
    assert run.time_to(curve[:3], 0.01) == np.inf


def test_the_noise_of_a_reference_is_taken_off(bench):
    reference = bench("speed_reference")
    random = np.random.default_rng(3)
    shape, truth = (64, 64, 3), 1.0
    noisy = truth + 0.03 * random.normal(size=shape)
    image = truth + 0.05 * random.normal(size=shape)
    noise = 0.03**2 / 1.01
    found = reference.Reference(noisy, noise, {}).error(image)
    # 12288 values of variance 0.0034 / 1.01: standard error 4.3e-5; and 9 noise^2 of bias.
    assert found == pytest.approx(0.05**2 / 1.01, abs=2e-4)


def test_sums_know_their_own_error_and_are_kept(bench, tmp_path):
    reference = bench("speed_reference")
    random = np.random.default_rng(5)
    sums = reference.Sums.open(tmp_path, "scene", "engine", "key")
    for _ in range(16):
        sums.add(1.0 + 0.2 * random.normal(size=(32, 32, 3)), 2.0)
    assert sums.error == pytest.approx(0.2**2 / 16 / 1.01, rel=0.1)
    again = reference.Sums.open(tmp_path, "scene", "engine", "key")
    assert (again.chunks, again.seconds, again.error) == (16, 32.0, sums.error)
    assert reference.Sums.open(tmp_path, "scene", "engine", "other key").chunks == 0


def test_every_scene_has_words_that_all_engines_know(bench):
    cases, parts = bench("speed_cases"), bench("speed_parts")
    for name, case in cases.CASES.items():
        if name == "million":
            continue
        scene = case.build()
        found = parts.parts_of(scene)
        assert sum(len(s.faces) for s in found.surfaces) == len(scene.faces)
        for surface in found.surfaces:
            assert surface.faces.max() < len(surface.vertices)
        low = np.min([s.vertices.min(axis=0) for s in found.surfaces], axis=0)
        assert low == pytest.approx(scene.vertices.min(axis=0), abs=1e-5)


def test_what_the_peers_do_not_know_is_refused(bench):
    parts = bench("speed_parts")
    b = SceneBuilder("phong")
    b.add_mesh("floor", *plane(), b.add_material("shiny", [phong(0.5, 20.0)]))
    b.set_camera(camera((0, 0, 3), (0, 0, 0), 8, 8, up=(0, 1, 0)))
    with pytest.raises(SceneError, match="shiny"):
        parts.parts_of(b.build())
    b = SceneBuilder("spot")
    b.add_mesh("floor", *plane(), b.add_material("white", [diffuse(0.5)]))
    b.add_spot_light("spot", np.eye(4), 1.0, 0.5)
    b.set_camera(camera((0, 0, 3), (0, 0, 0), 8, 8, up=(0, 1, 0)))
    with pytest.raises(SceneError, match="lamps"):
        parts.parts_of(b.build())


def test_the_references_are_of_the_scenes(bench):
    cases, reference = bench("speed_cases"), bench("speed_reference")
    for name in cases.CASES:
        found = reference.load(name)
        assert np.isfinite(found.image).all() and found.image.shape == (128, 128, 3)
        assert found.noise > 0
        size = (reference.FOLDER / f"{name}.exr").stat().st_size
        assert size < 100_000
