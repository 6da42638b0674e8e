"""The arithmetic of `make bench`: curves, references and the scenes handed to the peers."""

from __future__ import annotations

import argparse
import json
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


def rows(run: Any, points: list[tuple[float, float]], deviation: float = 0.0) -> list[Any]:
    return [
        run.Row("s", "e", t, error, deviation, 1.0, 0.0, 0.0, "v", 0.0) for t, error in points
    ]


def test_times_and_errors_lie_on_straight_lines_in_the_logarithms(bench):
    run = bench("speed_run")
    curve = rows(run, [(1.0, 0.04), (4.0, 0.01), (16.0, 0.0025)])
    assert run.time_to(curve, 0.02).seconds == pytest.approx(2.0)
    assert run.time_to(curve, 0.005).seconds == pytest.approx(8.0)
    assert run.time_to(curve, 0.001) == (np.inf, False)
    assert run.time_to(curve, 0.05) == (1.0, True)
    assert run.time_to([], 0.05) == (np.inf, False)
    assert run.error_at(curve, 2.0).error == pytest.approx(0.02)
    assert np.isnan(run.error_at(curve, 30.0).error)
    assert run.slope(curve) == pytest.approx(-1.0)


def test_a_curve_that_comes_back_up_counts_from_its_last_crossing(bench):
    run = bench("speed_run")
    curve = rows(run, [(1.0, 0.02), (2.0, 0.005), (4.0, 0.02), (8.0, 0.005)])
    assert 4.0 < run.time_to(curve, 0.01).seconds < 8.0
    assert run.time_to(curve[:3], 0.01).seconds == np.inf


def test_a_crossing_in_the_reference_s_noise_is_not_told(bench):
    run = bench("speed_run")
    points = [(1.0, 0.04), (4.0, 0.01), (16.0, 0.0025), (64.0, 0.0006)]
    curve = rows(run, points, deviation=4e-4)
    # Known to 16 % of 0.0025: too little there, but the last point is surely below.
    assert run.time_to(curve, 0.01).seconds == pytest.approx(4.0)
    assert run.time_to(curve, 0.0025) == (64.0, True)
    assert np.isnan(run.time_to(curve, 0.0006).seconds)
    # Surely above is told, too.
    assert run.time_to(curve[:3], 1e-3).seconds == np.inf
    assert np.isnan(run.time_to(rows(run, points[:3], deviation=1e-3), 1e-3).seconds)


def noisy_parts(random: np.random.Generator, truth: Any, tails: bool) -> Any:
    """Three parts, relMSE 0.01 each; with ``tails`` 0.014, 2/3 of it by rare bright pixels."""
    shape = (3, *truth.shape)
    noise = 0.1 * truth * random.normal(size=shape)
    if tails:
        # One pixel in 500 has a mean of 1.5 of its neighbours more; all others less.
        bright = random.random((3, *truth.shape[:2], 1)) < 0.002
        noise = 0.07 * truth * random.normal(size=shape)
        noise += truth * 1.5 * (bright * random.exponential(1.0, bright.shape) - 0.002)
    return truth + noise


@pytest.mark.parametrize("tails", [False, True])
@pytest.mark.parametrize("wrong", [0.2, 0.05, 0.01])
def test_the_noise_of_a_reference_is_taken_off(bench, tails, wrong):
    """Over 60 references the mean estimate is the true relMSE, and the standard error that
    each states holds the truth as often as it should, or more often."""
    error = bench("speed_error")
    random = np.random.default_rng(3)
    y, x = np.mgrid[0:64, 0:64] / 64.0
    truth = (0.05 + x + (abs(y - 0.5) < 0.05) * 2.0)[..., None] * np.array([1.0, 0.8, 0.6])
    image = truth * (1.0 + wrong * np.sin(9 * y + 7 * x)[..., None])
    weight = truth**2 + 0.01 * truth.mean() ** 2
    wanted = float(((image - truth) ** 2 / weight).mean())
    work = np.array([1.0, 1.5, 1.2])
    found, deviations = [], []
    for _ in range(60):
        reference = error.Reference(noisy_parts(random, truth, tails), work, {})
        estimate = reference.error(image)
        found.append(estimate.error)
        deviations.append(estimate.deviation)
    scatter = float(np.std(found, ddof=1))
    # Three standard errors, and the second order of the weight's own noise, 3 % of 0.01.
    assert np.mean(found) == pytest.approx(wanted, abs=3 * scatter / 60**0.5 + 0.03 * wanted)
    # The deviations are not too small, and at most twice too large (see ``Reference.error``).
    assert 0.8 < np.sqrt(np.mean(np.square(deviations))) / scatter < 2.3
    inside = np.abs(np.array(found) - wanted) <= 2 * np.array(deviations) + 0.03 * wanted
    assert inside.mean() >= 0.9


