"""Crossings: where surfaces run into each other without a common edge.

A post that stands on a floor or cuts through it, a wall that reaches below the ground: the
floor goes on inside of the post, where no light comes, and beyond the wall, where other light
does. What meets is found by rays along all edges; where it meets is worked out from both
triangles (Moeller 1997, "A fast triangle-triangle intersection test").
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .adjacency import fill_boxes, mark_near
from .borders import ABOVE, BELOW, CROSSING, SMOOTH_COSINE, Borders
from .intersector import Intersector
from .surfaces import Edges, Indices, Surfaces
from .triangles import Floats

#: Surfaces meet when they are apart by this part of the scene, where float32 ends, ...
_SAME = 1e-5
#: ... or by this part of the disc's radius, if the faces are larger than five times that: not
#: ten, as a ring of 512 sides of 6 mm that stood 1 mm above the floor let light through.
_NEAR, _OF_FACE = 0.02, 0.2
#: A ray goes on this far behind what it met, as a part of the scene.
_STEP = 5e-7
#: Surfaces that one edge may run through.
_MOST_MET = 16
#: Faces at one edge; where more meet they are left out.
_MOST_AT_EDGE = 6
#: In scenes of more bodies than this all edges are looked at, near another one or not.
_MOST_BOXES = 64


def crossings(
    surfaces: Surfaces, holds: NDArray[np.bool_], intersector: Intersector, radius: float
) -> Borders:
    """Where faces that ``holds`` (F,) go on beyond another one, for discs of ``radius`` [m]."""
    chosen = _near_others(surfaces, _NEAR * radius)
    edge, met = _met(surfaces, chosen, intersector, radius)
    face, other = _pairs(surfaces, edge, met)
    intersector.go_on()
    kept = holds[face]
    return _segments(surfaces, face[kept], other[kept], radius)


def _near_others(surfaces: Surfaces, reach: float) -> Indices:
    """Edges of faces whose box meets the box of another body."""
    body, edges = surfaces.body, surfaces.edges
    count = int(body.max(initial=0)) + 1
    if count == 1:
        return np.zeros(0, np.intp)
    if count > _MOST_BOXES:
        return np.arange(len(edges.first))
    boxes = np.empty((count, 2, 3))
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    faces, near = surfaces.mesh.faces, np.zeros(len(body), np.bool_)
    fill_boxes(surfaces.points, faces, body, boxes)
    mark_near(surfaces.points, faces, body, boxes, reach, near)
    return np.unique(edges.of[near])


def _met(
    surfaces: Surfaces, chosen: Indices, intersector: Intersector, radius: float
) -> tuple[Indices, Indices]:
    """Which edge meets which face: (edge, face)."""
    mesh, edges = surfaces.mesh, surfaces.edges
    begin = mesh.vertices[edges.first[chosen]].astype(np.float64)
    along = mesh.vertices[edges.second[chosen]].astype(np.float64) - begin
    length = np.linalg.norm(along, axis=1)
    chosen, begin, along = chosen[length > 0], begin[length > 0], along[length > 0]
    length = length[length > 0]
    along /= length[:, None]
    least = _SAME * surfaces.largest
    reach = np.maximum(least, np.minimum(_NEAR * radius, _OF_FACE * length))
    # Beside the edge, on both sides of its body: where it stands on something a ray within
    # could find its own underside in the same place.
    faces, row = surfaces.faces_at(chosen)
    out = np.zeros_like(begin)
    np.add.at(out, row, surfaces.normals[faces])
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-300)
    found = [
        _along(surfaces, intersector, begin + least * way * out, along, length, reach)
        for way in (1.0, -1.0)
    ]
    edge = chosen[np.concatenate([row for row, _ in found])]
    return edge, np.concatenate([face for _, face in found])


def _along(
    surfaces: Surfaces,
    intersector: Intersector,
    begin: Floats,
    along: Floats,
    length: Floats,
    reach: Floats,
) -> tuple[Indices, Indices]:
    """All on the ways from ``begin``, and ``reach`` before and beyond: (row, face)."""
    mesh = surfaces.mesh
    row = np.arange(len(begin))
    at = -reach
    step = _STEP * surfaces.largest
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


def _pairs(surfaces: Surfaces, edge: Indices, met: Indices) -> tuple[Indices, Indices]:
    """Each pair of faces once, both ways round, that may cross; no neighbours of one body.

    The neighbours of a face that is met are looked at too: what is met may lie on its rim.
    """
    place, body = surfaces.place, surfaces.body
    face, row = surfaces.faces_at(edge)
    met = met[row]
    beside, row = surfaces.faces_at(surfaces.edges.of[met].ravel())
    row //= 3
    a, b = np.concatenate([face, face[row]]), np.concatenate([met, beside])
    key = np.unique(np.minimum(a, b) * len(place) + np.maximum(a, b))
    a, b = key // len(place), key % len(place)
    shared = (place[a][:, :, None] == place[b][:, None, :]).any(axis=(1, 2))
    apart = ~shared | (body[a] != body[b])
    c, d = _at_one_edge(surfaces.edges)
    a, b = np.concatenate([a[apart], c]), np.concatenate([b[apart], d])
    return np.concatenate([a, b]), np.concatenate([b, a])


def _at_one_edge(edges: Edges) -> tuple[Indices, Indices]:
    """Pairs of faces at edges of three faces or more: a wall on a floor that goes on."""
    count = np.diff(edges.start)
    many = np.flatnonzero((count > 2) & (count <= _MOST_AT_EDGE))
    pairs = [(np.zeros(0, np.intp), np.zeros(0, np.intp))]
    for i in range(_MOST_AT_EDGE):
        for j in range(i + 1, _MOST_AT_EDGE):
            first = edges.start[many[count[many] > j]]
            pairs.append((edges.sides[first + i] // 3, edges.sides[first + j] // 3))
    return np.concatenate([a for a, _ in pairs]), np.concatenate([b for _, b in pairs])


def _segments(surfaces: Surfaces, face: Indices, other: Indices, radius: float) -> Borders:
    """What the pairs have in common: the line of their planes within both triangles."""
    f, g = surfaces.corners(face), surfaces.corners(other)
    normal_f, normal_g = surfaces.normals[face], surfaces.normals[other]
    cosine = (normal_f * normal_g).sum(axis=1)
    flat = (normal_f == 0).all(axis=1) | (normal_g == 0).all(axis=1)
    kept = ~flat & (np.abs(cosine) < SMOOTH_COSINE)
    face, other, f, g = face[kept], other[kept], f[kept], g[kept]
    normal_f, normal_g, cosine = normal_f[kept], normal_g[kept], cosine[kept]
    least = _SAME * surfaces.largest
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
    kept[kept] = through[kept] | _goes_on(surfaces, face[kept], other[kept], height_f[kept])
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
    surfaces: Surfaces, face: Indices, other: Indices, height: Floats
) -> NDArray[np.bool_]:
    """Whether a side of ``face`` lies in the plane of ``other`` and a neighbour goes on there.

    ``height`` (N, 3): of the face's corners over that plane.
    """
    zero = height == 0
    rows = np.flatnonzero(zero.sum(axis=1) == 2)
    # Side k runs from corner k to the next: it lies in the plane when both do.
    side = (zero & np.roll(zero, -1, axis=1))[rows].argmax(axis=1)
    beside, row = surfaces.faces_at(surfaces.edges.of[face[rows], side])
    row = rows[row]
    own, plane, normals = face[row], other[row], surfaces.normals
    way = surfaces.corners(beside) - surfaces.corners(plane)[:, :1]
    over = (way * normals[plane][:, None]).sum(axis=2)
    beyond = (over * -np.sign(height[row].sum(axis=1))[:, None]).max(axis=1)
    bend = (normals[own] * normals[beside]).sum(axis=1)
    # Of the neighbour's corners two are the side's own, so the other one is the farthest.
    on = (np.abs(bend) > SMOOTH_COSINE) & (beyond > np.abs(over).max(axis=1) / 2)
    goes = np.zeros(len(face), np.bool_)
    goes[row[on & (beside != own)]] = True
    return goes
