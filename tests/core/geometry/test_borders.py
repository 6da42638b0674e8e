"""Where surfaces end: half edges that no face goes on from."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.geometry.borders import border_sides
from photon_map.tests import scenes
from photon_map.tests.meshes import all_borders, joined, mesh_of, surfaces_of


def found(mesh, longest=100.0, most=10_000):
    return all_borders(mesh, longest, most)


def lengths(borders):
    return np.linalg.norm(borders.ends[:, 1] - borders.ends[:, 0], axis=1)


def test_a_box_has_each_edge_from_both_sides_and_no_diagonals():
    borders = found(mesh_of(*scenes.box((-1, -1, -1), (1, 1, 1))))
    assert lengths(borders) == pytest.approx(np.full(24, 2.0))


def test_a_fine_ball_has_none_and_a_sheet_has_its_rim():
    assert len(found(mesh_of(*scenes.sphere((0, 0, 0), 1.0, 2))).gap) == 0
    assert len(found(mesh_of(*scenes.plane(1.0))).gap) == 4
    empty = mesh_of(np.zeros((0, 3)), np.zeros((0, 3)))
    assert len(found(empty).gap) == 0
    plane = mesh_of(*scenes.plane(1.0))
    none = all_borders(plane, 1.0, 100, holds=[False, False])
    assert len(none.gap) == 0, "faces that hold no photons have no borders"


def test_they_run_counter_clockwise_about_the_normal():
    borders = found(mesh_of(*scenes.box((-1, -1, -1), (1, 1, 1))))
    middle = borders.ends.mean(axis=1)
    inward = np.cross(borders.normal, borders.ends[:, 1] - borders.ends[:, 0])
    # The middle of each face is its normal.
    assert ((inward * (borders.normal - middle)).sum(axis=1) > 0).all()


def test_faces_with_corners_of_their_own_are_neighbours_all_the_same():
    vertices, faces = scenes.plane(1.0)
    apart = vertices[faces].reshape(-1, 3)
    assert len(found(mesh_of(apart, np.arange(6).reshape(2, 3))).gap) == 4


def test_a_wall_ends_on_the_floor_that_goes_on_below_it():
    vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)]
    faces = [(0, 1, 2), (1, 0, 3), (0, 1, 4)]
    mesh = mesh_of(vertices, faces)
    face, side = border_sides(surfaces_of(mesh), np.ones(3, bool))
    shared = side == 0  # all three faces begin with the shared edge
    assert face[shared].tolist() == [2]


@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-7, 1e-6, 1e-5])
@pytest.mark.parametrize("turned", [False, True])
def test_a_sheet_twice_has_its_rim_once(gap, turned):
    vertices, faces = scenes.plane(4.0, -gap)
    twin = vertices, faces[:, ::-1] if turned else faces
    assert len(found(joined(scenes.plane(4.0), twin)).gap) == 4


def test_a_sheet_on_a_desk_goes_on_at_the_desk():
    paper, desk = scenes.plane(0.1, 0.001), scenes.plane(1.0)
    borders = found(joined(paper, desk))
    small = lengths(borders) < 1
    np.testing.assert_allclose(borders.gap[small], 0.001, rtol=1e-3)
    assert np.isinf(borders.gap[~small]).all() and (~small).sum() == 4


def test_a_step_goes_on_at_the_next_one_up_and_down():
    low = scenes.quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))
    riser = scenes.quad((1, 0, 0), (1, 0, 0.2), (1, 1, 0.2), (1, 1, 0))
    high = scenes.quad((1, 0, 0.2), (2, 0, 0.2), (2, 1, 0.2), (1, 1, 0.2))
    borders = found(joined(low, riser, high))
    flat = np.abs(borders.normal[:, 2]) > 0.9
    fold = flat & (np.abs(borders.ends[:, :, 0] - 1).max(axis=1) < 1e-6)
    np.testing.assert_allclose(borders.gap[fold], 0.2, rtol=1e-4)
    assert fold.sum() == 2 and np.isinf(borders.gap[flat & ~fold]).all()


def test_pieces_are_short_and_few():
    mesh = mesh_of(*scenes.plane(1.0))
    borders = found(mesh, longest=0.3)
    assert len(borders.gap) == 28 and lengths(borders) == pytest.approx(np.full(28, 2 / 7))
    assert len(found(mesh, longest=1e-4).gap) == 0, "a rim of 20 000 discs"


def test_with_too_many_the_shortest_are_left_out():
    leaves = [scenes.quad((x, 0, 9), (x + 0.01, 0, 9), (x + 0.01, 0.01, 9), (x, 0.01, 9))
              for x in np.arange(50) * 0.1]  # fmt: skip
    borders = found(joined(scenes.plane(1.0), *leaves), longest=1.0, most=30)
    assert lengths(borders) == pytest.approx(np.full(8, 1.0))
    assert len(found(joined(scenes.plane(1.0), *leaves), longest=1.0, most=5).gap) == 0
    assert len(found(joined(scenes.plane(1.0), *leaves), longest=1.0, most=208).gap) == 208
