"""Pieces in nearly one line become one, and none strays farther than it may."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.geometry.borders import CROSSING, Borders
from photon_map.core.geometry.polylines import straightened

UP = (0.0, 0.0, 1.0)


def pieces(points, closed=False, parts=None):
    """A polyline through ``points`` (N, 2), its pieces without any order or way round."""
    points = np.column_stack([points, np.zeros(len(points))])
    ends = np.stack([points, np.roll(points, -1, axis=0)], axis=1)[: None if closed else -1]
    random = np.random.default_rng(4)
    turned = random.random(len(ends)) < 0.5
    ends[turned] = ends[turned, ::-1]
    marks = np.full(len(ends), CROSSING, np.int8) if parts is None else np.asarray(parts)
    order = random.permutation(len(ends))
    gap = np.full(len(ends), np.inf)
    return Borders(ends[order], np.tile(UP, (len(ends), 1)), gap, marks[order])


def lengths(found):
    return np.linalg.norm(found.ends[:, 1] - found.ends[:, 0], axis=1)


def test_a_cut_line_is_whole_again():
    found = straightened(pieces(np.column_stack([np.linspace(0, 2, 301), np.zeros(301)])), 1e-6)
    assert len(found.ends) == 1
    assert lengths(found) == pytest.approx([2.0])


@pytest.mark.parametrize("tolerance", [1e-4, 1e-3, 1e-2])
def test_a_ring_becomes_chords_that_are_near_it(tolerance):
    angle = np.linspace(0, 2 * np.pi, 512, endpoint=False)
    found = straightened(
        pieces(np.column_stack([np.cos(angle), np.sin(angle)]), True), tolerance
    )
    chords = lengths(found)
    # A chord of length c is c^2 / 8 away from a ring of radius 1.
    assert (chords.max() / 2) ** 2 / 2 <= tolerance * 1.01
    assert len(chords) < 4 * 2 * np.pi / np.sqrt(8 * tolerance)
    assert (2 * np.arcsin(chords / 2)).sum() == pytest.approx(2 * np.pi)
    # Still closed: each end is that of two pieces.
    ends = np.round(found.ends.reshape(-1, 3), 9)
    assert (np.unique(ends, axis=0, return_counts=True)[1] == 2).all()


def test_corners_forks_and_other_parts_stay():
    corner = pieces(np.array([(0, 0), (1, 0), (2, 0), (2, 1), (2, 2.0)]))
    assert sorted(lengths(straightened(corner, 0.1))) == pytest.approx([2.0, 2.0])
    line = np.array([(0, 0), (1, 0), (2, 0), (3, 0.0)])
    mixed = straightened(pieces(line, parts=np.array([4, 4, 1], np.int8)), 0.1)
    assert sorted(zip(lengths(mixed), mixed.parts, strict=True)) == [(1.0, 1), (2.0, 4)]
    fork = Borders(*(np.concatenate(x) for x in zip(
        pieces(line), pieces(np.array([(1, 0), (1, 1.0)])), strict=True)))  # fmt: skip
    assert sorted(lengths(straightened(fork, 0.1))) == pytest.approx([1.0, 1.0, 2.0])


def test_a_sheet_of_two_folds_is_not_flattened():
    whole = pieces(np.column_stack([np.linspace(0, 1, 3), np.zeros(3)]))
    turned = whole._replace(normal=np.array([UP, (0.0, 1.0, 0.0)]))
    assert len(straightened(turned, 0.1).ends) == 2