def test_a_reference_is_not_judged_by_its_own_noise_alone(bench):
    """An image that is right has an error of 0 within its deviation, and no reference of a
    finite noise says otherwise."""
    error = bench("speed_error")
    random = np.random.default_rng(4)
    truth = np.ones((64, 64, 3))
    reference = error.Reference(noisy_parts(random, truth, True), np.ones(3), {})
    found = reference.error(truth)
    assert abs(found.error) < 2 * found.deviation < 0.1 * reference.noise
    # 0.0049 and 2 * 0.002 * 1.5^2 of a part.
    assert reference.noise == pytest.approx(0.0139 / 3 / 1.01, rel=0.3)


def test_sums_know_their_own_error_and_are_kept(bench, tmp_path):
    reference = bench("speed_reference")
    random = np.random.default_rng(5)
    sums = reference.Sums.open(tmp_path, "scene", "engine", "key")
    for k in range(18):
        work = 1.0 + k % 2
        sums.add(1.0 + 0.2 * random.normal(size=(32, 32, 3)) / work**0.5, work)
    assert sums.work.sum() == 27.0 and np.ptp(sums.work) <= 2.0
    assert sums.error == pytest.approx(0.2**2 / 27 / 1.01, rel=0.1)
    again = reference.Sums.open(tmp_path, "scene", "engine", "key")
    assert (again.chunks, again.error) == (18, sums.error)
    assert reference.Sums.open(tmp_path, "scene", "engine", "other key").chunks == 0


def test_all_references_reach_a_step_before_one_goes_on(bench, tmp_path):
    reference = bench("speed_reference")

    def making(relative: float, work: float) -> Any:
        sums = sums_of(reference, tmp_path, relative, work)
        return reference.Making(None, "", {"e": sums}, {"e": np.ones((8, 8), bool)})

    # A part's variance is relative^2: relMSE relative^2 / 3, but for the weights' noise.
    rough, rougher, good = making(0.2, 10.0), making(0.4, 10.0), making(0.1, 10.0)
    assert rough.error == pytest.approx(0.2**2 / 3 / 1.01, rel=0.1)
    assert reference.next_one([rougher, rough, good]) is rough
    assert reference.next_one([rougher, good]) is rougher
    assert reference.next_one([good]) is good
    assert reference.next_one([making(0.01, 10.0)]) is None


def sums_of(reference: Any, folder: Path, relative: float, work: float) -> Any:
    """Three parts of 8x8 pixels, 1 - ``relative``, 1 and 1 + ``relative``."""
    offsets = np.array([-1.0, 0.0, 1.0])[:, None, None, None] * np.ones((1, 8, 8, 3))
    parts = 1.0 + relative * offsets
    each = np.full(3, work)
    return reference.Sums(folder, "", parts * each[:, None, None, None], each, 3)


def test_each_pixel_of_a_reference_is_of_its_own_judge(bench, tmp_path):
    reference = bench("speed_reference")
    left = np.arange(8) < np.full((8, 1), 2)
    sums = {
        "glass": sums_of(reference, tmp_path, 0.3, 20.0),
        "floor": sums_of(reference, tmp_path, 0.1, 10.0),
    }
    making = reference.Making(None, "", sums, {"glass": left, "floor": ~left})
    assert making.parts[2, :, :2] == pytest.approx(1.3)
    assert making.parts[2, :, 2:] == pytest.approx(1.1)
    # A quarter of the pixels by the one, three quarters by the other.
    errors = making.errors()
    assert errors["glass"] == pytest.approx(0.25 * 0.3**2 / 3 / 1.01, rel=0.2)
    assert errors["floor"] == pytest.approx(0.75 * 0.1**2 / 3 / 1.01, rel=0.2)
    assert making.work == pytest.approx(30.0)
    # 0.0075 by 60 s against 0.0025 by 30 s.
    assert making.next_engine == "glass"
    sums["floor"].work[2] = 0.0
    assert making.next_engine == "floor" and making.error == np.inf


def test_pixels_beside_glass_are_not_for_the_light_tracer(bench):
    parts = bench("speed_parts").parts_of(bench("speed_caustics").point_light())
    mask = bench("speed_first_hits").diffuse_pixels(parts)
    # The ball's middle, the floor before it, and what is above the floor's end.
    assert not mask[47, 42] and mask[110, 42] and mask[2, 64]
    assert 0.8 < mask.mean() < 0.86


