from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from photon_map.core.film.stated_error import UNKNOWN, StatedError
from photon_map.core.report import ErrorCurve, completed, render_report
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.settings import Settings
from photon_map.core.version import VERSION


@dataclass
class FakeUpdate:
    """As much of an update as the report reads."""

    passes: int
    seconds: float = 1.0
    error: StatedError = UNKNOWN
    setup_seconds: float = 0.5
    photon_bytes: int = 3 << 19
    film: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(
            width=8, height=6,
            statistics=SimpleNamespace(
                photons_emitted=np.int64(2**33), photons_stored=10, rays=20, non_finite=0
            ),
        )
    )  # fmt: skip
    plan: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(
            stages=(SimpleNamespace(name="caustics", on=np.True_, reason="a caster"),)
        )
    )

    @property
    def relative_error(self) -> float:
        return self.error.relative_error


def test_the_report_has_the_promised_keys_and_is_json():
    curve = ErrorCurve()
    for update in (
        FakeUpdate(0),
        FakeUpdate(1),
        FakeUpdate(1),
        FakeUpdate(3, 2.5, StatedError(0.12, 0.035)),
    ):
        curve.add(update)
    scene = SceneBuilder("box").build()
    settings = Settings(seed=9, threads=2)
    report = render_report(update, scene, settings, curve.points)
    assert json.loads(json.dumps(report, allow_nan=False)) == {
        "engine": "Photon Map",
        "version": VERSION,
        "scene": "box",
        "width": 8,
        "height": 6,
        "seed": 9,
        "threads": 2,
        "passes": 3,
        "seconds": 2.5,
        "setup_seconds": 0.5,
        "photons_emitted": 2**33,
        "photons_stored": 10,
        "photon_megabytes": 1.5,
        "rays": 20,
        "non_finite": 0,
        "relative_error": 0.125,
        "noise": 0.12,
        "bias": 0.035,
        "plan": [{"stage": "caustics", "on": True, "reason": "a caster"}],
        "curve": [
            {"pass": 1, "seconds": 1.0, "relative_error": None, "noise": None, "bias": 0.0},
            {"pass": 3, "seconds": 2.5, "relative_error": 0.125, "noise": 0.12, "bias": 0.035},
        ],
    }


def test_an_error_that_is_not_known_is_null():
    scene = SceneBuilder("box").build()
    for unknown in (math.inf, math.nan, np.float64("nan")):
        report = render_report(FakeUpdate(1, 1.0, StatedError(unknown, 0.0)), scene, Settings())
        assert report["relative_error"] is None


@pytest.mark.parametrize(
    ("update", "settings", "part"),
    [
        (FakeUpdate(16), Settings(passes=64), 0.25),
        (FakeUpdate(16, seconds=5.0), Settings(passes=64, seconds=10.0), 0.5),
        (FakeUpdate(1, error=StatedError(0.2, 0.0)), Settings(passes=64, error_goal=0.1), 0.25),
        (FakeUpdate(1), Settings(error_goal=0.1), 1 / 64),
        (FakeUpdate(9, error=StatedError(0.0, 0.0)), Settings(passes=9, error_goal=0.1), 1.0),
        (FakeUpdate(9, seconds=30.0), Settings(passes=64, seconds=10.0), 1.0),
    ],
)
def test_the_limit_that_comes_first_is_the_one_shown(
    update: FakeUpdate, settings: Settings, part: float
):
    assert completed(update, settings) == pytest.approx(part, rel=1e-12)
