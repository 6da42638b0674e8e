"""Crossings: where surfaces run into each other without a common edge.

A post that stands on a floor or cuts through it, a wall that reaches below the ground: the
floor goes on inside of the post, where no light comes, and beyond the wall, where other light
does. What meets is found by rays along all
edges; where it meets is worked out from both triangles (Moeller 1997, "A fast
triangle-triangle intersection test").
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .borders import ABOVE, BELOW, CROSSING, SMOOTH_COSINE, Borders
from .intersector import Intersector
from .mesh import Mesh
from .triangles import Floats, normals_and_areas

Indices = NDArray[np.intp]

#: Surfaces meet when they are apart by this part of the scene, where float32 ends, ...
_SAME = 1e-5
#: ... or by this part of the disc's radius, if the faces are larger than ten times that.
_NEAR, _OF_FACE = 0.02, 0.1
#: A ray goes on this far behind what it met, as a part of the scene.
_STEP = 5e-7
#: Surfaces that one edge may run through.
_MOST_MET = 16
#: Faces at one edge; where more meet they are left out.
_MOST_AT_EDGE = 6
#: In scenes of more bodies than this all edges are looked at, near another one or not.
_MOST_BOXES = 64


class _Edges(NamedTuple):
    """Sides of faces by place.

    first, second (E,): vertices; ``of`` (F, 3): the edge of each side; ``faces`` (3F,) in
    the order of their edges, those of edge e from ``start[e]`` to ``start[e + 1]``.
    """

    first: Indices
    second: Indices
    of: Indices
    faces: Indices
    start: Indices


def crossings(
    mesh: Mesh,
    place: NDArray[np.int64],
    body: NDArray[np.int32],
    holds: NDArray[np.bool_],
    intersector: Intersector,
    radius: float,
) -> Borders:
    """Where faces that ``holds`` (F,) go on beyond another one, for discs of ``radius`` [m].

    ``place`` (F, 3) of each corner, see ``places``; ``body`` (F,), see ``bodies``.
    """
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    edges = _edges(mesh.faces, place)
    chosen = _near_others(corners, body, edges, _NEAR * radius)
    edge, met = _met(mesh, edges, chosen, intersector, radius)
    face, other = _pairs(edges, edge, met, place, body)
    kept = holds[face]
    return _segments(mesh, corners, edges, face[kept], other[kept], radius)


def bodies(place: NDArray[np.int64], face_object: NDArray[np.int32]) -> NDArray[np.int32]:
    """Number (F,) of the connected part of an object that each face belongs to.

    Connected are faces that share the ``place`` (F, 3) of a corner.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = int(place.max(initial=0)) + 1
    a, b = place[:, [0, 1]].ravel(), place[:, [1, 2]].ravel()
    graph = coo_array((np.ones(len(a), np.int8), (a, b)), shape=(count, count))
    part = connected_components(graph, directed=False)[1]
    key = face_object * np.int64(count) + part[place[:, 0]]
    return np.unique(key, return_inverse=True)[1].reshape(-1).astype(np.int32)


def _edges(faces: NDArray[np.int32], place: NDArray[np.int64]) -> _Edges:
    first, second = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    a, b = place.ravel(), np.roll(place, -1, axis=1).ravel()
    key = np.minimum(a, b) * (int(place.max()) + 1) + np.maximum(a, b)
    order = np.argsort(key, kind="stable")
    begin = np.flatnonzero(np.diff(key[order], prepend=-1))
    of = np.zeros(len(key), np.intp)
    of[order] = np.repeat(np.arange(len(begin)), np.diff(np.append(begin, len(key))))
    one = order[begin]
    return _Edges(
        first[one], second[one], of.reshape(-1, 3), order // 3, np.append(begin, len(key))
    )


def _near_others(
    corners: Floats, body: NDArray[np.int32], edges: _Edges, reach: float
) -> Indices:
    """Edges of faces whose box meets the box of another body."""
    count = int(body.max(initial=0)) + 1
    if count == 1:
        return np.zeros(0, np.intp)
    if count > _MOST_BOXES:
        return np.arange(len(edges.first))
    low, high = corners.min(axis=1), corners.max(axis=1)
    near = np.zeros(len(body), np.bool_)
    for k in range(count):
        own = body == k
        box_low, box_high = low[own].min(axis=0) - reach, high[own].max(axis=0) + reach
        near |= ~own & (low <= box_high).all(axis=1) & (high >= box_low).all(axis=1)
    return np.unique(edges.of[near])


