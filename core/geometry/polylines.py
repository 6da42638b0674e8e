"""Polylines: pieces of borders that hang together in nearly one line are made one.

A pillar of 512 flat sides meets the floor in 512 lines, each a hundredth of a disc long. As
many are looked at for each disc near by, or, when they are too many, none is, and light
leaks below the pillar; some thirty chords tell a disc the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .borders import Borders
from .triangles import Floats

#: A third of the ends between two pieces is given up each time, about.
_ROUNDS = 32
#: Pieces of one line lie in one plane, to this cosine.
_ONE_PLANE = 0.9999
#: Ends are one when they agree to this part of the scene.
_SAME = 1e-5


@dataclass
class _Pieces:
    """Lines between ``nodes`` (N, 2).

    ``stray`` (N,): how far at most what they stand for is from them [m]; ``origin`` (N,): the
    piece that each was at first.
    """

    nodes: NDArray[np.intp]
    stray: Floats
    origin: NDArray[np.intp]


def straightened(whole: Borders, tolerance: float) -> Borders:
    """``whole`` with fewer pieces, which are within ``tolerance`` [m] of what they stand for.

    They keep the normal, gap and parts that all of theirs share.
    """
    count = len(whole.ends)
    if count < 2:
        return whole
    points = whole.ends.reshape(-1, 3)
    step = _SAME * float(np.abs(points).max())
    place = np.floor(points / max(step, 1e-300) + 0.5).astype(np.int64)
    first, nodes = np.unique(place, axis=0, return_index=True, return_inverse=True)[1:]
    pieces = _Pieces(nodes.reshape(-1, 2), np.zeros(count), np.arange(count))
    at = points[first]
    for _ in range(_ROUNDS):
        before = len(pieces.nodes)
        pieces = _halved(pieces, at, whole, tolerance)
        if len(pieces.nodes) == before:
            break
    kept = pieces.origin
    return Borders(at[pieces.nodes], whole.normal[kept], whole.gap[kept], whole.parts[kept])


def _halved(pieces: _Pieces, at: Floats, whole: Borders, tolerance: float) -> _Pieces:
    """Give up some of the nodes between two pieces, none of them neighbours."""
    nodes = pieces.nodes
    count = np.bincount(nodes.ravel(), minlength=len(at))
    order = np.argsort(nodes.ravel(), kind="stable")
    start = np.cumsum(count) - count
    middle = np.flatnonzero(count == 2)
    side = order[start[middle][:, None] + [0, 1]]
    a, b = side[:, 0] // 2, side[:, 1] // 2
    # The other ends.
    u, v = (nodes.ravel()[side[:, k] ^ 1] for k in range(2))
    chord = at[v] - at[u]
    length = np.linalg.norm(chord, axis=1)
    way = np.cross(at[middle] - at[u], chord)
    far = np.linalg.norm(way, axis=1) / np.maximum(length, 1e-300)
    stray = far + np.maximum(pieces.stray[a], pieces.stray[b])
    along = ((at[middle] - at[u]) * chord).sum(axis=1)
    first, second = pieces.origin[a], pieces.origin[b]
    one = (
        (a != b)
        & (stray <= tolerance)
        & (along > 0)
        & (along < length * length)
        & ((whole.normal[first] * whole.normal[second]).sum(axis=1) > _ONE_PLANE)
        & (whole.gap[first] == whole.gap[second])
        & (whole.parts[first] == whole.parts[second])
    )
    # Each piece goes to one of its ends at most: by lot, which is the same every time.
    rank = np.full(len(at), np.inf)
    lot = np.random.default_rng(0).permutation(len(at))
    chosen = middle[one]
    rank[chosen] = lot[chosen]
    best = np.full(len(nodes), np.inf)
    for piece in (a[one], b[one]):
        np.minimum.at(best, piece, rank[chosen])
    wins = (best[a[one]] == rank[chosen]) & (best[b[one]] == rank[chosen])
    a, b, u, v, stray = (x[one][wins] for x in (a, b, u, v, stray))
    new, strays, kept = nodes.copy(), pieces.stray.copy(), np.ones(len(nodes), np.bool_)
    new[a] = np.stack([u, v], axis=1)
    strays[a] = stray
    kept[b] = False
    return _Pieces(new[kept], strays[kept], pieces.origin[kept])
