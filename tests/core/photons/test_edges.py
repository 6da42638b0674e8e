"""Edges of surfaces, and discs that end at them."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.geometry.mesh import Mesh
from photon_map.core.photons.edges import (
    LEAST_PART,
    MOST_ENTRIES,
    edge_grid,
    fitting_radius,
    sharp_edges,
)
from photon_map.tests import scenes


def mesh_of(vertices, faces) -> Mesh:
    count = len(faces)
    return Mesh(
        vertices=np.asarray(vertices, np.float32),
        faces=np.asarray(faces, np.int32),
        normals=np.zeros((count, 3, 3), np.float32),
        smooth=np.zeros(count, np.bool_),
        material=np.zeros(count, np.int32),
        visible=np.full(count, 31, np.int32),
    )


def test_a_box_has_twelve_edges_and_no_diagonals():
    segments = sharp_edges(mesh_of(*scenes.box((-1, -1, -1), (1, 1, 1))))
    assert len(segments) == 12
    assert np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1) == pytest.approx(2.0)


def test_a_fine_ball_has_none_and_a_sheet_has_its_rim():
    assert len(sharp_edges(mesh_of(*scenes.sphere((0, 0, 0), 1.0, 2)))) == 0
    assert len(sharp_edges(mesh_of(*scenes.plane(1.0)))) == 4
    assert sharp_edges(mesh_of(np.zeros((0, 3)), np.zeros((0, 3)))).shape == (0, 2, 3)


def test_faces_with_corners_of_their_own_are_neighbours_all_the_same():
    vertices, faces = scenes.plane(1.0)
    apart = vertices[faces].reshape(-1, 3)
    assert len(sharp_edges(mesh_of(apart, np.arange(6).reshape(2, 3)))) == 4


def test_where_three_faces_meet_is_an_edge():
    vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1)]
    faces = [(0, 1, 2), (1, 0, 3), (0, 1, 4)]
    shared = (sharp_edges(mesh_of(vertices, faces)) == [[0, 0, 0], [1, 0, 0]]).all(axis=(1, 2))
    assert shared.any()


@pytest.mark.parametrize("radius", [0.01, 0.1, 0.7])
def test_the_radius_is_the_distance_to_the_nearest_edge(radius):
    rng = np.random.default_rng(1)
    segments = rng.uniform(-1, 1, (40, 2, 3))
    segments[0, 1] = segments[0, 0]  # an edge without length
    grid = edge_grid(segments, radius)
    near = rng.integers(0, 40, 2000)
    t = rng.random((2000, 1))
    on_edge = segments[near, 0] * (1 - t) + segments[near, 1] * t
    points = on_edge + rng.normal(0, radius, (2000, 3))
    a, d = segments[:, 0], segments[:, 1] - segments[:, 0]
    way = points[:, None] - a
    share = np.clip((way * d).sum(2) / np.maximum((d * d).sum(1), 1e-300), 0, 1)
    distance = np.linalg.norm(way - share[..., None] * d, axis=2).min(axis=1)
    found = [fitting_radius(grid, tuple(p), radius, LEAST_PART) for p in points]
    np.testing.assert_allclose(
        found, np.clip(distance, LEAST_PART * radius, radius), rtol=1e-9, atol=1e-12
    )
    assert (distance < radius).sum() > 100, "the test would see nothing"


def test_too_many_edges_are_left_out():
    segments = np.zeros((MOST_ENTRIES // 8 + 1, 2, 3))
    grid = edge_grid(segments, 1.0)
    assert len(grid.keys) == 0
    assert fitting_radius(grid, (0.0, 0.0, 0.0), 1.0, LEAST_PART) == 1.0
