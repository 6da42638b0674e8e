"""Photons sorted into the cells of a hashed grid, so that neighbours lie together."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..jit import Table, kernel
from .cells import bucket_of, cell_key
from .rows import REPEATED
from .trace import PHOTON, Walk

#: Photons that stand twice, as a guess of their most: those of 14 cells.
_TWICE = 4096


class PhotonMap(NamedTuple):
    """One pass's photons of one kind.

    photons (N,) ``PHOTON`` in bucket order; places (N, 3) f4 their positions once more, for
    the search; keys (N,) i8 the cell of each; start (B + R + 1,) i4 first photon of each of B
    = ``buckets`` (a power of two) and of the first R = ``REPEATED``, which with their photons
    stand a second time behind the last; cell: edge [m].
    """

    photons: NDArray[np.void]
    places: NDArray[np.float32]
    keys: NDArray[np.int64]
    start: NDArray[np.int32]
    buckets: int
    cell: float


class Crowd(NamedTuple):
    """Where caustic photons are dense: those of a pass of their own.

    ``factor``: photons that a pass emits for each of them; ``radii``: of the first pass's
    discs, (pixels per footprint, least, most).
    """

    photons: PhotonMap
    factor: float
    radii: tuple[float, float, float]


def build_photon_map(walks: list[Walk], cell: float) -> PhotonMap:
    """Sort the photons of ``walks`` into cells of edge ``cell``.

    They are first put into the order of their paths, so that the sums of a query come
    out the same bit for bit whatever batches they were traced in.
    """
    photons = np.concatenate([w.photons for w in walks]) if walks else np.zeros(0, PHOTON)
    order = np.concatenate([w.order for w in walks]) if walks else np.zeros(0, np.int64)
    buckets = _buckets_for(len(photons))
    first = np.argsort(order, kind="stable")
    start = np.zeros(buckets + 1, np.int32)
    bucket = np.zeros(len(photons), np.int32)
    own = np.zeros(len(photons), np.int64)
    find_cells(photons, first, cell, own, bucket, start)
    again = int(start[REPEATED])
    sorted_photons = np.zeros(len(photons) + again, PHOTON)
    keys = np.zeros(len(sorted_photons), np.int64)
    place = start[:-1].copy()
    sort_into_cells(photons, first, own, bucket, place, sorted_photons, keys)
    for column in (sorted_photons, keys):
        column[len(photons) :] = column[:again]
    start = np.concatenate([start, start[-1] + start[1 : REPEATED + 1]])
    places = np.ascontiguousarray(sorted_photons["position"])
    return PhotonMap(sorted_photons, places, keys, start, buckets, cell)


def bytes_of_map(count: int) -> int:
    """Memory of a map of ``count`` photons, at most by the few that stand twice."""
    rows = count + min(count, _TWICE)
    row = PHOTON.itemsize + 3 * 4 + 8
    return rows * row + 4 * (_buckets_for(count) + REPEATED + 1)


def bytes_while_building(count: int) -> int:
    """Memory of the walks with ``count`` photons and of all that is made of them."""
    walks = count * (PHOTON.itemsize + 8)
    # The same in one piece, its order, bucket and cell of each; the table of buckets twice.
    columns = walks + count * (8 + 4 + 8) + 8 * (_buckets_for(count) + 1)
    return walks + columns + bytes_of_map(count)


def _buckets_for(count: int) -> int:
    """More buckets than photons: a disc's cells then share few with those of other rows."""
    return 4 << max(4, math.ceil(math.log2(max(1, count))))


@kernel
def find_cells(
    photons: Table, order: Table, cell: float, own: Table, bucket: Table, start: Table
) -> None:
    """Cell and bucket of each photon in ``order``, and where the buckets will start."""
    for j in range(len(photons)):
        p = photons[order[j]].position
        own[j] = cell_key(
            int(math.floor(p[0] / cell)),
            int(math.floor(p[1] / cell)),
            int(math.floor(p[2] / cell)),
        )
        bucket[j] = bucket_of(own[j], len(start) - 1)
        start[bucket[j] + 1] += 1
    for b in range(len(start) - 1):
        start[b + 1] += start[b]


@kernel
def sort_into_cells(
    photons: Table,
    order: Table,
    own: Table,
    bucket: Table,
    place: Table,
    sorted_photons: Table,
    keys: Table,
) -> None:
    """Counting sort by bucket, stable in ``order``; ``place`` ends as the buckets' ends."""
    for j in range(len(photons)):
        k = place[bucket[j]]
        place[bucket[j]] += 1
        sorted_photons[k] = photons[order[j]]
        keys[k] = own[j]
