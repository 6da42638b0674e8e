"""How the faces of a mesh hang together: places, edges, bodies.

Worked out when it is asked for, and once: it takes seconds for a million faces.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .adjacency import connect, fill_normals, number_places, sort_sides
from .mesh import Mesh
from .triangles import Floats

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
    def points(self) -> Floats:
        """The vertices (V, 3) [m]."""
        return self.mesh.vertices.astype(np.float64)

    @cached_property
    def normals(self) -> Floats:
        """Unit normals (F, 3) by winding; 0 of a face without area."""
        normals = np.zeros((len(self.mesh.faces), 3))
        fill_normals(self.points, self.mesh.faces, normals)
        return normals

    @cached_property
    def place(self) -> NDArray[np.int64]:
        """A number (F, 3) for the place of each corner: those at one place share it.

        They follow the vertices, so that what lies side by side in memory lies so here.
        """
        vertices = self.mesh.vertices + np.float32(0)  # -0 is the same place as 0
        place = np.zeros(len(vertices), np.int64)
        slots = 1 << max(4, (2 * len(vertices)).bit_length())
        number_places(vertices, vertices.view(np.uint32), np.full(slots, -1, np.int64), place)
        return place[self.mesh.faces]

    @cached_property
    def body(self) -> NDArray[np.int32]:
        """Number (F,) of the connected part of an object that each face belongs to.

        Connected are faces that share the place of a corner.
        """
        place = self.place
        part = np.zeros(int(place.max(initial=-1)) + 1, np.int64)
        count = connect(place, part)
        key = self._face_object * np.int64(count) + part[place[:, 0]]
        used = np.zeros(int(key.max(initial=-1)) + 1, np.bool_)
        used[key] = True
        number: NDArray[np.int32] = (np.cumsum(used) - 1).astype(np.int32)[key]
        return number

    @cached_property
    def edges(self) -> Edges:
        """The edges; faces may have corners of their own at one place."""
        faces, place = self.mesh.faces, self.place
        begin = np.zeros(int(place.max(initial=-1)) + 2, np.intp)
        sides, of = np.zeros(place.size, np.intp), np.zeros(place.shape, np.intp)
        start = np.zeros(place.size + 1, np.intp)
        count = sort_sides(place, begin, sides, of, start)
        start = start[: count + 1].copy()
        face, k = np.divmod(sides[start[:-1]], 3)
        return Edges(
            faces[face, k].astype(np.intp), faces[face, (k + 1) % 3].astype(np.intp),
            of, sides, start,
        )  # fmt: skip

    def corners(self, face: Indices | slice) -> Floats:
        """Corners (N, 3, 3) of faces (N,) [m]."""
        return self.mesh.vertices[self.mesh.faces[face]].astype(np.float64)

    def faces_at(self, edge: Indices) -> tuple[Indices, Indices]:
        """Faces at each of ``edge`` (N,): (faces, rows of ``edge``)."""
        start = self.edges.start
        count = start[edge + 1] - start[edge]
        row = np.repeat(np.arange(len(edge)), count)
        step = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
        return self.edges.sides[start[edge][row] + step] // 3, row
