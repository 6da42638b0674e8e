"""The data of first hits: which pass it is of, means, ranks, merging."""

import numpy as np
import pytest

from photon_map.core.film.first_hits import FIRST_HIT, NOTHING, FirstHits
from photon_map.core.film.layers import FIRST_HIT_LAYERS

EVERY = np.arange(2, dtype=np.int32)


def rows_of(value: float, found: bool = True) -> np.ndarray:
    rows = np.zeros(2, FIRST_HIT)
    if found:
        for name in ("distance", "object_index", "mist", "end_depth"):
            rows[name] = value
        rows["environment"] = [value, 0, 0]
        rows["found"] = rows["ended"] = 1
        rows["matte_object"][:, 0] = value
        rows["matte_weight"][:, 0] = 1
    return rows


def film_of(*passes: tuple[int, np.ndarray]) -> FirstHits:
    film = FirstHits(2, FIRST_HIT_LAYERS, 2)
    for i, rows in passes:
        film.add(i, EVERY, rows)
    return film


def test_single_layers_are_those_of_the_first_pass_and_others_means():
    film = film_of((1, rows_of(0.5)), (0, rows_of(0.25)), (2, rows_of(0.0, found=False)))
    assert (film.resolve("distance") == 0.25).all()
    assert (film.resolve("object_index") == 0.25).all()
    assert film.resolve("environment")[0] == pytest.approx([0.25, 0, 0])
    assert film.resolve("mist") == pytest.approx(np.full((2, 1), 0.75))
    assert film.resolve("end_depth") == pytest.approx(np.full((2, 1), 0.375))
    assert film.resolve("matte_object")[0] == pytest.approx([0.5, 1 / 3, 0.25, 1 / 3])


def test_nothing_is_far_away():
    film = film_of((0, rows_of(1.0, found=False)), (1, rows_of(1.0)))
    assert (film.resolve("distance") == NOTHING).all()
    assert (film.resolve("position") == 0).all()


def test_a_sample_that_is_not_finite_saw_nothing():
    film = film_of((0, rows_of(float("nan"))), (1, rows_of(1.0)))
    assert np.isfinite(film.resolve("environment")).all()
    assert (film.resolve("distance") == NOTHING).all()


def test_merging_is_adding():
    passes = [(i, rows_of(0.1 * (i + 1), found=i != 2)) for i in range(5)]
    for i, rows in passes:  # as many names as there are ranks
        rows["matte_object"][:, 0] = 1 + i % 2
    whole = film_of(*passes)
    part = film_of(*passes[3:])
    part.merge(film_of(*passes[:3]))
    for layer in FIRST_HIT_LAYERS:
        np.testing.assert_allclose(
            np.sort(part.resolve(layer), axis=1), np.sort(whole.resolve(layer), axis=1),
            rtol=1e-12, err_msg=layer,
        )  # fmt: skip


def test_only_what_was_asked_for_is_kept():
    film = FirstHits(2, ("mist",), 2)
    film.add(0, EVERY, rows_of(0.5))
    assert film.resolve("mist").shape == (2, 1)
    with pytest.raises(ValueError, match="not rendered"):
        film.resolve("uv")
    assert film.nbytes < FirstHits(2, FIRST_HIT_LAYERS, 2).nbytes
