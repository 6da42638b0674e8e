"""Indirect light: one final-gather ray, and the global photon map where it ends."""

from __future__ import annotations

from ..bsdf.dispatch import eval_nonspecular, pdf_nonspecular, sample_nonspecular
from ..geometry.interaction import leave
from ..geometry.media import copy_media
from ..geometry.vector import dot, store, vector
from ..jit import kernel
from ..photons.gather import gather_radiance
from ..sampling.rng import uniform
from ..scene.tables import Visibility
from .paths import add
from .records import GATHER, GATHER_LOBE

_DIFFUSE_BIT = int(Visibility.DIFFUSE)


@kernel
def start_gather(
    materials, lobes, vertices, count, origins, directions, paths
) -> int:
    """One ray from each vertex, drawn from its BSDF; returns how many there are."""
    out = 0
    for k in range(count):
        vertex = vertices[k]
        ns = vector(vertex.ns)
        ng = vector(vertex.ng)
        wo = vector(vertex.wo)
        material = materials[vertex.row]
        wi = sample_nonspecular(
            material, lobes, ns, wo, uniform(vertex.key, GATHER_LOBE),
            uniform(vertex.key, GATHER), uniform(vertex.key, GATHER + 1),
        )  # fmt: skip
        pdf_w = pdf_nonspecular(material, lobes, ns, wo, wi)
        if not pdf_w > 0.0 or dot(wi, ng) <= 0.0:
            continue
        f = eval_nonspecular(material, lobes, ns, wo, wi)
        weight = dot(wi, ns) / pdf_w
        path = paths[out]
        path.key = vertex.key
        path.slot = vertex.slot
        path.depth = vertex.depth
        path.event = _DIFFUSE_BIT
        path.length = vertex.length
        path.pdf_w = pdf_w
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
    materials, lobes, photon_map, radius, vertices, count, samples
) -> None:
    """Add the indirect layer: ``vertices`` are where the gather rays ended."""
    for k in range(count):
        vertex = vertices[k]
        radiance, _ = gather_radiance(
            photon_map, vector(vertex.p), vector(vertex.ng), vector(vertex.ns),
            vector(vertex.wo), radius, materials[vertex.row], lobes,
        )  # fmt: skip
        add(samples[vertex.slot].indirect, vertex.beta, radiance, 1.0)