def _met(
    mesh: Mesh, edges: _Edges, chosen: Indices, intersector: Intersector, radius: float
) -> tuple[Indices, Indices]:
    """Which edge meets which face: (edge, face)."""
    begin = mesh.vertices[edges.first[chosen]].astype(np.float64)
    along = mesh.vertices[edges.second[chosen]].astype(np.float64) - begin
    length = np.linalg.norm(along, axis=1)
    chosen, begin, along = chosen[length > 0], begin[length > 0], along[length > 0]
    length = length[length > 0]
    along /= length[:, None]
    least = _SAME * float(np.abs(mesh.vertices).max(initial=0.0))
    reach = np.maximum(least, np.minimum(_NEAR * radius, _OF_FACE * length))
    # Beside the edge, on both sides of its body: where it stands on something a ray within
    # could find its own underside in the same place.
    out = normals_and_areas(mesh.vertices[mesh.faces[edges.faces]].astype(np.float64))[0]
    out = np.add.reduceat(out, edges.start[:-1])[chosen]
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300)
    found = [
        _along(mesh, intersector, begin + least * way * out, along, length, reach)
        for way in (1.0, -1.0)
    ]
    edge = chosen[np.concatenate([row for row, _ in found])]
    return edge, np.concatenate([face for _, face in found])


def _along(
    mesh: Mesh,
    intersector: Intersector,
    begin: Floats,
    along: Floats,
    length: Floats,
    reach: Floats,
) -> tuple[Indices, Indices]:
    """All on the ways from ``begin``, and ``reach`` before and beyond: (row, face)."""
    row = np.arange(len(begin))
    at = -reach
    step = _STEP * float(np.abs(mesh.vertices).max(initial=0.0))
    found = [(np.zeros(0, np.intp), np.zeros(0, np.intp))]
    for _ in range(_MOST_MET):
        origin = begin[row] + at[row, None] * along[row]
        hits = intersector.nearest(origin.astype(np.float32), along[row].astype(np.float32))
        on = hits.face >= 0
        row, face, u, v = row[on], hits.face[on].astype(np.intp), hits.u[on], hits.v[on]
        a, b, c = (mesh.vertices[mesh.faces[face, k]].astype(np.float64) for k in range(3))
        point = a + u[:, None] * (b - a) + v[:, None] * (c - a)
        place = ((point - begin[row]) * along[row]).sum(axis=1)
        # At least a step: rounding must not find the same face again and again.
        at[row] = np.maximum(place, at[row]) + step
        on = place <= (length + reach)[row]
        row, face = row[on], face[on]
        found.append((row, face))
        if len(row) == 0:
            break
    return np.concatenate([r for r, _ in found]), np.concatenate([f for _, f in found])


def _pairs(
    edges: _Edges,
    edge: Indices,
    met: Indices,
    place: NDArray[np.int64],
    body: NDArray[np.int32],
) -> tuple[Indices, Indices]:
    """Each pair of faces once, both ways round, that may cross; no neighbours of one body.

    The neighbours of a face that is met are looked at too: what is met may lie on its rim.
    """
    face, row = _faces_of(edges, edge)
    met = met[row]
    beside, row = _faces_of(edges, edges.of[met].ravel())
    row //= 3
    a, b = np.concatenate([face, face[row]]), np.concatenate([met, beside])
    key = np.unique(np.minimum(a, b) * len(place) + np.maximum(a, b))
    a, b = key // len(place), key % len(place)
    shared = (place[a][:, :, None] == place[b][:, None, :]).any(axis=(1, 2))
    apart = ~shared | (body[a] != body[b])
    c, d = _at_one_edge(edges)
    a, b = np.concatenate([a[apart], c]), np.concatenate([b[apart], d])
    return np.concatenate([a, b]), np.concatenate([b, a])


def _at_one_edge(edges: _Edges) -> tuple[Indices, Indices]:
    """Pairs of faces at edges of three faces or more: a wall on a floor that goes on."""
    count = np.diff(edges.start)
    many = np.flatnonzero((count > 2) & (count <= _MOST_AT_EDGE))
    pairs = [(np.zeros(0, np.intp), np.zeros(0, np.intp))]
    for i in range(_MOST_AT_EDGE):
        for j in range(i + 1, _MOST_AT_EDGE):
            first = edges.start[many[count[many] > j]]
            pairs.append((edges.faces[first + i], edges.faces[first + j]))
    return np.concatenate([a for a, _ in pairs]), np.concatenate([b for _, b in pairs])


def _faces_of(edges: _Edges, edge: Indices) -> tuple[Indices, Indices]:
    """Faces at each of ``edge`` (N,): (faces, rows of ``edge``)."""
    count = edges.start[edge + 1] - edges.start[edge]
    row = np.repeat(np.arange(len(edge)), count)
    step = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    return edges.faces[edges.start[edge][row] + step], row


