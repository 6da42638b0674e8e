"""Several light samples a place: the same mean, less noise, nothing twice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.camera_pass import chunk
from photon_map.core.camera_pass.chunk import trace_camera
from photon_map.core.camera_pass.next_event import light_directly
from photon_map.core.camera_pass.pixels import Pixels, Region
from photon_map.core.camera_pass.rays import Rays
from photon_map.core.film.film import SAMPLE
from photon_map.core.prepared import prepare
from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.lobes import dielectric, diffuse, ggx
from photon_map.core.scene.scene import Scene
from tests import scenes
from tests.statistics import same_means

RUNS = 8
SIZE = 12
ALONE = Settings(
    passes=128, photons_global=0, photons_caustic=0, pixel_filter="BOX", filter_width=1.0
)


def under_a_lamp(covered: bool = False) -> Scene:
    """A glossy floor close to a lamp, where light samples and gather rays both matter.

    ``covered``: it is seen in and through a slab of glass, so that paths split.
    """
    b = scenes.floor_scene([diffuse(0.4), ggx(0.5, 0.4)], half=3.0, size=SIZE, height=2.0)
    # The lamp stands upright beside what is seen.
    b.add_area_light("lamp", scenes.look_at((0.9, 0, 0.3), (0, 0, 0.25)), 20.0, 0.8, 0.4)
    b.add_point_light("bulb", (-1, 0.5, 1), 1.0, radius=0.2)
    if covered:
        slab = scenes.glass_slab(1.5, 1.6, 1.7)
        b.add_mesh("slab", *slab, b.add_material("glass", [dielectric(1.5)]))
    return b.build()


def family(scene: Scene, gather_rays: int, light_samples: int, **others: int) -> np.ndarray:
    """Direct light of ``RUNS`` seeds (RUNS, h, w, 3)."""
    chosen = replace(ALONE, gather_rays=gather_rays, light_samples=light_samples, **others)
    films = [list(render(scene, replace(chosen, seed=seed)))[-1].film for seed in range(RUNS)]
    return np.array([film.resolve("direct").astype(float) for film in films])


@pytest.mark.parametrize(("rays", "samples"), [(1, 1), (4, 1), (1, 2), (1, 4), (2, 8), (4, 3)])
def test_every_number_has_the_mean_of_the_reference(rays: int, samples: int):
    """Pixel by pixel and over the image, t-tests at 1 %.

    The image's mean is known to 0.5 % (1 standard deviation) or better.
    """
    scene = under_a_lamp()
    reference = trace(scene, 3000, seed=3)
    runs = family(scene, rays, samples)
    spread = runs.var(axis=0, ddof=1) / RUNS
    expected, variance = reference["direct"], reference.variance["direct"]
    same_means(runs.mean(axis=0), spread, expected, variance, floor=1e-9, freedom=RUNS - 1)
    whole = runs.mean(axis=(1, 2, 3))
    deviation = whole.std(ddof=1) / RUNS**0.5
    assert deviation < 0.005 * whole.mean()
    own = variance.mean() / expected.size
    same_means(whole.mean(), deviation**2, expected.mean(), own, freedom=RUNS - 1)


def test_a_wrong_share_of_the_gather_rays_would_be_seen(monkeypatch: pytest.MonkeyPatch):
    """Were 4 samples one for the gather rays, 3 % more light would come."""
    scene = under_a_lamp()
    right = family(scene, 2, 4).mean()
    start = chunk.start_gather
    monkeypatch.setattr(chunk, "start_gather", lambda rays, _, *rest: start(rays, 1, *rest))
    assert family(scene, 2, 4).mean() > 1.03 * right


def test_branches_of_a_path_have_the_mean_of_one_sample():
    """Through and in a slab of glass, where branches ask by their portion; t-test at 1 %."""
    scene = under_a_lamp(covered=True)
    one, many = (family(scene, 2, n, split_depth=4).mean(axis=(1, 2, 3)) for n in (1, 4))
    spread = (one.var(ddof=1) + many.var(ddof=1)) / RUNS
    assert spread**0.5 < 0.01 * one.mean()
    same_means(many.mean(), spread, one.mean(), freedom=2 * RUNS - 2)


def test_noise_falls_with_the_number_of_samples():
    scene = under_a_lamp()
    one, four = (family(scene, 1, n, passes=4).var(axis=0, ddof=1).mean() for n in (1, 4))
    # The half of the one gather ray stays as noisy as it is.
    assert four < 0.6 * one


def test_a_lamp_without_extent_is_asked_once():
    """Samples that fall on it share one ray, and bring what one sample brings."""
    b = scenes.floor_scene([diffuse(0.5)], half=3.0, size=SIZE, height=2.0)
    b.add_point_light("point", (0, 0, 1), 1.0)
    b.add_sun_light("sun", scenes.look_at((0, 1, 1), (0, 0, 0)), 1.0)
    scene = b.build()
    prepared = prepare(scene, ALONE)
    region, count = Region(0, 0, SIZE, SIZE, SIZE), SIZE * SIZE
    found, asked = [], []
    for n in (1, 8):
        chosen = replace(ALONE, light_samples=n, gather_rays=1)
        samples = np.zeros((64, count), SAMPLE)
        for i in range(64):
            rays = Rays(prepared, count)
            lit = trace_camera(
                prepared, chosen, region, Pixels.spread(i, count), rays, samples[i]
            )
            asked.append(light_directly(prepared, chosen, lit, None, samples[i], None))
            assert asked[-1] <= 2 * count
        found.append(samples["direct"].mean(axis=(1, 2)))
    one, many = found
    # Independent samples would leave 1 / sqrt(8) = 0.35 of it.
    assert many.std() < 0.3 * one.std()
    same_means(many.mean(), many.var(ddof=1) / 64, one.mean(), one.var(ddof=1) / 64, freedom=63)


def test_a_single_lamp_without_extent_makes_no_noise_and_no_more_rays():
    b: SceneBuilder = scenes.floor_scene([diffuse(0.5)], half=3.0, size=SIZE, height=2.0)
    b.add_point_light("point", (0, 0, 1), 1.0)
    scene = b.build()
    films = [
        list(render(scene, replace(ALONE, gather_rays=1, light_samples=n)))[-1].film
        for n in (1, 4)
    ]
    one, four = (film.resolve("direct") for film in films)
    np.testing.assert_allclose(one, four, rtol=1e-6)
    assert films[0].statistics.rays == films[1].statistics.rays
