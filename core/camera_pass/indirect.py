"""Indirect light: final-gather rays, and the global photon map where it ends."""

from __future__ import annotations

import numpy as np

from ..bsdf.dispatch import eval_nonspecular, pdf_nonspecular, sample_nonspecular
from ..geometry.interaction import leave
from ..geometry.media import copy_media
from ..geometry.vector import dot, store, vector
from ..jit import Row, Table, kernel
from ..photons.gather import gather_radiance
from ..sampling.rng import camera_2d, mix, uniform
from ..scene.tables import Visibility
from .paths import add
from .records import GATHER, GATHER_LOBE, GATHER_STEP

_DIFFUSE_BIT = int(Visibility.DIFFUSE)


@kernel
def start_gather(
    i: int,
    rays_each: int,
    materials: Table,
    lobes: Table,
    vertices: Table,
    count: int,
    origins: Table,
    directions: Table,
    paths: Table,
) -> int:
    """``rays_each`` rays from each vertex, drawn from its BSDF; returns how many there are.

    A path's ``pdf_w`` is the density of all of a vertex's rays together.
    """
    out = 0
    for k in range(count):
        vertex = vertices[k]
        ns = vector(vertex.ns)
        ng = vector(vertex.ng)
        wo = vector(vertex.wo)
        material = materials[vertex.row]
        for j in range(rays_each):
            u, v = camera_2d(i, vertex.pixel_key, GATHER, j, rays_each)
            u_lobe = uniform(vertex.key, GATHER_LOBE + GATHER_STEP * j)
            wi = sample_nonspecular(material, lobes, ns, wo, u_lobe, u, v)
            pdf_w = pdf_nonspecular(material, lobes, ns, wo, wi)
            if not pdf_w > 0.0 or dot(wi, ng) <= 0.0:
                continue
            f = eval_nonspecular(material, lobes, ns, wo, wi)
            weight = dot(wi, ns) / (pdf_w * rays_each)
            path = paths[out]
            path.key = mix(vertex.key + np.uint64(j))
            path.pixel_key = vertex.pixel_key
            path.slot = vertex.slot
            path.depth = vertex.depth
            path.event = _DIFFUSE_BIT
            path.length = vertex.length
            path.pdf_w = pdf_w * rays_each
            path.beta[0] = vertex.beta[0] * f[0] * weight
            path.beta[1] = vertex.beta[1] * f[1] * weight
            path.beta[2] = vertex.beta[2] * f[2] * weight
            store(path.direction, wi)
            store(path.origin, vector(vertex.p))
            store(path.normal, ns)
            copy_media(path, vertex)
            store(origins[out], leave(vector(vertex.p), ng, wi, vertex.offset))
            store(directions[out], wi)
            out += 1
    return out


@kernel
def gather_indirect(
    materials: Table,
    lobes: Table,
    photon_map: Row,
    radius: float,
    vertices: Table,
    count: int,
    samples: Table,
) -> None:
    """Add the indirect layer: ``vertices`` are where the gather rays ended."""
    for k in range(count):
        vertex = vertices[k]
        radiance, _ = gather_radiance(
            photon_map, vector(vertex.p), vector(vertex.ng), vector(vertex.ns),
            vector(vertex.wo), radius, materials[vertex.row], lobes,
        )  # fmt: skip
        add(samples[vertex.slot].indirect, vertex.beta, radiance, 1.0)