def _segments(
    mesh: Mesh,
    corners: Floats,
    edges: _Edges,
    face: Indices,
    other: Indices,
    radius: float,
) -> Borders:
    """What the pairs have in common: the line of their planes within both triangles."""
    f, g = corners[face], corners[other]
    normal_f, normal_g = normals_and_areas(f)[0], normals_and_areas(g)[0]
    cosine = (normal_f * normal_g).sum(axis=1)
    flat = (normal_f == 0).all(axis=1) | (normal_g == 0).all(axis=1)
    kept = ~flat & (np.abs(cosine) < SMOOTH_COSINE)
    face, other, f, g = face[kept], other[kept], f[kept], g[kept]
    normal_f, normal_g, cosine = normal_f[kept], normal_g[kept], cosine[kept]
    least = _SAME * float(np.abs(mesh.vertices).max())
    near = np.maximum(least, np.minimum(_NEAR * radius, _OF_FACE * _least_side(f, g)))
    height_f = ((f - g[:, :1]) * normal_g[:, None]).sum(axis=2)
    height_g = ((g - f[:, :1]) * normal_f[:, None]).sum(axis=2)
    height_f[np.abs(height_f) < near[:, None]] = 0.0
    height_g[np.abs(height_g) < near[:, None]] = 0.0
    line = np.cross(normal_f, normal_g) / np.sqrt(1.0 - cosine * cosine)[:, None]
    low_f, high_f = _span((f * line[:, None]).sum(axis=2), height_f)
    low_g, high_g = _span((g * line[:, None]).sum(axis=2), height_g)
    low, high = np.maximum(low_f, low_g), np.minimum(high_f, high_g)
    kept = (high - low > least) & (height_g != 0).any(axis=1)
    through = (height_f.min(axis=1) < 0) & (height_f.max(axis=1) > 0)
    kept[kept] = through[kept] | _goes_on(
        corners, edges, face[kept], other[kept], height_f[kept]
    )
    normal = normal_f[kept]
    ends = _points(f[kept, 0], g[kept, 0], normal, normal_g[kept], low[kept], high[kept])
    none = np.full(len(ends), np.inf)
    return Borders(ends, normal, none, np.full(len(ends), ABOVE | BELOW | CROSSING, np.int8))


def _points(
    f: Floats, g: Floats, normal_f: Floats, normal_g: Floats, low: Floats, high: Floats
) -> Floats:
    """Points (N, 2, 3) at ``low`` and ``high`` on the line of two planes."""
    cosine = (normal_f * normal_g).sum(axis=1, keepdims=True)
    sine2 = 1.0 - cosine * cosine
    line = np.cross(normal_f, normal_g) / np.sqrt(sine2)
    at_f = (normal_f * f).sum(axis=1, keepdims=True)
    at_g = (normal_g * g).sum(axis=1, keepdims=True)
    foot = ((at_f - at_g * cosine) * normal_f + (at_g - at_f * cosine) * normal_g) / sine2
    ends: Floats = foot[:, None] + np.stack([low, high], axis=1)[..., None] * line[:, None]
    return ends


def _least_side(f: Floats, g: Floats) -> Floats:
    """Shortest side (N,) of both triangles."""
    sides = [np.linalg.norm(t - np.roll(t, 1, axis=1), axis=2).min(axis=1) for t in (f, g)]
    least: Floats = np.minimum(*sides)
    return least


def _span(along: Floats, height: Floats) -> tuple[Floats, Floats]:
    """Where triangles cut a plane, on the line (N,): lowest and highest; none: (inf, -inf).

    ``along`` (N, 3): the corners' places on the line; ``height`` over the plane.
    """
    low, high = np.full(len(along), np.inf), np.full(len(along), -np.inf)
    for k in range(3):
        m = (k + 1) % 3
        on = height[:, k] == 0
        between = height[:, k] * height[:, m] < 0
        rise = np.where(between, height[:, k] - height[:, m], 1.0)
        cut = along[:, k] + (along[:, m] - along[:, k]) * height[:, k] / rise
        for chosen, place in ((on, along[:, k]), (between, cut)):
            low = np.where(chosen, np.minimum(low, place), low)
            high = np.where(chosen, np.maximum(high, place), high)
    return low, high


def _goes_on(
    corners: Floats, edges: _Edges, face: Indices, other: Indices, height: Floats
) -> NDArray[np.bool_]:
    """Whether a side of ``face`` lies in the plane of ``other`` and a neighbour goes on there.

    ``height`` (N, 3): of the face's corners over that plane.
    """
    zero = height == 0
    rows = np.flatnonzero(zero.sum(axis=1) == 2)
    # Side k runs from corner k to the next: it lies in the plane when both do.
    side = (zero & np.roll(zero, -1, axis=1))[rows].argmax(axis=1)
    beside, row = _faces_of(edges, edges.of[face[rows], side])
    row = rows[row]
    own, next_, plane = corners[face[row]], corners[beside], corners[other[row]]
    normal = normals_and_areas(plane)[0]
    over = ((next_ - plane[:, :1]) * normal[:, None]).sum(axis=2)
    beyond = (over * -np.sign(height[row].sum(axis=1))[:, None]).max(axis=1)
    bend = (normals_and_areas(own)[0] * normals_and_areas(next_)[0]).sum(axis=1)
    # Of the neighbour's corners two are the side's own, so the other one is the farthest.
    on = (np.abs(bend) > SMOOTH_COSINE) & (beyond > np.abs(over).max(axis=1) / 2)
    goes = np.zeros(len(face), np.bool_)
    goes[row[on & (beside != face[row])]] = True
    return goes
