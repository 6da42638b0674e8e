"""Glass that touches: faces in one plane with another body's would be a tie of the rays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .interaction import OFFSET
from .mesh import Mesh
from .triangles import normals_and_areas

#: Planes nearer than this are one; relative to the face's largest coordinate.
_SAME = 2 * OFFSET
#: How far a touching face is moved outwards, relative to the same.
_MOVE = 4 * OFFSET
#: Cells that unit normals are sorted into.
_CELL = 4e-3
#: Half a step of float32, and the most by which normals of one plane are taken to differ.
_ROUNDING = 6e-8
_MOST_TILT = 1e-3
#: An odd direction: of a normal and its opposite, the one on its side stands for the plane.
_SIDE = np.array([0.6123, 0.5347, 0.5823])
#: Pairs of bodies in one plane whose boxes are compared; in a scene of more all count as
#: touching, which costs the sixth digit of the picture.
_MOST_PAIRS = 4_000_000
#: Faces that are looked at together.
_PIECE = 16384


class _Planes(NamedTuple):
    """Faces sorted into planes; a face at the rim of a cell is in both.

    face, plane (N,) and their body's number; ``start`` (P + 1,) of each plane.
    """

    face: NDArray[np.intp]
    plane: NDArray[np.intp]
    body: NDArray[np.int64]
    start: NDArray[np.intp]


class _Faces(NamedTuple):
    """The faces that may touch.

    id in the mesh; low, high (N, 3) corners of their boxes; normal and height of the
    plane; body; glass; largest: coordinate [m]; tilt: by how much float32 may have turned
    the normal [rad].
    """

    id: NDArray[np.intp]
    low: NDArray[np.float32]
    high: NDArray[np.float32]
    normal: NDArray[np.float64]
    height: NDArray[np.float64]
    body: NDArray[np.int64]
    glass: NDArray[np.bool_]
    largest: NDArray[np.float32]
    tilt: NDArray[np.float64]


def overlapped(mesh: Mesh, face_object: NDArray[np.int32], refracts: NDArray[np.bool_]) -> Mesh:
    """``mesh`` with the glass faces that lie in another body's plane moved into it.

    ``face_object`` (F,), ``refracts`` (M,) by material; a body is one material of one
    object. A ray that leaves glass for a table in the same plane starts behind both: the
    light is lost. Overlapping bodies have no such tie: the table is then met from inside of
    the glass. A body moves with all of its faces in the plane, so it stays flat; only
    float32's sixth digit of the picture changes.
    """
    if len(mesh.faces) == 0 or not refracts.any():
        return mesh
    glass = refracts[mesh.material]
    body = face_object.astype(np.int64) * len(refracts) + mesh.material
    if not glass.any() or (body == body[0]).all():
        return mesh
    faces = _near_glass(mesh, glass, body)
    planes = _shared(_planes(faces), faces)
    moving, distance = _touching(planes, faces)
    if len(moving) == 0:
        return mesh
    # A corner moves once in each direction, however many of its faces lie there.
    vertex = mesh.faces[faces.id[moving]].ravel().astype(np.int64)
    way = np.rint(8 * faces.normal[moving]).astype(np.int64) + 8
    way = np.repeat((way[:, 0] << 10) | (way[:, 1] << 5) | way[:, 2], 3)
    _, first = np.unique((vertex << 15) | way, return_index=True)
    step = np.repeat(faces.normal[moving] * distance[:, None], 3, axis=0)
    vertices = mesh.vertices.astype(np.float64)
    np.add.at(vertices, vertex[first], step[first])
    return mesh._replace(vertices=np.ascontiguousarray(vertices, dtype=np.float32))


def _near_glass(mesh: Mesh, glass: NDArray[np.bool_], body: NDArray[np.int64]) -> _Faces:
    """The glass, and what meets the box around all of it."""
    low, high = _boxes(mesh.vertices[mesh.faces])
    gap = _SAME * np.abs(mesh.vertices).max()
    near = np.ones(len(low), np.bool_)
    for k in range(3):
        # Column by column: numpy is slow along axes of three.
        near &= low[:, k] <= high[glass, k].max() + gap
        near &= high[:, k] >= low[glass, k].min() - gap
    chosen = np.flatnonzero(near)
    low, high = low[chosen], high[chosen]
    largest = _most(np.maximum(-low, high))
    # Piece by piece, so that what lies between stays in the processor's cache.
    pieces = [
        _planes_of(mesh.vertices[mesh.faces[part]].astype(np.float64))
        for part in np.array_split(chosen, len(chosen) // _PIECE + 1)
    ]
    normal, area, height = (np.concatenate(column) for column in zip(*pieces, strict=True))
    # The face's height over its longest side is what rounding turns it about.
    twice = np.maximum(2.0 * area, 1e-300)
    tilt = np.minimum(_ROUNDING * largest * _most(high - low) / twice, _MOST_TILT)
    return _Faces(chosen, low, high, normal, height, body[chosen], glass[chosen], largest, tilt)


def _planes_of(corners: NDArray[np.float64]) -> tuple[NDArray, NDArray, NDArray]:
    """Unit normals, areas, and the heights of the planes over the origin."""
    normal, area = normals_and_areas(corners)
    return normal, area, np.einsum("fk,fk->f", normal, corners[:, 0])


def _boxes(corners: NDArray) -> tuple[NDArray, NDArray]:
    """Lowest and highest corner of each face."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)


