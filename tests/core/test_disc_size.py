"""Discs of caustics follow what the film says of its noise and its bias."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from photon_map.core import Settings, disc_size, render
from photon_map.core.disc_size import FIRST, LAG, LEAST, DiscSize, better_size, sizes_discs
from photon_map.tests import scenes

AUTO = Settings(seed=3)


def film_that_says(noise, bias_square, passes=16, pixels=1000):
    """A film of an even picture whose caustics have so much ``noise``, as parts of relMSE."""
    light = np.full(pixels, 2.0)
    square = light**2 * 1.01
    others = np.full(pixels, 0.3)
    return SimpleNamespace(
        passes=passes,
        stated_error=lambda: SimpleNamespace(bias=np.sqrt(bias_square)),
        scatter_of_paths=lambda share: (others + share * noise * passes * square, light),
    )


@pytest.mark.parametrize(("noise", "bias"), [(0.01, 0.004), (0.002, 0.03), (0.05, 0.001)])
def test_the_better_size_has_the_least_error(noise, bias):
    factors = np.linspace(0.3, 3.0, 5401)
    error = noise / factors**2 + 2.0 * bias * factors**4  # at edges twice what is stated
    found = better_size(film_that_says(noise, bias))
    assert found == pytest.approx(factors[np.argmin(error)], abs=1e-3)


@pytest.mark.parametrize(("noise", "bias"), [(0.0, 0.01), (0.01, 0.0)])
def test_in_doubt_nothing_changes(noise, bias):
    assert better_size(film_that_says(noise, bias)) == 1.0


def test_passes_under_way_keep_their_discs():
    discs = DiscSize(True)
    blurred = film_that_says(0.01, 0.01, FIRST)
    for i in range(FIRST + 1):
        discs.look(i, blurred)
    wanted = better_size(blurred)
    assert wanted < 1.0
    told = [discs.factor(i) for i in range(FIRST + LAG + 2)]
    assert told == [1.0] * (FIRST + LAG) + [wanted] * 2


def test_a_film_that_still_shows_the_first_discs_is_not_taken_for_one_of_the_new_ones():
    """Else each look would shrink them again for the same bias."""
    discs = DiscSize(True)
    for i in range(4 * FIRST + 1):
        # It always asks for 0.8 of what its passes had.
        discs.look(i, film_that_says(4.0 * 0.8**6 * 0.01, 0.01))
    last = discs.factor(4 * FIRST + LAG)
    assert 0.8**3 < last < 0.8


def test_discs_never_grow_nor_vanish():
    for film, least in ((film_that_says(1.0, 1e-6), 1.0), (film_that_says(1e-9, 1.0), LEAST)):
        discs = DiscSize(True)
        for i in range(200):
            discs.look(i, film)
        assert discs.factor(300) == least


@pytest.mark.parametrize(
    "by_hand", [{"gather_rays": 4}, {"photons_caustic": 5000}, {"alpha": 1.0}]
)
def test_what_is_set_by_hand_stays(by_hand):
    assert sizes_discs(AUTO)
    assert not sizes_discs(Settings(**by_hand))
    discs = DiscSize(False)
    discs.look(FIRST, film_that_says(1e-9, 1.0))
    assert discs.factor(10 * FIRST) == 1.0


def rendered(**settings):
    *_, last = render(scenes.mirror_caustic(8), Settings(passes=16, seed=3, **settings))
    return last.film.resolve("caustics")


def test_renders_take_other_discs_with_the_same_bits_on_any_threads(monkeypatch):
    monkeypatch.setattr(disc_size, "better_size", lambda film: 0.6)
    one = rendered(threads=1)
    np.testing.assert_array_equal(rendered(threads=2, chunk_size=16), one)
    monkeypatch.setattr(disc_size, "better_size", lambda film: 1.0)
    usual = rendered(threads=1)
    assert (usual != one).any()
    assert one.mean() == pytest.approx(usual.mean(), rel=0.02)
