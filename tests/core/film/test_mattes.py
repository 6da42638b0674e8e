"""Mattes by name: hashes, ranks and what does not fit."""

import numpy as np
import pytest

from photon_map.core.film.mattes import add_mattes, murmur3, name_bits, name_numbers, ranked


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        # Test vectors of MurmurHash3_x86_32 with seed 0.
        (b"", 0),
        (b"test", 0xBA6BD213),
        (b"Hello, world!", 0xC0363E43),
        (b"The quick brown fox jumps over the lazy dog", 0x2E4FF723),
        # As in files that Cycles has written.
        (b"Sphere", 0xE5E9B0DB),
        (b"default_surface", 0x78D05529),
    ],
)
def test_hashes_are_those_of_murmur(data: bytes, expected: int):
    assert murmur3(data) == expected


def test_every_name_is_an_ordinary_number():
    names = [f"{k}" for k in range(5000)]
    numbers = name_numbers(names)
    assert np.isfinite(numbers).all()
    assert (np.abs(numbers) >= np.finfo(np.float32).tiny).all()
    assert any(name_bits(name) != murmur3(name.encode()) for name in names)


def test_ranks_add_up_and_come_largest_first():
    numbers, weights = np.zeros((1, 2), np.float32), np.zeros((1, 2))
    a, b, c = 1.5, 2.5, 3.5
    for new, part in (([a, b], [0.2, 0.8]), ([b, a], [1.0, 0.0]), ([c, b], [1.0, 0.1])):
        add_mattes(numbers, weights, np.array([new], np.float32), np.array([part]))
    got = ranked(numbers, weights, np.array([3], np.int32))
    assert got[0, 0::2].tolist() == [b, a]
    assert got[0, 1::2] == pytest.approx([1.9 / 3, 0.2 / 3])