def _most(values: NDArray) -> NDArray:
    """The largest of each row of three."""
    return np.maximum(np.maximum(values[:, 0], values[:, 1]), values[:, 2])


def _planes(faces: _Faces) -> _Planes:
    """Sort the faces by normal, either way round, and by height; cut where there is a gap."""
    pieces = [
        _cells(faces.normal[part], faces.tilt[part])
        for part in np.array_split(np.arange(len(faces.id)), len(faces.id) // _PIECE + 1)
    ]
    start = np.cumsum([0] + [len(side) for side, _, _ in pieces[:-1]])
    face = np.concatenate([at + first for (_, at, _), first in zip(pieces, start, strict=True)])
    height = faces.height * np.concatenate([side for side, _, _ in pieces])
    key = np.concatenate([cell for _, _, cell in pieces])
    order = np.lexsort((height[face], key))
    face, key = face[order], key[order]
    gap = ((_SAME + faces.tilt) * faces.largest)[face]
    apart = np.diff(height[face]) > np.maximum(gap[1:], gap[:-1])
    cut = np.concatenate([[True], apart | (key[1:] != key[:-1])])
    first = np.append(np.flatnonzero(cut), len(face))
    return _Planes(face, np.cumsum(cut) - 1, faces.body[face], first)


def _cells(
    normal: NDArray[np.float64], tilt: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.intp], NDArray[np.int64]]:
    """Cells that planes of these normals lie in: (sides (N,), face and cell (M,) each).

    Faces at the rim of a cell are in the next one, too.
    """
    side = np.where(normal @ _SIDE < 0, -1.0, 1.0)
    place = normal * (side / _CELL)[:, None]
    cell = np.rint(place)
    place -= cell
    rim = np.where(np.abs(place) > 0.5 - tilt[:, None] / _CELL, np.sign(place), 0.0)
    edge = np.flatnonzero((rim[:, 0] != 0) | (rim[:, 1] != 0) | (rim[:, 2] != 0))
    index, cells = [np.arange(len(normal))], [cell]
    for axes in range(1, 8):
        turn = np.array([axes & 1, axes & 2, axes & 4]) > 0
        at = edge[(rim[edge][:, turn] != 0).all(axis=1)]
        index.append(at)
        cells.append(cell[at] + np.where(turn, rim[at], 0.0))
    whole = np.concatenate(cells).astype(np.int64) + 512
    key = (whole[:, 0] << 20) | (whole[:, 1] << 10) | whole[:, 2]
    return side, np.concatenate(index), key


def _shared(planes: _Planes, faces: _Faces) -> _Planes:
    """The planes in which glass lies and more than one body."""
    first = planes.start[:-1]
    body = planes.body
    lone = np.minimum.reduceat(body, first) == np.maximum.reduceat(body, first)
    glass = np.logical_or.reduceat(faces.glass[planes.face], first)
    kept = np.flatnonzero((~lone & glass)[planes.plane])
    plane = planes.plane[kept]
    cut = np.flatnonzero(np.diff(plane, prepend=-1))
    return _Planes(planes.face[kept], plane, body[kept], np.append(cut, len(kept)))


def _touching(planes: _Planes, faces: _Faces) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """The glass faces whose body's box meets another's in their plane, and their moves [m]."""
    order = np.lexsort((planes.body, planes.plane))
    face, plane, body = planes.face[order], planes.plane[order], planes.body[order]
    cut = np.concatenate([[True], (np.diff(plane) != 0) | (np.diff(body) != 0)])[: len(face)]
    group, start = np.cumsum(cut) - 1, np.flatnonzero(cut)
    if len(start) == 0:
        return face, np.zeros(0)
    low = np.minimum.reduceat(faces.low[face], start)
    high = np.maximum.reduceat(faces.high[face], start)
    largest = np.maximum.reduceat(faces.largest[face], start)
    glass = np.flatnonzero(np.logical_or.reduceat(faces.glass[face], start))
    # Groups of one plane lie side by side: each glass one against all of its plane.
    first = np.searchsorted(plane[start], plane[start[glass]], "left")
    count = np.searchsorted(plane[start], plane[start[glass]], "right") - first
    touches = np.zeros(len(start), np.bool_)
    if count.sum() > _MOST_PAIRS:
        touches[glass] = True
    else:
        own = np.repeat(glass, count)
        other = np.arange(len(own)) + np.repeat(first - np.cumsum(count) + count, count)
        gap = _SAME * largest[own]
        shared = np.minimum(high[own], high[other]) - np.maximum(low[own], low[other])
        # Side by side with a common edge is no overlap: it has two extents.
        wide = (shared > gap[:, None]).sum(axis=1) >= 2
        meet = (shared >= -gap[:, None]).all(axis=1) & wide & (own != other)
        touches[own[meet]] = True
    moving = touches[group]
    return face[moving], _MOVE * largest[group[moving]]
