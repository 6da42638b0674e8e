"""How the faces of a mesh hang together: places, edges, bodies.

Worked out when it is asked for, and once: it takes seconds for a million faces.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .mesh import Mesh
from .triangles import Floats, normals_and_areas

Indices: TypeAlias = NDArray[np.intp]


class Edges(NamedTuple):
    """Sides of faces by place; side k of a face starts at its corner k.

    first, second (E,): vertices; ``of`` (F, 3): the edge of each side; ``sides`` (3F,):
    3 * face + side in the order of their edges, those of edge e from ``start[e]`` to
    ``start[e + 1]``.
    """

    first: Indices
    second: Indices
    of: Indices
    sides: Indices
    start: Indices


class Surfaces:
    """The faces of ``mesh``; ``face_object`` (F,) i4 says what each is a part of."""

    def __init__(self, mesh: Mesh, face_object: NDArray[np.int32]) -> None:
        self.mesh = mesh
        self._face_object = face_object

    @cached_property
    def largest(self) -> float:
        """The largest coordinate [m]: float32 is as fine as a part of it."""
        return float(np.abs(self.mesh.vertices).max(initial=0.0))

    @cached_property
    def normals(self) -> Floats:
        """Unit normals (F, 3) by winding; 0 of a face without area."""
        return normals_and_areas(self.corners(slice(None)))[0]

    @cached_property
    def place(self) -> NDArray[np.int64]:
        """A number (F, 3) for the place of each corner: those at one place share it."""
        vertices = self.mesh.vertices
        # Sorted by one mixed number: faster than by three coordinates. Those that have it by
        # chance alone stay apart. Adding 0 makes -0 the same place as 0.
        bits = (vertices + np.float32(0)).view(np.uint32).astype(np.uint64)
        mixed = np.zeros(len(bits), np.uint64)
        for k in range(3):
            mixed = (mixed ^ bits[:, k]) * np.uint64(0x9E3779B97F4A7C15)
            mixed ^= mixed >> np.uint64(29)
        order = np.argsort(mixed)
        new = np.ones(len(order), np.int64)
        new[1:] = (vertices[order[1:]] != vertices[order[:-1]]).any(axis=1)
        place = np.zeros(len(order), np.int64)
        place[order] = np.cumsum(new) - 1
        return place[self.mesh.faces]

    @cached_property
    def body(self) -> NDArray[np.int32]:
        """Number (F,) of the connected part of an object that each face belongs to.

        Connected are faces that share the place of a corner.
        """
        from scipy.sparse import coo_array
        from scipy.sparse.csgraph import connected_components

        place = self.place
        count = int(place.max(initial=0)) + 1
        a, b = place[:, [0, 1]].ravel(), place[:, [1, 2]].ravel()
        graph = coo_array((np.ones(len(a), np.int8), (a, b)), shape=(count, count))
        part = connected_components(graph, directed=False)[1]
        key = self._face_object * np.int64(count) + part[place[:, 0]]
        return np.unique(key, return_inverse=True)[1].reshape(-1).astype(np.int32)

    @cached_property
    def edges(self) -> Edges:
        """The edges; faces may have corners of their own at one place."""
        faces, place = self.mesh.faces, self.place
        first, second = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
        a, b = place.ravel(), np.roll(place, -1, axis=1).ravel()
        key = np.minimum(a, b) * (int(place.max(initial=0)) + 1) + np.maximum(a, b)
        order = np.argsort(key, kind="stable")
        begin = np.flatnonzero(np.diff(key[order], prepend=-1))
        start = np.append(begin, len(key))
        of = np.zeros(len(key), np.intp)
        of[order] = np.repeat(np.arange(len(begin)), np.diff(start))
        one = order[begin]
        return Edges(first[one], second[one], of.reshape(-1, 3), order, start)

    def corners(self, face: Indices | slice) -> Floats:
        """Corners (N, 3, 3) of faces (N,) [m]."""
        return self.mesh.vertices[self.mesh.faces[face]].astype(np.float64)

    def inward(self, side: Indices) -> Floats:
        """Unit vectors (N, 3) in the faces' planes, inwards from ``side``, as in ``Edges``."""
        face, k = side // 3, side % 3
        ends = (self.mesh.vertices[self.mesh.faces[face, j]] for j in (k, (k + 1) % 3))
        begin, end = (v.astype(np.float64) for v in ends)
        way = np.cross(self.normals[face], end - begin)
        unit: Floats = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-300)
        return unit

    def faces_at(self, edge: Indices) -> tuple[Indices, Indices]:
        """Faces at each of ``edge`` (N,): (faces, rows of ``edge``)."""
        start = self.edges.start
        count = start[edge + 1] - start[edge]
        row = np.repeat(np.arange(len(edge)), count)
        step = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
        return self.edges.sides[start[edge][row] + step] // 3, row
