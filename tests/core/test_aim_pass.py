"""Caustic photons are sent to where the camera sees them land, where that pays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from photon_map.core import Kept, Settings, render
from photon_map.core.aim_pass import FLOOR, PAYS, PHOTONS, Told, learnt, left_of_error
from photon_map.core.photons.aim import Aim
from photon_map.core.photons.emission_histogram import CELLS
from photon_map.core.scene.builder import dielectric, diffuse
from photon_map.core.scene.scene import Scene
from photon_map.tests import scenes

SIZE = 24
SETTINGS = Settings(
    passes=16, threads=1, photons_caustic=8192, photons_global=1000, gather_rays=1
)


def slab(fov: float) -> Scene:
    """A wide pane of glass over a floor, of which the camera sees a part beside the lamp."""
    b = scenes.floor_scene([diffuse(0.6)], half=4.0)
    b.add_mesh(
        "pane", *scenes.glass_slab(1.5, half=4.0), b.add_material("g", [dielectric(1.5)])
    )
    b.add_point_light("lamp", (0, 0, 2.5), 10.0)
    b.set_camera(
        scenes.camera((1.5, 1.0, 4.0), (1.5, 1.0, 0.0), SIZE, SIZE, (0, 1, 0), np.radians(fov))
    )
    return b.build()


def stage_of(update):
    return [stage for stage in update.plan.stages if stage.name == "photon aim"]


def caustics(scene: Scene, seed: int, **changes) -> np.ndarray:
    update = list(render(scene, replace(SETTINGS, seed=seed, **changes)))[-1]
    return update.film.resolve("caustics")[..., :3].astype(np.float64)


def test_photons_go_where_they_are_seen():
    """Means of 12 seeds agree at 0.1 %; scatter of pixels is less than half (F above 3)."""
    scene = slab(12.0)
    update = list(render(scene, SETTINGS))[-1]
    (stage,) = stage_of(update)
    assert stage.on, stage.reason
    even, sent = (
        np.array([caustics(scene, 20 * k + seed, learn_aim=bool(k)) for seed in range(12)])
        for k in range(2)
    )
    assert (even.mean(axis=(1, 2, 3)) > 0).all()
    test = stats.ttest_ind(*(x.mean(axis=(1, 2, 3)) for x in (even, sent)), equal_var=False)
    assert test.pvalue > 1e-3, (even.mean(), sent.mean())
    assert even.var(axis=0).mean() > 3.0 * sent.var(axis=0).mean()


def test_nothing_is_learnt_where_all_is_seen():
    (stage,) = stage_of(list(render(scenes.cornell_glass(SIZE), SETTINGS))[-1])
    assert not stage.on and "would not pay" in stage.reason


@pytest.mark.parametrize("change", [{"learn_aim": False}, {"draft": True}, {"passes": 2}])
def test_it_costs_nothing_where_nobody_asks(change: dict):
    assert not stage_of(list(render(slab(12.0), replace(SETTINGS, **change)))[-1])


def test_kept_photons_are_not_those_of_one_camera():
    scene = slab(12.0)
    kept = Kept()
    list(render(scene, SETTINGS, kept))
    assert kept.nbytes == 0
    other = slab(20.0)
    again = replace(scene, camera=other.camera)
    found, alone = (
        list(render(again, SETTINGS, k))[-1].film.resolve("combined") for k in (kept, None)
    )
    assert np.array_equal(found, alone)


def told_of(light: int, square, random: np.random.Generator, number: int) -> Told:
    """Photons of one of two lights: ``square`` (CELLS,) is what those of each bin bring."""
    entry = np.full(number, light, np.int32)
    bins = random.integers(0, CELLS, number).astype(np.int32)
    return Told(entry, bins, square[bins], np.ones(number))


def both(parts) -> Told:
    return Told(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def test_densities_follow_the_root_of_what_is_brought(rng: np.random.Generator):
    """One light brings nothing, the other from one of its casters alone."""
    square = np.zeros(CELLS)
    square[: CELLS // 8] = 4.0
    aim = Aim(np.zeros((1, 5)), np.array([0.5, 1.0]))
    many = both([told_of(0, 0 * square, rng, 200_000), told_of(1, square, rng, 200_000)])
    found = learnt(aim, many)
    assert found.light_cdf[0] == pytest.approx(0.5 * FLOOR, rel=0.03)
    casters = np.diff(found.histogram.casters[1], prepend=0.0)
    # Its own share, and of the floor's an eighth; the rest leans on the one that brings much.
    assert casters[0] == pytest.approx(1 - FLOOR * 7 / 8, abs=0.12)
    assert casters[1:].min() >= 0.99 * FLOOR / 8
    left = left_of_error(aim, found, many)
    share = (1.0 - found.light_cdf[0]) * casters[0]
    assert left == pytest.approx(1 / 16 / share, rel=0.02)
    assert left < 0.25 * PAYS
    assert left_of_error(aim, aim._replace(histogram=found.histogram), many) > left


def test_nothing_seen_is_left_as_it_was(rng: np.random.Generator):
    aim = Aim(np.zeros((1, 5)), np.array([0.3, 1.0]))
    none = told_of(1, np.zeros(CELLS), rng, PHOTONS)
    found = learnt(aim, none)
    np.testing.assert_allclose(found.light_cdf, aim.light_cdf)
    assert left_of_error(aim, found, none) == 1.0
