"""Photons walk through the scene and are stored where surfaces scatter widely."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import (
    eval_nonspecular,
    pdf_nonspecular,
    sample_nonspecular,
)
from ..bsdf.dispatch import whole_weights as lobe_weights
from ..bsdf.specular import scatter_specular
from ..geometry.interaction import interact, leave
from ..geometry.media import cross_surface
from ..geometry.vector import Vector, dot, read, scale, store, vector
from ..jit import Row, Table, kernel
from ..lights.emission import reaches
from ..sampling.rng import uniform
from ..scene.tables import Visibility
from ..settings import Settings
from .emit import FIRST_BOUNCE, PHOTON_PATH, emit_photons

if TYPE_CHECKING:
    from ..prepared import Prepared

#: One stored photon: ``direction`` points back to where it came from, ``normal`` is the
#: surface's geometric normal on that side, ``flux`` [W] per channel.
PHOTON = np.dtype(
    [("position", "f4", 3), ("direction", "f4", 3), ("flux", "f4", 3), ("normal", "f4", 3)]
)

_DIFFUSE_BIT = int(Visibility.DIFFUSE)
_GLOSSY_BIT = int(Visibility.GLOSSY)
_TRANSMISSION_BIT = int(Visibility.TRANSMISSION)
_DIMENSIONS = 8  # random numbers a bounce may use
#: Bound on the cosine ratio of shading and geometric normal. Towards grazing it has no
#: bound and infinite variance; it is above 8 only for light within 1/8 rad of grazing.
_MOST_CORRECTION = 8.0


class Walk(NamedTuple):
    """What a batch of photon paths left: stored photons, their order, rays traced."""

    photons: NDArray[np.void]
    order: NDArray[np.int64]
    rays: int


def trace_photons(
    prepared: Prepared,
    spheres: Table,
    light_cdf: Table,
    aimed: bool,
    settings: Settings,
    purpose: int,
    i: int,
    start: int,
    count: int,
    total: int,
) -> Walk:
    """Emit and trace photon paths ``start``..``start + count`` of ``total`` in pass ``i``.

    Returns a ``Walk``; its ``order`` grows with path and depth, so that batches can be
    put in one order whatever their size was.
    """
    origins = np.zeros((count, 3), np.float32)
    directions = np.zeros((count, 3), np.float32)
    paths = np.zeros(count, PHOTON_PATH)
    alive = emit_photons(
        prepared.mesh, prepared.materials, prepared.lights, prepared.light_media, spheres,
        light_cdf, aimed, settings.seed, purpose, i, start, count, total, origins,
        directions, paths,
    )  # fmt: skip
    stored: list[NDArray[np.void]] = []
    orders: list[NDArray[np.int64]] = []
    rays = 0
    for _ in range(settings.photon_depth):
        if alive == 0:
            break
        rays += alive
        hits = prepared.intersector.nearest(origins[:alive], directions[:alive])
        photons = np.zeros(alive, PHOTON)
        order = np.zeros(alive, np.int64)
        alive, kept = step_photons(
            prepared.mesh, prepared.materials, prepared.lobes, prepared.lights, aimed,
            settings.photon_depth,
            hits.face, hits.u, hits.v, alive, origins, directions, paths, photons, order,
        )  # fmt: skip
        stored.append(photons[:kept])
        orders.append(order[:kept])
    if not stored:
        return Walk(np.zeros(0, PHOTON), np.zeros(0, np.int64), rays)
    return Walk(np.concatenate(stored), np.concatenate(orders), rays)


@kernel
def _is_seen(path: Row, bit: int) -> bool:
    """Whether the light of a path may light this kind of first surface."""
    return path.depth > 0 or (path.visibility & bit) != 0


@kernel
def _store(photon: Row, p: Vector, wo: Vector, ng: Vector, flux: Vector, ratio: float) -> None:
    store(photon.position, p)
    store(photon.direction, wo)
    store(photon.normal, ng)
    store(photon.flux, scale(flux, ratio))


@kernel
def _scatter_diffuse(
    material: Row, lobes: Table, ng: Vector, ns: Vector, wo: Vector, key: np.uint64, base: int
) -> Any:
    """Draw a direction from the non-specular lobes: (wi, weight (3,))."""
    wi = sample_nonspecular(
        material, lobes, ns, wo, uniform(key, base + 2), uniform(key, base + 3),
        uniform(key, base + 4),
    )  # fmt: skip
    pdf_w = pdf_nonspecular(material, lobes, ns, wo, wi)
    if pdf_w <= 0.0 or dot(wi, ng) <= 0.0:
        return wi, (0.0, 0.0, 0.0)
    f = eval_nonspecular(material, lobes, ns, wo, wi)
    # Adjoint of the shading normal: the outgoing cosine is the geometric one (Veach 1997,
    # section 5.3); the incoming ratio is applied by the caller.
    return wi, scale(f, dot(wi, ng) / pdf_w)


@kernel
def _survive(path: Row, flux: Vector, weight: Vector, ratio: float, base: int) -> bool:
    """Russian roulette that keeps the flux of the survivors about what it was."""
    new = (
        flux[0] * weight[0] * ratio,
        flux[1] * weight[1] * ratio,
        flux[2] * weight[2] * ratio,
    )
    most = max(new)
    if not most > 0.0:
        return False
    survival = min(1.0, most / max(flux))
    if uniform(path.key, base + 1) >= survival:
        return False
    store(path.flux, scale(new, 1.0 / survival))
    return True


@kernel
def step_photons(
    mesh: Row,
    materials: Table,
    lobes: Table,
    lights: Row,
    caustic: bool,
    most_depth: int,
    hit_face: Table,
    hit_u: Table,
    hit_v: Table,
    count: int,
    origins: Table,
    directions: Table,
    paths: Table,
    photons: Table,
    order: Table,
) -> Any:
    """One surface for each photon: store, scatter, compact: (still alive, stored).

    ``caustic`` photons live on specular surfaces alone and are stored only after one.
    """
    alive = 0
    kept = 0
    for k in range(count):
        if hit_face[k] < 0:
            continue
        path = paths[k]
        wo = scale(vector(path.direction), -1.0)
        p, ng, ns, entering, offset = interact(mesh, hit_face[k], hit_u[k], hit_v[k], wo)
        if path.depth == 0 and not reaches(lights, path.entry, read(origins, k), p):
            continue
        row = mesh.material[hit_face[k]]
        rough, smooth = lobe_weights(materials[row], lobes)
        base = FIRST_BOUNCE + _DIMENSIONS * path.depth
        cos_g = dot(wo, ng)
        ratio = min(_MOST_CORRECTION, dot(wo, ns) / cos_g) if cos_g > 0.0 else 0.0
        flux = vector(path.flux)
        if rough > 0.0 and ratio > 0.0 and _is_seen(path, _DIFFUSE_BIT):
            if not caustic or path.depth > 0:
                _store(photons[kept], p, wo, ng, flux, ratio)
                order[kept] = path.index * most_depth + path.depth
                kept += 1
        total = smooth if caustic else rough + smooth
        if total <= 0.0 or path.depth + 1 >= most_depth:
            continue
        if caustic or uniform(path.key, base) * total < smooth:
            wi, weight, transmitted, _ = scatter_specular(
                materials, lobes, path, row, ng, ns, entering, wo,
                uniform(path.key, base + 2), uniform(path.key, base + 3),
            )  # fmt: skip
            if not _is_seen(path, _TRANSMISSION_BIT if transmitted else _GLOSSY_BIT):
                continue
            cos_s = abs(dot(wi, ns))
            ratio *= min(_MOST_CORRECTION, abs(dot(wi, ng)) / cos_s) if cos_s > 0.0 else 0.0
            ratio *= total / smooth
            if transmitted:
                cross_surface(path, row, entering)
        else:
            if not _is_seen(path, _DIFFUSE_BIT):
                continue
            wi, weight = _scatter_diffuse(materials[row], lobes, ng, ns, wo, path.key, base)
            ratio *= total / rough
            path.specular = 0
        if not _survive(path, flux, weight, ratio, base):
            continue
        path.depth += 1
        store(path.direction, wi)
        origin = leave(p, ng, wi, offset)
        if alive != k:
            paths[alive] = paths[k]
        store(origins[alive], origin)
        store(directions[alive], wi)
        alive += 1
    return alive, kept