def test_light_paths_of_a_sun_come_from_within_its_disk(bench):
    parts = bench("speed_parts")
    sun = parts.parts_of(bench("speed_caustics").nephroid()).lamps[0]
    random = np.random.default_rng(3)
    frames = np.array([parts.sun_frame(sun, random)[:3, :3] for _ in range(400)])
    assert frames @ frames.transpose(0, 2, 1) == pytest.approx(
        np.tile(np.eye(3), (400, 1, 1)), abs=1e-9
    )
    assert np.linalg.det(frames) == pytest.approx(1.0)
    sine = np.linalg.norm(np.cross(frames[:, :, 2], sun["axis_z"]), axis=1)
    most = np.sin(sun["angle"] / 2)
    assert (frames[:, :, 2] @ sun["axis_z"] < 0).all() and sine.max() <= most * 1.001
    # Even over the disk: the mean square of the radius is half the greatest.
    assert (sine**2).mean() == pytest.approx(most**2 / 2, rel=0.1)


def test_parts_are_kept_as_halves(bench, tmp_path):
    reference = bench("speed_reference")
    parts = np.random.default_rng(6).random((3, 8, 8, 3)) + 0.5
    reference.write_parts(tmp_path / "a.exr", parts)
    assert reference.read_parts(tmp_path / "a.exr") == pytest.approx(parts, rel=1e-3)


def test_a_stored_reference_of_one_judge_is_gone_on_with(bench, tmp_path, monkeypatch):
    reference = bench("speed_reference")
    monkeypatch.setattr(reference, "FOLDER", tmp_path)
    parts = np.random.default_rng(6).random((3, 8, 8, 3)) + 0.5
    facts = {
        "digest": "1",
        "work": [1.0, 2.0, 3.0],
        "judges": {"a": {"engine": "A 1", "chunks": 5}},
    }
    reference.write_parts(tmp_path / "scene.exr", parts)
    (tmp_path / "scene.json").write_text(json.dumps(facts))

    def taken(fingerprint: str, engine: str) -> Any:
        sums = reference.Sums.open(tmp_path / "state", "scene", engine, "key")
        sums.take_stored("scene", fingerprint, engine)
        return sums

    assert taken("1", "a").parts == pytest.approx(parts, rel=1e-3)
    assert (taken("1", "a").chunks, taken("1", "a").version) == (5, "A 1")
    assert taken("2", "a").chunks == taken("1", "b").chunks == 0


def test_the_runs_are_planned_within_their_minutes(bench):
    speed, cases = bench("speed"), bench("speed_cases").CASES.values()
    whole = argparse.Namespace(quick=False, engines=None, seconds=None)
    assert 20 * 60 < speed.planned(list(cases), whole) < 28 * 60
    quick = argparse.Namespace(quick=True, engines=None, seconds=None)
    assert speed.planned([case for case in cases if case.quick], quick) < 4 * 60


def told(run: Any, points: list[tuple[int, float, float]], doubt: float = 0.0) -> list[Any]:
    """Rows of passes, true and stated error."""
    return [
        run.Row(
            "s", "e", passes / 10, true**2, doubt * true**2, 1.0, 0.0, 0.0, "v", 0.0,
            passes=passes, stated=stated,
        )
        for passes, true, stated in points
    ]  # fmt: skip


def test_the_stated_error_is_held_against_the_true_one(bench):
    run, calibration = bench("speed_run"), bench("speed_calibration")
    rows = told(
        run, [(4, 0.9, 0.1), (8, 0.2, 0.1), (9, 0.1, 0.1), (17, 0.08, 0.08), (50, 1, 1)]
    )
    # One image for each power of two from 8 on, and none at 50 passes.
    assert [row.passes for row in calibration.points(rows)] == [8, 17]
    assert calibration.ratio(rows[1]) == pytest.approx(2.0)
    assert np.isnan(calibration.ratio(told(run, [(8, 0.2, 0.1)], doubt=0.2)[0]))
    section = "\n".join(
        calibration.calibration_section(
            {"pool": {"photonmap": run.Run("pool", "", tuple(rows))}}
        )
    )
    assert "1 of 2 points (50 %)" in section and "**2.00**" in section


def test_the_true_error_at_the_goal_lies_between_its_neighbours(bench):
    run, calibration = bench("speed_run"), bench("speed_calibration")
    rows = told(run, [(8, 0.12, 0.1), (32, 0.06, 0.05), (64, 0.03, 0.025)])
    assert calibration.at_goal(rows) == pytest.approx(0.06)
    assert calibration.at_goal(rows, 0.05**0.5 * 0.1**0.5) == pytest.approx(1.2 * 0.005**0.5)
    assert np.isnan(calibration.at_goal(rows, 0.01))


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
        assert size < 300_000
