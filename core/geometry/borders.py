"""Borders: where surfaces end or fold, so that no photon of theirs lies beyond.

A half edge (a side of a face) is a border when no other face goes on smoothly from it. It
is cut into pieces, and beside each piece rays look for another surface that takes over: the
desk around a sheet of paper, a wall built of tiles.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .adjacency import mark_ends
from .intersector import Intersector
from .mesh import Mesh
from .surfaces import Surfaces
from .triangles import Floats, normals_and_areas

#: Faces and their sides (B,) each.
Sides: TypeAlias = tuple[NDArray[np.intp], NDArray[np.intp]]

#: Bits of ``Borders.parts``.
ABOVE, BELOW, CROSSING = 1, 2, 4
#: Faces that meet at a fold sharper than this cosine (45 degrees) make a border.
SMOOTH_COSINE = 0.7
#: Neighbours in the sorted list of half edges that are compared: faces at one edge.
_FAN = 16
#: Parts of the longest pieces that are probed, each by itself.
_PARTS = 8
#: An edge of more pieces is left out: its surface is too wide for its rim to matter much.
_MOST_STEPS = 4096
#: How far from a border its surroundings are probed, relative to the piece, and relative to
#: the largest coordinate, where float32 ends.
_PROBE, _LEAST_PROBE = 0.01, 1e-5
#: A surface goes on in the same plane when it does so to this part of the piece.
_FLUSH = 1e-3
#: Borders are the same when their ends agree to this part of the scene.
_SAME = 1e-5
#: ... and their faces lie on one side, to this cosine.
_ONE_PLANE = 0.99


class Borders(NamedTuple):
    """Pieces of borders.

    ends (E, 2, 3) f8, counter-clockwise about the unit normal (E, 3) f8 of their face; gap
    (E,) f8: how far above or below that plane a surface goes on beside it [m], inf if none;
    parts (E,) i1: whether a surface stands there and parts the light, bits of ``ABOVE`` (on
    the normal's side), ``BELOW``, and ``CROSSING`` (the face goes on beyond).
    """

    ends: Floats
    normal: Floats
    gap: Floats
    parts: NDArray[np.int8]


def no_borders() -> Borders:
    """Of a scene without surfaces that hold photons."""
    return Borders(np.zeros((0, 2, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0, np.int8))


def borders_of(
    mesh: Mesh,
    sides: Sides,
    holds: NDArray[np.bool_],
    intersector: Intersector,
    longest: float,
    most: int,
) -> Borders:
    """Borders of the faces that ``holds`` (F,), at most ``most`` pieces, ``longest`` [m] each.

    ``sides``: their ``border_sides``, which do not depend on the length of the pieces.
    In scenes with more pieces the shortest edges are left out: those of leaves and hair,
    which are smaller than any disc.
    """
    face, side = sides
    corners = mesh.vertices[mesh.faces[face]].astype(np.float64)
    rows = np.arange(len(face))
    ends = np.stack([corners[rows, side], corners[rows, (side + 1) % 3]], axis=1)
    normal = normals_and_areas(corners)[0]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    used = (length > 0) & (normal != 0).any(axis=1) & (length <= _MOST_STEPS * longest)
    steps = np.ceil(length / longest).astype(np.int64)
    used &= length >= _least_length(length[used], steps[used], most)
    if not used.any():
        return no_borders()
    ends, normal, steps = ends[used], normal[used], steps[used]
    first = _first_of_each(ends, normal, _SAME * float(np.abs(mesh.vertices).max()))
    pieces, normal = _cut(ends[first], normal[first], steps[first])
    length = np.linalg.norm(pieces[:, 1] - pieces[:, 0], axis=1)
    counts = np.ceil(_PARTS * length / longest).astype(np.int64)
    parts, own = _cut(pieces, normal, counts)
    gap = _gaps(mesh, holds, intersector, parts, own)
    walls = _walls(mesh, intersector, parts, own)
    # What goes on in the same plane behind a wall is another room's; above it, a step.
    size = np.linalg.norm(parts[:, 1] - parts[:, 0], axis=1)
    gap[(walls != 0) & (gap <= _FLUSH * size)] = np.inf
    # Where all parts of a piece are alike they stay one.
    begin = np.cumsum(counts) - counts
    alike = _same(gap, begin, counts) & _same(walls, begin, counts)
    split = np.repeat(~alike, counts)
    return Borders(
        np.concatenate([pieces[alike], parts[split]]),
        np.concatenate([normal[alike], own[split]]),
        np.concatenate([gap[begin[alike]], gap[split]]),
        np.concatenate([walls[begin[alike]], walls[split]]),
    )


def _same(
    values: NDArray, begin: NDArray[np.int64], counts: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Whether the ``counts`` values from each ``begin`` on are one and the same."""
    equal = (values == np.repeat(values[begin], counts)).astype(np.int64)
    same: NDArray[np.bool_] = np.add.reduceat(equal, begin) == counts
    return same


def joined(*parts: Borders) -> Borders:
    """All of ``parts``."""
    return Borders(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def short(whole: Borders, longest: float, most: int) -> Borders:
    """At most ``most`` pieces of ``whole``, ``longest`` [m] each: those of the longest ones."""
    length = np.linalg.norm(whole.ends[:, 1] - whole.ends[:, 0], axis=1)
    steps = np.maximum(np.ceil(length / longest), 1).astype(np.int64)
    kept = length >= _least_length(length, steps, most)
    steps = steps[kept]
    ends, normal = _cut(whole.ends[kept], whole.normal[kept], steps)
    return Borders(
        ends, normal, np.repeat(whole.gap[kept], steps), np.repeat(whole.parts[kept], steps)
    )


def _cut(ends: Floats, normal: Floats, steps: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Each edge cut into ``steps`` (E,) equal parts, in order: (ends, normal)."""
    edge = np.repeat(np.arange(len(ends)), steps)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(steps) - steps, steps)
    t = (np.stack([step, step + 1], axis=1) / steps[edge][:, None])[..., None]
    return ends[edge, :1] * (1 - t) + ends[edge, 1:] * t, normal[edge]


def border_sides(surfaces: Surfaces, chosen: NDArray[np.bool_]) -> Sides:
    """Faces and sides (B,) from which none of the ``chosen`` (F,) faces goes on.

    Side k starts at corner k. Faces of different objects, or flat ones, may have corners of
    their own at one place.
    """
    edges = surfaces.edges
    ends = np.zeros(len(edges.sides), np.bool_)
    mark_ends(
        surfaces.points, surfaces.mesh.faces, surfaces.normals, chosen, edges.sides,
        edges.start, -SMOOTH_COSINE, np.zeros((_FAN, 3)), np.zeros(_FAN, np.int64), ends,
    )  # fmt: skip
    side = np.sort(edges.sides[ends])
    return side // 3, side % 3


def _first_of_each(ends: Floats, normal: Floats, step: float) -> NDArray[np.bool_]:
    """Which edges (E,) are the first with their ends: a face may lie there twice.

    The faces must lie on one side of it. Edges shorter than ``step`` all differ.
    """
    inward = np.cross(normal, ends[:, 1] - ends[:, 0])
    place = np.floor(ends / step + 0.5).astype(np.int64).reshape(-1, 3)
    number = np.unique(place, axis=0, return_inverse=True)[1].reshape(-1, 2)
    number.sort(axis=1)
    key = number[:, 0] * len(place) + number[:, 1]
    order = np.argsort(key, kind="stable")
    unit = inward / np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), 1e-300)
    first = np.ones(len(key), np.bool_)
    for far in range(1, min(_FAN, len(key))):
        same = np.flatnonzero(key[order[:-far]] == key[order[far:]])
        if len(same) == 0:
            break
        a, b = order[same], order[same + far]
        first[b[(unit[a] * unit[b]).sum(axis=1) > _ONE_PLANE]] = False
    first[number[:, 0] == number[:, 1]] = True
    return first


def _least_length(length: Floats, steps: NDArray[np.int64], most: int) -> float:
    """Length from which on edges have at most ``most`` pieces together."""
    order = np.argsort(-length, kind="stable")
    count = int(np.searchsorted(np.cumsum(steps[order]), most, side="right"))
    if count == len(length):
        return 0.0
    # Edges about as long as the first that is too many are left out together.
    return 2.0 * float(length[order[count]])


def _walls(
    mesh: Mesh, intersector: Intersector, pieces: Floats, up: Floats
) -> NDArray[np.int8]:
    """``Borders.parts`` of pieces (E, 2, 3): whether a short way over the border is blocked."""
    beside, outward, step = _beside(mesh, pieces, up)
    walls = np.zeros(len(pieces), np.int8)
    for sign, bit in ((1.0, ABOVE), (-1.0, BELOW)):
        origin = beside - 2 * step * outward + sign * step * up
        # Walls that lean outwards by up to 60 degrees are met, too.
        far = np.full(len(pieces), 4.0, np.float32)
        way = (step * outward).astype(np.float32)
        walls[~intersector.is_free(origin.astype(np.float32), way, far)] |= bit
    return walls


def _beside(mesh: Mesh, pieces: Floats, up: Floats) -> tuple[Floats, Floats, Floats]:
    """Places a step outside of pieces and ways outwards (E, 3), steps (E, 1) [m]."""
    along = pieces[:, 1] - pieces[:, 0]
    length = np.linalg.norm(along, axis=1, keepdims=True)
    outward = np.cross(along / np.maximum(length, 1e-300), up)
    step = np.maximum(_PROBE * length, _LEAST_PROBE * np.abs(mesh.vertices).max())
    return pieces.mean(axis=1) + step * outward, outward, step


def _gaps(
    mesh: Mesh, holds: NDArray[np.bool_], intersector: Intersector, pieces: Floats, up: Floats
) -> Floats:
    """``Borders.gap`` of pieces (E, 2, 3) of faces with the normals ``up`` (E, 3)."""
    beside, _, step = _beside(mesh, pieces, up)
    gap = np.full(len(pieces), np.inf)
    for sign in (1.0, -1.0):
        # Each ray starts on the other side of the plane, so both see what lies in it.
        origin = (beside + sign * step * up).astype(np.float32)
        hits = intersector.nearest(origin, (-sign * up).astype(np.float32))
        hit = np.flatnonzero(hits.face >= 0)
        hit = hit[holds[hits.face[hit]]]
        corners = mesh.vertices[mesh.faces[hits.face[hit]]].astype(np.float64)
        normal = normals_and_areas(corners)[0]
        cosine = (normal * up[hit]).sum(axis=1)
        flat = np.abs(cosine) > SMOOTH_COSINE
        hit, corners, normal, cosine = hit[flat], corners[flat], normal[flat], cosine[flat]
        height = ((corners[:, 0] - beside[hit]) * normal).sum(axis=1) / cosine
        gap[hit] = np.minimum(gap[hit], np.abs(height))
    return gap
