"""Films add up, survive bad samples, and know their noise."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.film.accumulate import crossed_means, relative_mean
from photon_map.core.film.film import BIAS_FACTOR, SAMPLE, SHARPEN, Film

W, H = 40, 30


def add_pass(film, i, rows):
    film.add(i, np.arange(W * H, dtype=np.int32), rows)
    film.end_pass()


def samples(rng, scale=1.0):
    s = np.zeros(W * H, SAMPLE)
    s["direct"] = scale * rng.exponential(1.0, (W * H, 3))
    s["indirect"] = 0.5
    s["alpha"] = 1.0
    return s


def filled(rng, passes, first=0):
    film = Film(W, H)
    for i in range(first, first + passes):
        add_pass(film, i, samples(rng))
    return film


def test_merged_films_are_the_film_of_all_passes():
    together = filled(np.random.default_rng(3), 12)
    generator = np.random.default_rng(3)
    first, second = filled(generator, 5), filled(generator, 7, first=5)
    first.merge(second)
    for layer in Film.LAYERS:
        np.testing.assert_allclose(first.resolve(layer), together.resolve(layer), rtol=1e-6)
    assert first.passes == 12
    assert first.relative_error() == pytest.approx(together.relative_error(), rel=1e-9)


def test_exposure_scales_light_and_nothing_else():
    film = filled(np.random.default_rng(3), 2)
    plain = {layer: film.resolve(layer) for layer in Film.LAYERS}
    film.exposure = 2.5
    for layer in Film.LAYERS:
        factor = np.ones(Film.LAYERS[layer])
        if layer in ("combined", "emission", "direct", "caustics", "indirect", "error"):
            factor[:3] = 2.5
        np.testing.assert_allclose(film.resolve(layer), factor * plain[layer], rtol=1e-6)


def test_films_of_other_sizes_are_refused():
    with pytest.raises(ValueError, match="merged"):
        Film(2, 2).merge(Film(3, 2))


def test_the_stated_error_is_the_true_one():
    # relMSE of the mean of n exponential samples + 0.5 about its mean 1.5, known in advance.
    for passes in (3, 8, 50):
        film = filled(np.random.default_rng(passes), passes)
        mean = film.resolve("combined")[..., :3].astype(float)
        truth = ((mean - 1.5) ** 2 / (1.5**2 + 0.01 * 1.5**2)).mean()
        assert film.relative_error() ** 2 == pytest.approx(
            truth, rel=0.25 if passes > 3 else 0.5
        )


def test_rare_bright_samples_are_not_understated():
    # One in ten is 5, the others 0, over 0.5: third moment 1.8 times that of the relation.
    rng = np.random.default_rng(5)
    stated, true = [], []
    for _ in range(8):
        film = Film(W, H)
        for i in range(16):
            s = np.zeros(W * H, SAMPLE)
            s["caustics"] = 5.0 * (rng.random((W * H, 3)) < 0.1) + 0.5
            add_pass(film, i, s)
        mean = film.resolve("combined")[..., :3].astype(float)
        true.append(((mean - 1.0) ** 2).mean() / 1.01)
        stated.append(film.relative_error() ** 2)
    # 28 800 values, 1 % of standard error on both sides. By the pixels' own means the root
    # would be 11 % below the true one, by the other replicates' 32 % above.
    assert 1.0 < np.sqrt(np.mean(stated) / np.mean(true)) < 1.15


def biased(seed, passes, lost, noise):
    """Samples whose discs would lose ``lost`` on average with half their area."""
    rng = np.random.default_rng(seed)
    film = Film(W, H)
    for i in range(passes):
        s = np.zeros(W * H, SAMPLE)
        s["caustics"] = 1.0
        s["shrink"] = lost + rng.normal(0.0, noise, (W * H, 3)) if noise else lost
        add_pass(film, i, s)
    return film


def test_the_stated_bias_is_what_half_the_area_loses_times_a_factor():
    error = biased(0, 8, 0.02, 0.0).stated_error()
    # Relative to the light of 1 as it would be without the bias, and to the 0.01 that keeps
    # dark pixels from counting for all.
    light = 1.0 - SHARPEN * 0.02
    assert error.bias == pytest.approx(BIAS_FACTOR * 0.02 / np.sqrt(light**2 + 0.01), rel=1e-9)
    assert error.noise == 0.0
    assert error.relative_error == error.bias


def test_noise_of_the_bias_is_not_taken_for_bias():
    # With noise ten times what is lost, 8 passes: a plain square would say 0.11.
    found = [biased(seed, 8, 0.01, 0.1).stated_error().bias ** 2 * 1.01 for seed in range(16)]
    error = np.std(found, ddof=1) / 4
    assert error < 2e-4
    assert abs(np.mean(found) - (BIAS_FACTOR * 0.01) ** 2) < 4 * error


def test_noise_alone_states_no_bias():
    """The sharpened light that weighs it comes from other replicates than the product."""
    found = []
    for seed in range(16):
        film = biased(seed, 8, 0.0, 0.3)
        found.append(crossed_means(film._part_sum, film._part_count, film._shrink, 1.4)[1])
    error = np.std(found, ddof=1) / 4
    assert abs(np.mean(found)) < 4 * error < 2e-3


def test_bias_in_dark_places_weighs_by_the_light_that_belongs_there():
    """Discs that carry light of 0.2 into places that should be all but black."""
    film = Film(W, H)
    dark = np.zeros((W * H, 1))
    dark[: W * H // 50] = 1.0
    for i in range(8):
        s = np.zeros(W * H, SAMPLE)
        s["caustics"] = 1.0 - 0.8 * dark
        s["shrink"] = 0.1 * dark
        add_pass(film, i, s)
    light = 0.2 - SHARPEN * 0.1
    floor = 0.01 * (1.0 - 0.8 / 50) ** 2
    expected = BIAS_FACTOR * 0.1 / np.sqrt(light**2 + floor) / np.sqrt(50)
    assert film.stated_error().bias == pytest.approx(expected, rel=1e-9)


def test_a_single_bright_sample_does_not_weigh_itself_down():
    """8 in one of 512 samples. By the pixels' own means the stated error is two thirds of the
    true one: a pixel with one such sample in 16 is half too bright, and twice as heavy."""
    rng = np.random.default_rng(8)
    stated, true, own = [], [], []
    for _ in range(8):
        film = Film(W, H)
        for i in range(16):
            s = np.zeros(W * H, SAMPLE)
            s["caustics"] = 8.0 * (rng.random((W * H, 1)) < 1 / 512) + 1.0 - 8.0 / 512
            add_pass(film, i, s)
        mean = film.resolve("combined")[..., :3].astype(float)
        true.append(((mean - 1.0) ** 2).mean() / 1.01)
        stated.append(film.stated_error().noise ** 2)
        own.append(relative_mean(*film._variance_and_mean(), 0.0))
    assert np.sqrt(np.mean(own) / np.mean(true)) < 0.7
    assert 0.75 < np.sqrt(np.mean(stated) / np.mean(true)) < 1.33


def test_the_error_of_a_pixel_is_in_its_layer():
    film = filled(np.random.default_rng(1), 16)
    error = film.resolve("error")
    assert error.shape == (H, W, 1)
    mean = film.resolve("combined")[..., :3].astype(float)
    # 3600 values: their mean square is known to 2.6 %, what the replicates say of it to 1.4 %;
    # four standard errors of both.
    assert (error.astype(float) ** 2).mean() == pytest.approx(
        ((mean - 1.5) ** 2).mean(), rel=0.12
    )
    lost = biased(0, 8, 0.02, 0.0).resolve("error")
    np.testing.assert_allclose(lost, BIAS_FACTOR * 0.02, rtol=1e-6)


def test_a_bad_sample_is_counted_and_left_out():
    film = Film(W, H)
    s = samples(np.random.default_rng(0))
    s["caustics"][7, 1] = np.nan
    s["depth"][8] = np.inf
    add_pass(film, 0, s)
    assert film.statistics.non_finite == 2
    assert np.isfinite(film.resolve("combined")).all()
    assert (film.resolve("combined").reshape(-1, 4)[[7, 8], :3] == 0).all()


def test_error_is_unknown_before_the_second_pass():
    assert filled(np.random.default_rng(0), 1).relative_error() == np.inf


def test_a_black_film_has_no_error():
    film = Film(W, H)
    for i in range(4):
        add_pass(film, i, np.zeros(W * H, SAMPLE))
    assert film.relative_error() == 0


def test_an_unknown_layer_names_the_known_ones():
    with pytest.raises(ValueError, match="caustics"):
        Film(2, 2).resolve("beauty")
