"""Films add up, survive bad samples, and know their noise."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.film.film import SAMPLE, Film

W, H = 40, 30


def samples(rng, scale=1.0):
    s = np.zeros(W * H, SAMPLE)
    s["direct"] = scale * rng.exponential(1.0, (W * H, 3))
    s["indirect"] = 0.5
    s["alpha"] = 1.0
    return s


def filled(rng, passes, first=0):
    film = Film(W, H)
    for i in range(first, first + passes):
        film.add(i, 0, samples(rng))
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
        if layer in ("combined", "emission", "direct", "caustics", "indirect"):
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


def test_a_bad_sample_is_counted_and_left_out():
    film = Film(W, H)
    s = samples(np.random.default_rng(0))
    s["caustics"][7, 1] = np.nan
    s["depth"][8] = np.inf
    film.add(0, 0, s)
    assert film.statistics.non_finite == 2
    assert np.isfinite(film.resolve("combined")).all()
    assert (film.resolve("combined").reshape(-1, 4)[[7, 8], :3] == 0).all()


def test_error_is_unknown_before_the_second_pass():
    assert filled(np.random.default_rng(0), 1).relative_error() == np.inf


def test_a_black_film_has_no_error():
    film = Film(W, H)
    for i in range(4):
        film.add(i, 0, np.zeros(W * H, SAMPLE))
    assert film.relative_error() == 0


def test_an_unknown_layer_names_the_known_ones():
    with pytest.raises(ValueError, match="caustics"):
        Film(2, 2).resolve("beauty")
