"""What the kernels say of faces is what NumPy and SciPy say, on meshes without any order."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from photon_map.core.geometry.adjacency import connect, fill_boxes, mark_near
from photon_map.core.geometry.borders import SMOOTH_COSINE, border_sides
from photon_map.core.geometry.triangles import normals_and_areas
from photon_map.tests.meshes import mesh_of, surfaces_of


def soup(seed: int, points: int, faces: int):
    """Faces between random points: edges of one face, of many, and without length."""
    random = np.random.default_rng(seed)
    return mesh_of(random.normal(size=(points, 3)), random.integers(0, points, (faces, 3)))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("faces", [1, 12, 60])
def test_parts_are_numbered_as_connected_components(seed, faces):
    place = np.random.default_rng(seed).integers(0, 40, (faces, 3))
    part = np.zeros(40, np.int64)
    a, b = place[:, [0, 1]].ravel(), place[:, [1, 2]].ravel()
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(40, 40))
    count, wanted = connected_components(graph, directed=False)
    assert connect(place, part) == count
    assert (part == wanted).all()


def test_corners_at_one_place_share_its_number_in_the_order_of_the_vertices():
    random = np.random.default_rng(5)
    # 200 corners at 64 places, each with zeros of both signs and in any order.
    points = random.integers(-1, 3, (200, 3)) * random.choice([-1.0, 1.0], (200, 3))
    mesh = mesh_of(points, np.arange(198).reshape(66, 3))
    points = points[:198].astype(np.float32) + np.float32(0)
    _, first, number = np.unique(points, axis=0, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    assert (surfaces_of(mesh).place.ravel() == rank[number.ravel()]).all()


@pytest.mark.parametrize("seed", range(4))
def test_sides_stand_in_the_order_of_their_edges(seed):
    surfaces = surfaces_of(soup(seed, 9, 50))
    place, edges = surfaces.place, surfaces.edges
    a, b = place.ravel(), np.roll(place, -1, axis=1).ravel()
    key = np.minimum(a, b) * 1000 + np.maximum(a, b)
    assert (edges.sides == np.argsort(key, kind="stable")).all()
    assert (np.diff(edges.start) == np.unique(key, return_counts=True)[1]).all()
    assert (edges.of.ravel() == np.unique(key, return_inverse=True)[1].ravel()).all()
    faces = surfaces.mesh.faces.ravel()
    assert (edges.first == faces[edges.sides[edges.start[:-1]]]).all()
    assert (np.sort([edges.first, edges.second], axis=0)[0] * 1000 < key.max() + 1000).all()


@pytest.mark.parametrize("seed", range(4))
def test_a_side_ends_where_no_chosen_face_goes_on(seed):
    mesh = soup(seed, 8, 40)
    surfaces = surfaces_of(mesh)
    chosen = np.random.default_rng(seed).random(40) < 0.7
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    normals = normals_and_areas(corners)[0]
    assert surfaces.normals == pytest.approx(normals, abs=1e-12)
    way = np.roll(corners, -1, axis=1) - corners
    inward = np.cross(normals[:, None], way)
    inward /= np.maximum(np.linalg.norm(inward, axis=2, keepdims=True), 1e-300)
    wanted = set()
    for face in np.flatnonzero(chosen):
        for side in range(3):
            same = (surfaces.edges.of == surfaces.edges.of[face, side]) & chosen[:, None]
            cosine = inward[same] @ inward[face, side]
            if not (cosine < -SMOOTH_COSINE).any():
                wanted.add((face, side))
    assert set(zip(*border_sides(surfaces, chosen), strict=True)) == wanted
    assert 0 < len(wanted) < 3 * chosen.sum()


def test_faces_near_the_box_of_another_body():
    random = np.random.default_rng(2)
    centres = random.uniform(-1, 1, (60, 1, 3))
    corners = centres + random.normal(0, 0.1, (60, 3, 3))
    points, faces = corners.reshape(-1, 3), np.arange(180).reshape(-1, 3)
    body = random.integers(0, 12, 60).astype(np.int32)
    boxes = np.empty((12, 2, 3))
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    fill_boxes(points, faces, body, boxes)
    for k in range(12):
        own = corners[body == k].reshape(-1, 3)
        assert (boxes[k] == [own.min(axis=0), own.max(axis=0)]).all()
    near = np.zeros(60, np.bool_)
    mark_near(points, faces, body, boxes[:4] * 0.3, 0.01, near)
    low, high = corners.min(axis=1)[:, None], corners.max(axis=1)[:, None]
    meets = (low <= 0.3 * boxes[:4, 1] + 0.01) & (high >= 0.3 * boxes[:4, 0] - 0.01)
    other = body[:, None] != np.arange(4)
    assert (near == (meets.all(axis=2) & other).any(axis=1)).all()
    assert 0 < near.sum() < 60
