"""The balance of a pass: causes told apart, the least error found, and what a render does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import Settings, opening, render
from photon_map.core.balance import (
    GATHER_RAYS,
    LIGHT_SAMPLES,
    PHOTON_FACTORS,
    Cost,
    balanced,
    least_error,
)
from photon_map.core.camera_pass.chunk import Chunk
from photon_map.core.camera_pass.pixels import Pixels, Region
from photon_map.core.film.film import SAMPLE
from photon_map.core.look import DirectLook, Look, Noise, noise_of, pixels_of
from photon_map.core.settings import AUTOMATIC
from photon_map.tests import scenes

COUNT = 20_000


def chunk(**layers):
    rows = np.zeros(COUNT, SAMPLE)
    for name, value in layers.items():
        rows[name] = np.asarray(value)[:, None]
    return Chunk(Pixels.spread(0, COUNT), rows, COUNT, COUNT // 2)


def random_look(camera=0.0, light=0.0, hits=0.0, gather=0.0, photons=0.0, seed=1):
    """Pixels of brightness 1 with these standard deviations by cause.

    ``hits``: direct light that gather rays find.
    """
    random = np.random.default_rng(seed)
    lights = 0.4 + light * random.standard_normal((2, COUNT, 1)) * np.ones(3)
    found = 0.1 + hits * random.standard_normal((2, COUNT, 1)) * np.ones(3)
    cameras = camera * random.standard_normal((2, COUNT))
    cameras += lights[..., 0] + found[..., 0]
    gathered = 0.3 + gather * random.standard_normal((2, COUNT))
    maps = 0.2 + photons * random.standard_normal((2, COUNT))
    parts = [
        chunk(direct=cameras[c], indirect=gathered[c], caustics=maps[p])
        for c, p in ((0, 0), (1, 1), (0, 1))
    ]
    # The look at direct light draws its own numbers.
    lights, found = (np.roll(both, 1, axis=1) for both in (lights, found))
    return Look(*parts, DirectLook(np.zeros((2, COUNT, 3)), lights, found, COUNT // 4), [], [])


def test_causes_of_noise_are_told_apart():
    found = noise_of(random_look(camera=0.05, light=0.04, hits=0.03, gather=0.1, photons=0.02))
    # 3 x 20 000 numbers know a variance to 1 %; a pixel's own noise is in its weight, and
    # that of the camera is a difference.
    np.testing.assert_allclose(found, (0.0025, 0.0016, 0.0109, 0.0004), rtol=0.08)


def test_rare_bright_emission_does_not_weigh_itself_down():
    """One pixel in 2000 sees a lamp of 1000 in one of two samples: it is most of the noise."""
    seen = random_look(light=0.1, gather=0.1)
    emission = np.zeros((2, COUNT, 3))
    emission[0, ::2000] = 1000.0
    found = noise_of(replace(seen, direct=seen.direct._replace(emission=emission)))
    assert found.camera > 5 * (found.light + found.gather)


def test_a_lamp_that_was_missed_leaves_no_darkness():
    """Half of all shadow rays arrive, nothing else lights: the variance is the mean squared.

    Relative to the square and its hundredth: 1 / 1.01. Places that all rays have missed count
    99 times as much if the rays that were compared do not tell that they are bright.
    """
    random = np.random.default_rng(3)
    draws = random.integers(0, 2, (4, COUNT)).astype(np.float64)
    dark = np.zeros(COUNT)
    parts = [chunk(direct=draws[c], indirect=dark) for c in (0, 1, 0)]
    lights = draws[2:, :, None] * np.ones(3)
    none = np.zeros((2, COUNT, 3))
    found = noise_of(Look(*parts, DirectLook(none, lights, none, COUNT), [], []))
    assert found.light == pytest.approx(1 / 1.01, rel=0.03)
    assert found.gather == found.photons == 0.0


def test_noise_is_relative_to_the_brightness():
    dim = random_look(gather=0.1)
    for part in (dim.first, dim.second, dim.third):
        for name in ("direct", "indirect", "caustics"):
            part.samples[name] *= 1e-6
    assert noise_of(dim) == pytest.approx(noise_of(random_look(gather=0.1)))


def test_without_noise_or_light_nothing_fails():
    nothing = DirectLook(*np.zeros((3, 2, COUNT, 3)), 0)
    dark = Look(*(chunk() for _ in range(3)), nothing, [], [])
    assert noise_of(dark) == (0.0, 0.0, 0.0, 0.0)
    found = least_error(noise_of(dark), Cost(1.0, 1.0, 1.0, 1.0), PHOTON_FACTORS)
    assert (found.light_samples, found.gather_rays) == (1, 1)


@pytest.mark.parametrize("light", [0.0, 0.02, 0.5])
@pytest.mark.parametrize("gather", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("photons", [0.01, 0.1, 1.0])
def test_the_best_is_near_the_optimum_of_continuous_numbers(light, gather, photons):
    noise, cost = Noise(0.1, light, gather, photons), Cost(40.0, 8.0, 30.0, 10.0)
    lights, rays, factor = least_error(noise, cost, PHOTON_FACTORS)
    # Noise sum(v / n) at a time of sum(c n) is least for n like sqrt(v / c).
    one = np.sqrt(0.6 * noise.camera / cost.camera)
    best_rays = np.clip(np.sqrt(gather / cost.gather) / one, GATHER_RAYS[0], GATHER_RAYS[-1])
    best_factor = np.sqrt(photons / cost.photons) / one
    best_lights = np.sqrt(0.6 * light / cost.light) / one
    best_lights = np.clip(best_lights, LIGHT_SAMPLES[0], LIGHT_SAMPLES[-1])
    assert 0.5 <= lights / best_lights <= 2.0
    assert 0.5 <= rays / best_rays <= 2.0
    assert 0.5 <= factor / np.clip(best_factor, PHOTON_FACTORS[0], PHOTON_FACTORS[-1]) <= 2.0


def test_numbers_by_hand_stay():
    region = Region(0, 0, 64, 64, 64)
    seen = random_look(photons=1.0)
    by_hand = Settings(photons_caustic=3000)
    found = balanced(by_hand, seen, region, traced=True)
    assert found.gather_rays in GATHER_RAYS and found.light_samples in LIGHT_SAMPLES
    assert replace(found, gather_rays=AUTOMATIC, light_samples=AUTOMATIC) == by_hand
    assert balanced(Settings(light_samples=3), seen, region, traced=True).light_samples == 3
    baked = balanced(Settings(), seen, region, traced=False)
    assert (baked.photons_caustic, baked.caustic_radius) == (AUTOMATIC, 1.4)


@pytest.mark.parametrize("width", [1, 7, 64, 128, 1000])
def test_pixels_are_spread_over_all_columns(width):
    pixels = pixels_of(Region(0, 0, width, 300, width), 0)
    chosen = pixels.ids
    assert chosen[-1] < 300 * width and pixels.paths <= 1024
    assert len(np.unique(chosen % width)) == min(width, pixels.paths)


def decided(scene, settings, monkeypatch):
    """Settings that a render of ``scene`` decides on, and its film."""
    seen = []

    def listen(*arguments):
        seen.append(balanced(*arguments))
        return seen[-1]

    monkeypatch.setattr(opening, "balanced", listen)
    film = list(render(scene, settings))[-1].film
    monkeypatch.undo()
    return seen, film


SMALL = Settings(passes=3, threads=1)


def test_a_render_uses_what_it_has_decided(monkeypatch):
    scene = scenes.cornell_glass(16)
    (found,), film = decided(scene, SMALL, monkeypatch)
    assert AUTOMATIC not in (found.gather_rays, found.light_samples, found.photons_caustic)
    again = list(render(scene, found))[-1].film
    for layer in ("direct", "emission", "indirect"):
        assert (again.resolve(layer) == film.resolve(layer)).all()
    # Borders are cut to the first radius, which the decision may have made smaller.
    np.testing.assert_allclose(
        again.resolve("caustics"), film.resolve("caustics"), rtol=1e-3, atol=1e-6
    )


@pytest.mark.parametrize("other", [{"threads": 2}, {"chunk_size": 37}])
def test_threads_and_chunks_decide_the_same(other, monkeypatch):
    scene = scenes.cornell_glass(16)
    one, _ = decided(scene, SMALL, monkeypatch)
    two, _ = decided(scene, replace(SMALL, **other), monkeypatch)
    assert [replace(s, **other) for s in one] == two


def test_the_plan_says_what_was_decided():
    last = list(render(scenes.cornell_glass(16), SMALL))[-1]
    stage = next(stage for stage in last.plan.stages if stage.name == "balance")
    assert stage.on and "light samples" in stage.reason
    assert "gather rays" in stage.reason and "caustic photons" in stage.reason


def test_numbers_by_hand_are_not_looked_at(monkeypatch):
    seen, _ = decided(scenes.cornell_glass(16), replace(SMALL, gather_rays=2), monkeypatch)
    assert seen == []
