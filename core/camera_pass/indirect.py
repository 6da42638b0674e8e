"""Indirect light: final-gather rays, and the global photon map where it ends."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import WIDE, draws_cosine, part_bit
from ..bsdf.scatter import scatter
from ..geometry.interaction import leave
from ..geometry.media import copy_media, cross_surface
from ..geometry.vector import store, vector
from ..jit import Row, Table, kernel
from ..photons.cells import bucket_of, cell_key
from ..photons.photon_map import PhotonMap
from ..sampling.rng import camera_2d, mix, uniform
from .direct import samples_at
from .guide import guided_ratio, guided_share, warp_square, zone_of
from .patches import add_shared
from .records import GATHER, GATHER_LOBE, GATHER_NUMBER, GATHER_STEP

#: Photons that a processor's cache holds beside the rest [bytes].
_LARGE = 4 << 20


@kernel
def start_gather(
    rays_each: int,
    lights_each: int,
    guide: Row,
    materials: Table,
    lobes: Table,
    vertices: Table,
    count: int,
    origins: Table,
    directions: Table,
    paths: Table,
) -> int:
    """``rays_each`` rays from each vertex, drawn from its BSDF; returns how many there are.

    Where ``guide`` knows the place, it draws for lobes that follow the cosine. A branch of a
    path that was split sends its portion of the rays, in the mean. A path's ``pdf_w`` is the
    density of all of a vertex's rays together, for each of the points of lights that are
    asked for there (``lights_each`` at a whole path's vertex).
    """
    out = 0
    for k in range(count):
        vertex = vertices[k]
        wanted = rays_each * vertex.portion
        sent = rays_each
        if vertex.portion < 1.0:
            sent = int(wanted + uniform(vertex.key, GATHER_NUMBER))
        ns = vector(vertex.ns)
        zone = zone_of(guide, vector(vertex.p), ns)
        guided = guided_share(zone, vertex, lobes)
        for j in range(sent):
            u, v = camera_2d(vertex.number, vertex.pixel_key, GATHER, j, rays_each)
            u_lobe = uniform(vertex.key, GATHER_LOBE + GATHER_STEP * j)
            ratio = 1.0
            if guided >= 1.0 or (guided > 0.0 and draws_cosine(vertex, lobes, WIDE, u_lobe)):
                u, v, ratio = warp_square(guide, zone, u, v)
            wi, weight, pdf_w, transmitted, eta = scatter(
                materials, lobes, vertex, vertex, WIDE, u_lobe, u, v
            )
            if not max(weight) > 0.0:
                continue
            if guided < 1.0:
                ratio = guided_ratio(guide, zone, guided, ns, wi, pdf_w)
            share = 1.0 / (wanted * ratio)
            path = paths[out]
            copy_media(path, vertex)
            if transmitted:
                share /= eta * eta
                if materials[vertex.row].ior > 0.0:
                    cross_surface(path, vertex.row, vertex.entering != 0)
            path.key = mix(vertex.key + np.uint64(j))
            path.pixel_key = vertex.pixel_key
            path.slot = vertex.slot
            path.number = vertex.number
            path.depth = vertex.depth
            path.steps = 0
            path.forced = 0
            path.portion = 1.0
            path.event = part_bit(vertex, lobes, WIDE, transmitted)
            path.length = path.begun = vertex.length
            path.since = 0.0
            path.pdf_w = pdf_w * ratio * wanted / samples_at(vertex, lights_each)
            path.beta[0] = vertex.beta[0] * weight[0] * share
            path.beta[1] = vertex.beta[1] * weight[1] * share
            path.beta[2] = vertex.beta[2] * weight[2] * share
            o = leave(vector(vertex.p), vector(vertex.ng), wi, vertex.offset)
            store(path.direction, wi)
            store(path.origin, o)
            store(path.normal, ns)
            store(origins[out], o)
            store(directions[out], wi)
            out += 1
    return out


def gather_order(
    photon_map: PhotonMap, vertices: NDArray[np.void], left_out: NDArray[np.bool_]
) -> NDArray[np.intp]:
    """The order to ask a photon map at ``vertices`` in: by its cells when it is large.

    Final-gather rays end everywhere, so each would fetch its photons from memory again.
    Vertices of one pixel keep the same order among themselves, however pixels are chunked.
    ``left_out`` (n,) tells those that are not asked for.
    """
    if photon_map.photons.nbytes < _LARGE:
        return np.flatnonzero(~left_out)
    bucket = np.empty(len(vertices), np.int32)
    find_vertex_buckets(photon_map.cell, photon_map.buckets, vertices, bucket)
    order = np.argsort(bucket, kind="stable")
    return order[~left_out[order]]


@kernel
def find_vertex_buckets(cell: float, buckets: int, vertices: Table, bucket: Table) -> None:
    """Bucket of the cell that each of ``vertices`` lies in."""
    for k in range(len(vertices)):
        p = vertices[k].p
        key = cell_key(
            int(math.floor(p[0] / cell)),
            int(math.floor(p[1] / cell)),
            int(math.floor(p[2] / cell)),
        )
        bucket[k] = bucket_of(key, buckets)


@kernel
def gather_indirect(
    lobes: Table,
    photon_map: Row,
    borders: Row,
    radius: float,
    vertices: Table,
    order: Table,
    samples: Table,
    sight: Table,
    patches: Table,
) -> None:
    """Add the indirect layer: ``vertices`` are where the gather rays ended.

    ``sight`` (SIGHT,) is overwritten; ``patches``: those known of this photon map.
    """
    for k in order:
        vertex = vertices[k]
        sample = samples[vertex.slot]
        add_shared(
            sample.indirect, sample, vertex, lobes, photon_map, borders, radius, sight, patches
        )  # fmt: skip
