"""Rows of one pixel are all added."""

import numpy as np

from photon_map.core.film.repeated import add_each, each_once


def test_every_row_is_added_to_its_pixel():
    rng = np.random.default_rng(0)
    ids = np.sort(rng.integers(0, 20, 100)).astype(np.int32)
    values = rng.random((100, 3))
    plane = np.ones((25, 3))
    add_each(plane, ids, values)
    wanted = np.ones((25, 3))
    np.add.at(wanted, ids, values)
    np.testing.assert_allclose(plane, wanted, rtol=1e-12)


def test_a_group_has_each_pixel_once_and_all_rows_are_in_one():
    ids = np.array([0, 0, 0, 3, 4, 4, 7], np.int32)
    groups = [(np.arange(7)[rows], pixels) for rows, pixels in each_once(ids)]
    assert [len(pixels) for _, pixels in groups] == [4, 2, 1]
    for rows, pixels in groups:
        assert len(set(pixels)) == len(pixels) and (ids[rows] == pixels).all()
    assert sorted(np.concatenate([rows for rows, _ in groups])) == list(range(7))


def test_nothing_is_nothing():
    plane = np.ones((2, 3))
    add_each(plane, np.zeros(0, np.int32), np.zeros((0, 3)))
    assert (plane == 1).all()
