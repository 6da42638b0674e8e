"""Uniformity and independence of the random streams (level 0.01 each, fixed seed)."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numba import njit

from photon_map.core.sampling.rng import sobol_2d, stream, uniform
from photon_map.tests.statistics import chi_square, uniform_square

COUNT = 100_000


@njit
def table(seed, purpose, passes, indices, dimensions):
    """Numbers (passes, indices, dimensions) of the streams."""
    out = np.empty((passes, indices, dimensions))
    for i in range(passes):
        for k in range(indices):
            key = stream(seed, purpose, i, k)
            for d in range(dimensions):
                out[i, k, d] = uniform(key, d)
    return out


@njit
def points(count, key):
    out = np.empty((count, 2))
    for k in range(count):
        out[k] = sobol_2d(k, key)
    return out


@njit
def scrambles(k, count, index):
    """Point ``k`` of ``count`` sequences."""
    out = np.empty((count, 2))
    for i in range(count):
        out[i] = sobol_2d(k, stream(0, 1, i, index))
    return out


def test_numbers_are_uniform_and_below_one():
    numbers = table(0, 1, 1, COUNT, 1).ravel()
    assert 0 <= numbers.min() and numbers.max() < 1
    chi_square(np.histogram(numbers, 256, (0, 1))[0], np.full(256, COUNT / 256))


@pytest.mark.parametrize("lag", [1, 2, 7])
def test_neighbours_are_independent_in_every_direction(lag):
    numbers = table(3, 2, 16, 64, 100)
    for axis in range(3):
        length = numbers.shape[axis]
        first = np.take(numbers, np.arange(length - lag), axis)
        second = np.take(numbers, np.arange(lag, length), axis)
        uniform_square(first, second, tests=9)


def test_seeds_and_purposes_share_nothing():
    tables = [table(seed, purpose, 1, 200, 100) for seed in (0, 1) for purpose in (1, 2, 3)]
    for a, b in itertools.combinations(tables, 2):
        uniform_square(a, b, bins=8, tests=15)
        assert not np.isin(a, b).any()


def test_values_do_not_depend_on_what_was_drawn_before():
    numbers = table(5, 1, 2, 3, 4)
    assert uniform(np.uint64(stream(5, 1, 1, 2)), 3) == numbers[1, 2, 3]
    assert uniform(np.uint64(stream(5, 1, 0, 0)), 0) == numbers[0, 0, 0]


@pytest.mark.parametrize("bits", [4, 8])
def test_sobol_puts_one_point_in_every_elementary_interval(bits):
    count = 1 << bits
    for key in (0, 1, 12345678901234567):
        found = points(count, np.uint64(key))
        for wide in range(bits + 1):
            columns, rows = 1 << wide, 1 << (bits - wide)
            cell = np.floor(found * (columns, rows)).astype(int)
            assert len(np.unique(cell, axis=0)) == count


def test_sobol_scrambles_are_independent_of_each_other_and_of_the_index():
    # The k-th point of many scrambles is a uniform sample of the square.
    for k in (0, 1, 1000):
        found = scrambles(k, 20_000, 0)
        uniform_square(found[:, 0], found[:, 1], tests=6)
    for k in range(3):
        uniform_square(scrambles(k, 20_000, 1)[:, 0], scrambles(k, 20_000, 2)[:, 0], tests=6)
