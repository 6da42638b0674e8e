"""Shadow photons: what they decide, what they leave to a ray, and that none cost nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest

from photon_map.core import Settings, render
from photon_map.core.camera_pass.records import VERTEX
from photon_map.core.photons.shadow import (
    ASK,
    LIT,
    SHADOWED,
    count_photons,
    decide,
    shadow_map,
    share_bounds,
)
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import diffuse
from photon_map.core.scene.scene import Scene
from photon_map.tests.scenes import floor_scene, plane

SETTINGS = Settings(
    passes=4, photons_global=0, photons_caustic=0, gather_rays=1, shadow_photons=400_000
)
UP = (0.0, 0.0, 1.0)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A plate 1 m above a floor, one lamp above its middle and one at the side, below it."""
    b = floor_scene([diffuse(0.5)], half=2.0, size=48, height=6.0)
    b.add_mesh("plate", *plane(0.5, 1.0), b.add_material("plate", [diffuse(0.5)]))
    b.add_point_light("over", (0, 0, 3), 5.0)
    b.add_point_light("beside", (1.6, 0, 0.7), 1.0)
    return b.build()


@pytest.fixture(scope="module")
def shadows(scene: Scene):
    return shadow_map(prepare(scene, SETTINGS), SETTINGS)


@pytest.fixture(scope="module")
def middle(scene: Scene) -> np.ndarray:
    return prepare(scene, SETTINGS).centre.origin


@pytest.mark.parametrize(("shadow", "count"), [(0, 35), (0, 36), (92, 92), (3, 40), (50, 100)])
def test_bounds_are_wilsons(shadow: int, count: int):
    low, high = share_bounds(shadow, count)
    expected = binomtest(shadow, count).proportion_ci(0.95, "wilson")
    assert abs(low - expected.low) < 1e-4 and abs(high - expected.high) < 1e-4


def verdict(shadows, place, normal, entry, to_light) -> int:
    vertex = np.zeros(1, VERTEX)
    vertex["p"], vertex["ng"] = place, normal
    verdicts = np.zeros(1, np.int32)
    ids, entries = np.zeros(1, np.int32), np.full(1, entry, np.int32)
    directions = np.array([to_light], np.float32)
    left = decide(shadows, vertex, ids, entries, directions, 1, verdicts)
    assert left == (verdicts[0] == ASK)
    return int(verdicts[0])


def test_each_lamp_has_its_own_verdict(shadows, middle):
    assert shadows.radius < 0.3
    # Under the plate the upper lamp is hidden, the lower one is not.
    under = np.zeros(3) - middle
    assert verdict(shadows, under, UP, 0, (0, 0, 3)) == SHADOWED
    assert verdict(shadows, under, UP, 1, (1.6, 0, 0.7)) == LIT
    aside = np.array((1.6, 1.5, 0)) - middle
    assert verdict(shadows, aside, UP, 0, (-1.6, -1.5, 3)) == LIT
    # The plate's shadow ends at 0.75 m: there only a ray can tell.
    edge = np.array((0.75, 0, 0)) - middle
    assert verdict(shadows, edge, UP, 0, (-0.75, 0, 3)) == ASK


def test_other_sides_and_planes_do_not_count(shadows, middle):
    top = np.array((0, 0, 1.0)) - middle
    assert verdict(shadows, top, UP, 0, (0, 0, 2)) == LIT
    # Its lower side faces the other lamp only.
    down = (0.0, 0.0, -1.0)
    assert sum(count_photons(shadows, 0, tuple(top), down)) == 0
    assert verdict(shadows, top, down, 0, (0, 0, 2)) == ASK
    above = top + (0, 0, 2 * shadows.radius)
    assert sum(count_photons(shadows, 0, tuple(above), UP)) == 0
    # Light from behind the surface is asked for by a ray.
    assert verdict(shadows, np.zeros(3) - middle, UP, 0, (0, 0, -1)) == ASK


def test_few_photons_decide_nothing(shadows, middle):
    under = np.zeros(3) - middle
    direct, shadow = count_photons(shadows, 0, tuple(under), UP)
    assert direct == 0 and shadow > 92, "enough that 95 % of the interval lies above 0.96"
    many = shadows._replace(least=shadow + 1)
    assert verdict(many, under, UP, 0, (0, 0, 3)) == ASK


def test_a_render_asks_fewer_rays_and_is_almost_the_same(scene: Scene):
    *_, plain = render(scene, replace(SETTINGS, shadow_photons=0))
    *_, spared = render(scene, SETTINGS)
    assert spared.film.statistics.rays < 0.85 * plain.film.statistics.rays
    truth = plain.film.resolve("direct").astype(np.float64)
    found = spared.film.resolve("direct")
    assert (truth != found).mean() < 0.03
    assert abs(found.mean() / truth.mean() - 1) < 0.01


def test_without_them_nothing_is_done(scene: Scene, monkeypatch: pytest.MonkeyPatch):
    def trap(*arguments: object) -> None:
        raise AssertionError("shadow photons were asked")

    monkeypatch.setattr("photon_map.core.pilot_pass.shadow_map", trap)
    monkeypatch.setattr("photon_map.core.camera_pass.next_event.decide", trap)
    *_, last = render(scene, replace(SETTINGS, shadow_photons=0))
    assert last.film.resolve("direct").max() > 0
    with pytest.raises(AssertionError, match="were asked"):
        list(render(scene, SETTINGS))


def test_shadowless_lamps_and_clear_surfaces_are_left_to_rays():
    from photon_map.core.scene.builder import transparent

    b = floor_scene([diffuse(0.5)], half=2.0, size=8, height=6.0)
    b.add_mesh("pane", *plane(0.5, 1.0), b.add_material("pane", [transparent(0.5)]))
    b.add_point_light("lamp", (0, 0, 3), 5.0)
    prepared = prepare(b.build(), SETTINGS)
    found = shadow_map(prepared, SETTINGS)
    under = np.zeros(3) - prepared.centre.origin
    assert sum(count_photons(found, 0, tuple(under), UP)) == 0
    lights = prepared.lights.lamps.copy()
    lights["shadow"] = 0
    free = prepared._replace(lights=prepared.lights._replace(lamps=lights))
    assert len(shadow_map(free, SETTINGS).photons.keys) == 0
