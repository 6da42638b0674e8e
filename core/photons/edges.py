"""Where surfaces end or fold: a disc that reaches over such an edge finds too few photons.

A density estimate divides by the area of its disc. Beyond the edge of a table, the corner of
a room or the foot of a wall there is no surface that could hold photons of this one, and the
estimate is too dark, by up to a half at the edge itself (Jensen 2001, section 7.2 calls it
boundary bias). Discs that end at the nearest edge have no such bias.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.mesh import Mesh
from ..geometry.vector import Vector, along, dot, read, subtract
from ..jit import Row, Table, kernel
from .cells import bucket_of, cell_key

#: Faces that meet at a fold sharper than this cosine (45 degrees) make an edge.
SMOOTH_COSINE = 0.7
#: No disc gets smaller than these parts of the radius: right beside an edge it would be
#: empty. What gather rays meet is averaged over many of them, a caustic is looked at.
LEAST_PART = 0.1
LEAST_PART_SEEN = 0.3
#: Most entries of the grid (20 bytes each); scenes with more edges do without.
MOST_ENTRIES = 4_000_000


class EdgeGrid(NamedTuple):
    """Edges in the cells of a hashed grid.

    segments (E, 2, 3) f8; for each entry its cell ``keys`` (P,) i8 and ``edge`` (P,) i4;
    ``start`` (B+1,) i4 of the buckets; ``cell`` [m].
    """

    segments: NDArray[np.float64]
    keys: NDArray[np.int64]
    edge: NDArray[np.int32]
    start: NDArray[np.int32]
    cell: float


def sharp_edges(mesh: Mesh) -> NDArray[np.float64]:
    """Edges (E, 2, 3) at which a surface ends, folds, or more than two faces meet."""
    if len(mesh.faces) == 0:
        return np.zeros((0, 2, 3))
    # Faces of different objects, or flat ones, may have corners of their own at one place.
    _, place = np.unique(mesh.vertices, axis=0, return_inverse=True)
    corner = place.reshape(-1)[mesh.faces]
    points = mesh.vertices[mesh.faces].astype(np.float64)
    normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    ends = np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]])
    face = np.tile(np.arange(len(mesh.faces)), 3)
    side = np.repeat(np.arange(3), len(mesh.faces))
    pair = np.sort(ends, axis=1).astype(np.int64)
    code = pair[:, 0] * (corner.max() + 1) + pair[:, 1]
    order = np.argsort(code, kind="stable")
    code, face, side = code[order], face[order], side[order]
    inward = _inward(points, normal)[side, face]
    _, first, count = np.unique(code, return_index=True, return_counts=True)
    sharp = np.ones(len(first), np.bool_)
    for c in np.unique(count[count > 1]):
        # All edges at which c faces meet: each face needs one that goes on where it ends.
        here = np.flatnonzero(count == c)
        ways = inward[first[here][:, None] + np.arange(c)]
        cosines = np.einsum("nik,njk->nij", ways, ways)
        sharp[here] = (cosines.min(axis=2) > -SMOOTH_COSINE).any(axis=1)
    f, s = face[first[sharp]], side[first[sharp]]
    segments: NDArray[np.float64] = np.stack([points[f, s], points[f, (s + 1) % 3]], axis=1)
    return segments


def _inward(points: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors (3, F, 3) in each face's plane, from each of its sides inwards."""
    along_side = points[:, [1, 2, 0]] - points
    ways = np.cross(normal[:, None], along_side)
    ways /= np.maximum(np.linalg.norm(ways, axis=2, keepdims=True), 1e-300)
    return np.ascontiguousarray(ways.transpose(1, 0, 2))


def edge_grid(segments: NDArray[np.float64], radius: float) -> EdgeGrid:
    """Put each edge into all cells that have a point within ``radius`` of it."""
    cell = 2.0 * radius
    length = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
    steps = np.ceil(length / radius).astype(np.int64) + 1
    if 8 * steps.sum() > MOST_ENTRIES:
        segments, steps = segments[:0], steps[:0]
    edge = np.repeat(np.arange(len(segments)), steps)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(steps) - steps, steps)
    t = step / np.maximum(np.repeat(steps, steps) - 1, 1)
    at = segments[edge, 0] * (1 - t[:, None]) + segments[edge, 1] * t[:, None]
    # Between two steps the edge is half a radius away from the nearer one.
    low = np.floor((at - 1.5 * radius) / cell).astype(np.int64)
    high = np.floor((at + 1.5 * radius) / cell).astype(np.int64)
    cells, owners = [], []
    for dx, dy, dz in np.ndindex(3, 3, 3):
        place = low + (dx, dy, dz)
        inside = (place <= high).all(axis=1)
        cells.append(place[inside])
        owners.append(edge[inside])
    every = np.concatenate([np.concatenate(cells), np.concatenate(owners)[:, None]], axis=1)
    every = np.unique(every, axis=0)
    keys = np.zeros(len(every), np.int64)
    bucket = np.zeros(len(every), np.int32)
    buckets = 1 << max(4, math.ceil(math.log2(max(1, len(every)))))
    find_buckets(np.ascontiguousarray(every[:, :3]), buckets, keys, bucket)
    order = np.argsort(bucket, kind="stable")
    start = np.zeros(buckets + 1, np.int32)
    start[1:] = np.cumsum(np.bincount(bucket, minlength=buckets))
    own = every[order, 3].astype(np.int32)
    return EdgeGrid(segments, keys[order], own, start, cell)


@kernel
def find_buckets(cells: Table, buckets: int, keys: Table, bucket: Table) -> None:
    """Key and bucket of each of ``cells`` (P, 3) i8."""
    for k in range(len(cells)):
        keys[k] = cell_key(cells[k, 0], cells[k, 1], cells[k, 2])
        bucket[k] = bucket_of(keys[k], buckets)


@kernel
def fitting_radius(edges: Row, p: Vector, radius: float, least_part: float) -> float:
    """``radius``, or the distance from ``p`` to the nearest edge when that is smaller.

    It is at least ``least_part`` of ``radius``.
    """
    key = cell_key(
        int(math.floor(p[0] / edges.cell)),
        int(math.floor(p[1] / edges.cell)),
        int(math.floor(p[2] / edges.cell)),
    )
    bucket = bucket_of(key, len(edges.start) - 1)
    nearest = radius * radius
    for k in range(edges.start[bucket], edges.start[bucket + 1]):
        if edges.keys[k] != key:
            continue
        segment = edges.segments[edges.edge[k]]
        a = read(segment, 0)
        along_edge = subtract(read(segment, 1), a)
        way = subtract(p, a)
        square = dot(along_edge, along_edge)
        t = dot(way, along_edge) / square if square > 0.0 else 0.0
        gap = subtract(way, along((0.0, 0.0, 0.0), along_edge, min(1.0, max(0.0, t))))
        nearest = min(nearest, dot(gap, gap))
    return max(math.sqrt(nearest), least_part * radius)
