"""The guide's pilot: what it says of variance, means that stay, when it is on (fixed seeds)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from photon_map.core import Plan, Settings, guide_pass, photon_memory, render, renderer
from photon_map.core.camera_pass import light_image
from photon_map.core.camera_pass.chunk import trace_camera, trace_chunk
from photon_map.core.camera_pass.guide import side_of
from photon_map.core.camera_pass.pixels import Pixels, Region
from photon_map.core.camera_pass.rays import Rays
from photon_map.core.film.film import SAMPLE
from photon_map.core.film.layers import KIND_COLORS
from photon_map.core.guide_pass import left_of_variance
from photon_map.core.photon_pass import (
    TracedPhotons,
    photon_batches,
    photon_maps,
)
from photon_map.core.pilot_pass import pilot_radii
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.lobes import Lobe, diffuse
from photon_map.tests.guides import MIXED, random_guide, turned_away
from photon_map.tests.scenes import box, camera, floor_scene


def uneven_room(lobes: list[Lobe], size: int = 8, lamp_size: float = 0.2, watts: float = 0.5):
    """A closed box, one wall of it lit by a spot, and a square lamp below its ceiling."""
    b = SceneBuilder("uneven room")
    b.add_mesh("box", *box((-1, -1, -1), (1, 1, 1)), b.add_material("wall", lobes))
    spot = np.eye(4)
    spot[:3, :3] = [[0, 0, -1], [0, 1, 0], [1, 0, 0]]
    spot[:3, 3] = (-0.5, 0.5, 0.6)
    b.add_spot_light("spot", spot, 30.0, 0.6)
    lamp = np.eye(4)
    lamp[:3, 3] = (-0.4, 0.4, 0.9)
    b.add_area_light("lamp", lamp, watts / lamp_size**2, lamp_size, lamp_size)
    b.set_camera(camera((0, -0.95, 0), (0, 1, -0.4), size, size, fov=np.radians(80)))
    return b.build()


def test_the_variance_that_is_left_is_told_by_guided_rays():
    """Two kinds of directions, known exactly; 40 000 places know it to 2 %."""
    random = np.random.default_rng(6)
    places, rays = 40_000, 4
    value, chance, dense = np.array([1.0, 10.0]), np.array([0.8, 0.2]), np.array([0.75, 2.0])
    drawn = (random.random((places, rays)) < chance[1] * dense[1]).astype(int).ravel()
    owner = np.repeat(np.arange(places), rays)
    light = np.repeat((value / dense)[drawn][:, None], 3, axis=1)
    mean = (chance * value).sum()
    guided = (chance * value**2 / dense).sum() - mean**2
    plain = (chance * value**2).sum() - mean**2
    left = left_of_variance(owner, light, dense[drawn], np.ones((places, 3)))
    assert left == pytest.approx(guided / plain, rel=0.02)


@pytest.mark.parametrize("lobes", [[diffuse(0.7)], MIXED], ids=["diffuse", "mixed"])
def test_means_stay_whatever_the_guide_says(lobes: list[Lobe]):
    """A guide that knows nothing; direct and indirect light over 48 passes, t-tests at 0.1 %.

    Half of the lamp's light is met by gather rays, half asked by light sampling: their shares
    must add up to 1. The guide sends fewer rays to the lamp, so that shares of other densities
    than those that rays have do not; by chance denser and thinner ones would make up for it.
    """
    scene = uneven_room(lobes, 24, 1.0, 20.0)
    settings = Settings(photons_global=4000, gather_rays=4, focus=False)
    prepared = prepare(scene, settings)
    region, pixels = Region(0, 0, 24, 24, 24), Pixels.spread(0, 24 * 24)
    source = TracedPhotons(
        prepared, settings, photon_batches(Plan.of(scene, settings), settings, pixels.paths)
    )
    radii = pilot_radii(prepared, settings, region, source)
    rays, samples = Rays(prepared, pixels.paths), np.zeros(pixels.paths, SAMPLE)
    seen = trace_camera(prepared, settings, region, pixels, rays, samples).vertices
    side = np.array([side_of(tuple(n)) for n in seen["ns"]], np.int32)
    guide = random_guide(seen["p"], side)
    lamp = np.array((-0.4, 0.4, 0.9)) - prepared.centre.origin
    guide = turned_away(guide, seen["p"].copy(), seen["ns"].copy(), lamp)
    blind = prepared._replace(guide=guide)
    differences = {"direct": [], "indirect": []}
    means = {"direct": [], "indirect": []}
    for i in range(48):
        walks = [source.walk(i, batch) for batch in source.batches]
        maps = photon_maps(settings, radii, 0, source.batches, walks)
        # Other random numbers for one of the two, so that their noise is independent.
        other = replace(settings, seed=99)
        pixels = Pixels.spread(i, 24 * 24)
        plain = trace_chunk(prepared, settings, region, pixels, maps).samples
        guided = trace_chunk(blind, other, region, pixels, maps).samples
        for layer, found in differences.items():
            found.append(guided[layer].mean() - plain[layer].mean())
            means[layer].append(plain[layer].mean())
    for layer, found in differences.items():
        result = stats.ttest_1samp(found, 0.0)
        assert result.pvalue > 0.001, f"{layer}: {np.mean(found)} of {np.mean(means[layer])}"
        error = np.std(found, ddof=1) / np.sqrt(len(found))
        assert error < 0.015 * np.mean(means[layer]), "the test must be able to fail"


SMALL = Settings(passes=48, gather_rays=2, photons_global=4000, threads=1)


def stage_named(plan: Plan, name: str):
    return next((stage for stage in plan.stages if stage.name == name), None)


def last_of(scene, settings: Settings):
    return list(render(scene, settings))[-1]


def test_a_render_is_guided_where_that_pays_and_says_so():
    """Noise of independent renders, same photons a pass: guided below four fifths."""
    scene = uneven_room([diffuse(0.7)], 32)
    images = {True: [], False: []}
    for seed in range(6):
        for on, found in images.items():
            update = last_of(scene, replace(SMALL, guide=on, seed=seed))
            found.append(update.film.resolve("indirect")[..., :3])
            stage = stage_named(update.plan, "guide")
            assert (stage is not None and stage.on) == on, stage
    assert "variance" in stage_named(last_of(scene, SMALL).plan, "guide").reason
    noise = {on: np.var(found, axis=0, ddof=1).mean() for on, found in images.items()}
    assert noise[True] < 0.8 * noise[False]


def test_an_even_room_is_not_guided():
    b = SceneBuilder("even")
    wall = b.add_material("wall", [diffuse(0.5)], emission=1)
    b.add_mesh("box", *box((-1, -1, -1), (1, 1, 1)), wall)
    b.set_camera(camera((0.2, -0.3, 0.1), (1, 0.2, -0.4), 16, 16, fov=np.radians(80)))
    stage = stage_named(last_of(b.build(), SMALL).plan, "guide")
    assert stage is not None and not stage.on


def test_nothing_is_learnt_where_gather_rays_bring_little_noise(
    monkeypatch: pytest.MonkeyPatch,
):
    """A floor below a lamp of some extent: rays that leave it meet nothing."""

    def fail(*_: object) -> None:
        raise AssertionError("called")

    b = floor_scene([diffuse(0.5)])
    lamp = np.eye(4)
    lamp[:3, 3] = (0.3, 0.2, 0.5)
    b.add_area_light("lamp", lamp, 1.0, 0.5, 0.5)
    b.set_camera(camera((0, -0.9, 0.6), (0, 0.9, -0.6), 16, 16, fov=np.radians(60)))
    monkeypatch.setattr(renderer, "guided", fail)
    stage = stage_named(last_of(b.build(), replace(SMALL, gather_rays=-1)).plan, "guide")
    assert stage is not None and not stage.on and "of the noise" in stage.reason
    with pytest.raises(AssertionError, match="called"):
        last_of(uneven_room([diffuse(0.7)], 16), replace(SMALL, gather_rays=-1))


def test_little_memory_learns_the_same(always: None, monkeypatch: pytest.MonkeyPatch):
    """However many passes' photons are traced ahead of it."""
    scene = uneven_room(MIXED, 16)
    films = []
    for ahead in (2, 1):
        monkeypatch.setattr(photon_memory, "AHEAD", ahead)
        update = last_of(scene, SMALL)
        assert stage_named(update.plan, "guide").on
        films.append(update.film.resolve("combined"))
    assert (films[0] == films[1]).all()


