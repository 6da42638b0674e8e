"""Camera paths go where the noise is, and no pixel's own samples decide how many it gets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import Scene, SceneBuilder, Settings, render
from photon_map.core.film.film import SAMPLE, Film
from photon_map.core.path_density import LEAST, MOST, PathDensity, among_neighbours, shares_of
from photon_map.core.sampling.rng import REPLICATES
from photon_map.core.scene.builder import diffuse
from tests.scenes import box, camera, cornell_glass, plane

W, H = 32, 24


def noisy_film(deviation, seed=0, passes=8, light=1.0):
    """A film whose pixels (h, w) scatter by ``deviation`` a path, in the direct light."""
    rng = np.random.default_rng(seed)
    film = Film(W, H)
    every = np.arange(W * H, dtype=np.int32)
    for i in range(passes):
        rows = np.zeros(W * H, SAMPLE)
        noise = (deviation * rng.choice([-1.0, 1.0], (H, W))).ravel()
        rows["direct"] = (np.broadcast_to(light, (H, W)).ravel() + noise)[:, None]
        film.add(i, every, rows)
        film.end_pass()
    return film


def test_paths_follow_the_deviation_relative_to_the_light():
    deviation, light = np.full((H, W), 0.15), np.full((H, W), 1.0)
    deviation[:, 16:] = 0.35
    light[12:, :] = 1.3
    films = [noisy_film(deviation, seed, 64, light) for seed in range(12)]
    shares = np.mean([shares_of(film) for film in films], axis=0).reshape(H, W)
    assert shares.mean() == pytest.approx(1.0)
    # Away from the borders between the parts. A deviation of four values is known to 42 %:
    # ratios of parts of 54 pixels in 12 films to 2.3 %; the bound is 3.5 times that.
    parts = [shares[3:9, 3:12], shares[3:9, 20:29], shares[15:21, 3:12], shares[15:21, 20:29]]
    assert parts[1].mean() / parts[0].mean() == pytest.approx(7 / 3, rel=0.08)
    assert parts[0].mean() / parts[2].mean() == pytest.approx(1.3, rel=0.08)


def test_even_noise_asks_for_one_path_each():
    assert shares_of(noisy_film(np.full((H, W), 0.2))) is None
    assert shares_of(noisy_film(np.zeros((H, W)))) is None


def test_noise_of_caustics_asks_for_no_paths():
    film = Film(W, H)
    rng = np.random.default_rng(1)
    for i in range(8):
        rows = np.zeros(W * H, SAMPLE)
        rows["direct"] = 1.0
        rows["caustics"][: W * H // 2] = rng.exponential(1.0, (W * H // 2, 3))
        film.add(i, np.arange(W * H, dtype=np.int32), rows)
        film.end_pass()
    assert shares_of(film, 0.0) is None
    shares = shares_of(film, 0.25)
    assert shares[: W * H // 2].mean() > 1.5 * shares[W * H // 2 :].mean()


def test_a_pixel_has_no_say_in_its_own_share():
    plane = np.random.default_rng(2).random((H, W))
    other = plane.copy()
    other[5, 7] += 10.0
    before, after = among_neighbours(plane), among_neighbours(other)
    assert after[5, 7] == pytest.approx(before[5, 7], rel=1e-12)
    assert after[5, 8] > before[5, 8] + 0.1
    assert among_neighbours(np.full((H, W), 3.0)) == pytest.approx(np.full((H, W), 3.0))
    assert among_neighbours(np.ones((1, 1))) == 0.0


def test_each_replicate_takes_the_points_of_a_pixel_without_a_gap():
    deviation = np.full((H, W), 0.05)
    deviation[:, :4] = 1.0
    film = noisy_film(deviation)
    density = PathDensity(W, H, True)
    numbers = [[] for _ in range(W * H)]
    total = 0
    for i in range(32):
        pixels = density.pixels(i, film)
        assert (np.diff(pixels.ids) >= 0).all() and pixels.ids.dtype == np.int32
        for pixel, number in zip(pixels.ids, pixels.numbers, strict=True):
            assert number % REPLICATES == i % REPLICATES
            numbers[pixel].append(number)
        total += pixels.paths
    assert density.shares is not None
    counts = np.array([len(own) for own in numbers])
    for own in numbers:
        assert sorted(own) == list(range(len(own)))
    # 4 passes with one each, then 28 with the shares; what is due is less than one a replicate.
    expected = 4 + 28 * density.shares
    assert (np.abs(counts - expected) <= REPLICATES).all()
    assert total == pytest.approx(32 * W * H, rel=0.01)
    assert counts.min() >= 4 + 28 * LEAST - REPLICATES
    assert counts.max() <= 4 + 28 * 1.1 * MOST + REPLICATES


def test_without_it_every_pass_has_every_pixel():
    density = PathDensity(W, H, False)
    film = noisy_film(np.random.default_rng(0).random((H, W)))
    for i in range(12):
        pixels = density.pixels(i, film)
        assert (pixels.ids == np.arange(W * H)).all() and (pixels.numbers == i).all()


BASE = Settings(passes=32, pixel_filter="BOX", filter_width=1.0)


def posts() -> Scene:
    """Posts on a floor under a point lamp: noise at their edges and those of their shadows."""
    b = SceneBuilder("posts")
    grey = b.add_material("grey", [diffuse(0.5)])
    b.add_mesh("floor", *plane(2.0), grey)
    for k in range(4):
        b.add_mesh(f"post {k}", *box((k - 1.8, -0.1, 0.0), (k - 1.6, 0.1, 0.8)), grey)
    b.add_point_light("lamp", (0.3, -1.0, 2.0), 10.0)
    b.set_camera(camera((0.0, -4.0, 4.0), (0.0, 0.0, 0.0), 48, 48))
    return b.build()


def test_the_mean_stays_and_the_noise_falls():
    """Of 8 seeds each: the mean within four standard errors, the squared error smaller."""
    scene = posts()
    found = {}
    for adaptive in (False, True):
        films = [
            list(render(scene, replace(BASE, adaptive=adaptive, seed=seed)))[-1].film
            for seed in range(8)
        ]
        found[adaptive] = np.array([f.resolve("combined")[..., :3] for f in films], float)
    means = {key: images.mean(axis=(1, 2, 3)) for key, images in found.items()}
    gap = means[True].mean() - means[False].mean()
    error = np.sqrt(sum(np.var(m, ddof=1) / 8 for m in means.values()))
    assert error < 0.003 * means[False].mean()
    assert abs(gap) < 4 * error
    truth = (found[False].mean(axis=0) + found[True].mean(axis=0)) / 2
    weight = 1.0 / (truth**2 + 0.01 * truth.mean() ** 2)
    variance = {
        key: (images.var(axis=0, ddof=1) * weight).mean() for key, images in found.items()
    }
    assert variance[True] < 0.7 * variance[False]


def test_chunks_and_threads_change_no_bit():
    scene = cornell_glass(24)
    films = []
    for threads, size in ((1, 8192), (2, 100), (2, 77)):
        chosen = replace(BASE, passes=10, threads=threads, chunk_size=size)
        update = list(render(scene, chosen))[-1]
        films.append(update.film)
        assert update.passes == 10
    assert any("caustics" in name for name in films[0].LAYERS)
    for film in films[1:]:
        for layer in Film.LAYERS:
            assert (film.resolve(layer) == films[0].resolve(layer)).all(), layer