def test_off_nothing_is_learnt(monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object) -> None:
        raise AssertionError("called")

    monkeypatch.setattr(renderer, "guided", fail)
    scene = uneven_room([diffuse(0.7)])
    for settings in (
        replace(SMALL, guide=False),
        replace(SMALL, draft=True),
        replace(SMALL, passes=1),
        replace(SMALL, photons_global=0),
    ):
        assert stage_named(last_of(scene, settings).plan, "guide") is None
    with pytest.raises(AssertionError, match="called"):
        last_of(scene, SMALL)


def test_more_passes_learn_more():
    region = Region(0, 0, 64, 64, 64)
    times = [
        guide_pass.times_to_learn(replace(SMALL, passes=passes), region)
        for passes in (1, 8, 40, 48, 10_000)
    ]
    assert times[:2] == [0, 0]
    assert sorted(times) == times and times[2] < times[3] < times[-1] == guide_pass.MOST


@pytest.fixture
def always(monkeypatch: pytest.MonkeyPatch) -> None:
    """Guide whatever is learnt."""
    monkeypatch.setattr(guide_pass, "PAYS", 10.0)


def test_threads_and_chunks_change_nothing_when_guided(always: None):
    scene = uneven_room(MIXED, 16)
    one = last_of(scene, replace(SMALL, chunk_size=37))
    two = last_of(scene, replace(SMALL, threads=2))
    assert stage_named(one.plan, "guide") == stage_named(two.plan, "guide")
    assert stage_named(one.plan, "guide").on
    for layer in ("direct", "indirect"):
        assert (one.film.resolve(layer) == two.film.resolve(layer)).all()


def test_light_by_kind_is_that_of_the_same_guided_picture(
    always: None, monkeypatch: pytest.MonkeyPatch
):
    # Caustics by kind have discs alone, so the plain picture gets them too.
    monkeypatch.setattr(light_image, "connected_share", np.zeros_like)
    scene = uneven_room(MIXED, 16)
    kinds = replace(SMALL, light_kinds=True, first_hit=tuple(KIND_COLORS))
    one, two = last_of(scene, SMALL), last_of(scene, kinds)
    assert stage_named(one.plan, "guide").on and stage_named(two.plan, "guide").on
    np.testing.assert_allclose(
        one.film.resolve("combined"), two.film.resolve("combined"), rtol=1e-6
    )
