"""Light apart by what it did at the first surface, for the layers ``KIND_LAYERS``.

Kinds are those of ``bsdf.kinds``. Light is direct when the first surface is the only one
that scattered it, as in Cycles; caustics are indirect. The light's kernels know nothing of
this: each step of a camera's path or of a branch of it, and each gather ray adds to a row of
its own, and what comes together there has one history. Only where several kinds of a first
surface share a sample is the BSDF asked once more.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import is_twosided
from ..bsdf.kinds import GLOSSY_KIND, TRANSMITTED_KIND, eval_kinds, one_kind
from ..film.layers import KIND_LAYERS, LIGHT_LAYERS
from ..geometry.vector import Vector, dot, scale, vector
from ..jit import Row, Table, kernel
from ..lights.dispatch import FAR
from ..photons.cells import row_of
from ..photons.coverage import look_around
from ..photons.gather import disc_weight, facing, to_photon
from ..photons.photon_map import PhotonMap
from ..photons.rows import largest_radius, photons_near, rows_near
from ..photons.sight import SECTORS, SIGHT, is_hidden
from ..scene.tables import Visibility
from .caustics import disc_radius

if TYPE_CHECKING:
    from ..photons.coverage import BorderGrid
    from .rays import Lit

_KINDS = len(KIND_LAYERS) // 2
_UNKNOWN = -1


class KindLight:
    """The light of one chunk's ``samples`` (n,) by kind: ``out`` (n, 6, 3).

    Branches of split paths have more rows in both while they are under way.
    """

    def __init__(self, samples: NDArray[np.void]) -> None:
        self._pixels = count = len(samples)
        self.samples = samples
        self.out = np.zeros((count, 2 * _KINDS, 3))
        #: Pixel that each row belongs to.
        self.pixel = np.arange(count)
        #: What the camera's paths have done so far, and what they have seen.
        self._kind = np.full(count, _UNKNOWN, np.int32)
        self._depth = np.zeros(count, np.int32)
        self._under_way = np.zeros(0, np.int32)
        self._emission = np.zeros((count, 3))
        self._direct = np.zeros((count, 3))

    def add_branches(self, paths: NDArray[np.void]) -> None:
        """Give ``paths``, which have just been split off, rows of their own."""
        if not len(paths):
            return
        parents = paths["slot"].copy()
        paths["slot"] = len(self.out) + np.arange(len(parents))
        self.samples = _longer(self.samples, len(parents))
        self.out = _longer(self.out, len(parents))
        self._emission = _longer(self._emission, len(parents))
        self._direct = _longer(self._direct, len(parents))
        self.pixel = np.concatenate([self.pixel, self.pixel[parents]])
        self._kind = np.concatenate([self._kind, self._kind[parents]])
        self._depth = np.concatenate([self._depth, self._depth[parents]])

    def begin(self, paths: NDArray[np.void]) -> None:
        """The camera's ``paths`` are about to make a step."""
        self._under_way = paths["slot"].copy()

    def end(self, paths: NDArray[np.void]) -> None:
        """Take over what the step has added to ``samples``; ``paths`` go on."""
        slots, samples = self._under_way, self.samples
        emission, direct = samples["emission"][slots], samples["direct"][slots]
        kind, depth = self._kind[slots], self._depth[slots]
        seen = kind != _UNKNOWN
        row = np.where(depth > 1, _KINDS, 0) + kind
        self.out[slots[seen], row[seen]] += emission[seen] + direct[seen]
        self._emission[slots] += emission
        self._direct[slots] += direct
        samples["emission"][slots] = 0.0
        samples["direct"][slots] = 0.0
        on = paths["slot"]
        self._depth[on] = paths["depth"]
        first = on[(self._kind[on] == _UNKNOWN) & (paths["depth"] > 0)]
        turned = paths["event"][(self._kind[on] == _UNKNOWN) & (paths["depth"] > 0)]
        through = turned == int(Visibility.TRANSMISSION)
        self._kind[first] = np.where(through, TRANSMITTED_KIND, GLOSSY_KIND)

    def end_camera(self) -> None:
        """The camera's paths have ended: their samples get back what they have seen."""
        self.samples["emission"] += self._emission
        self.samples["direct"] += self._direct

    def add(
        self,
        lit: Lit,
        asking: NDArray[np.int32],
        directions: NDArray[np.float64],
        light: NDArray[np.float64],
        indirect: bool,
    ) -> None:
        """Add ``light`` (n, 3) that comes to vertices ``asking`` from unit ``directions``.

        ``indirect``: whether it has met a surface before.
        """
        vertices, lobes = lit
        add_by_kind(lobes, vertices, asking, directions, light, self._kind, indirect, self.out)

    def add_photons(
        self,
        lit: Lit,
        camera: Row,
        photon_map: PhotonMap,
        borders: BorderGrid,
        radii: tuple[float, float, float],
        light: NDArray[np.float64],
    ) -> None:
        """Share out ``light`` (n, 3) of the samples, gathered from photons at ``lit`` alone."""
        split_photons(
            lit.lobes, camera, photon_map, borders, radii, lit.vertices, self._kind,
            np.ascontiguousarray(light), np.zeros(SIGHT), self.out,
        )  # fmt: skip

    def finished(self) -> tuple[NDArray[np.void], NDArray[np.float64]]:
        """``samples`` and ``out`` of the pixels, black where the film will be."""
        count = self._pixels
        samples, out = self.samples[:count], self.out[:count]
        pixel = self.pixel[count:]
        add_rows(samples, pixel, self.samples[count:], (*LIGHT_LAYERS, "albedo", "shrink"))
        np.add.at(out, pixel, self.out[count:])
        numbers = samples.view(np.float64).reshape(count, -1)
        whole = np.isfinite(numbers).all(axis=1) & np.isfinite(out).all(axis=(1, 2))
        out[~whole] = 0.0
        return samples, out


def _longer(table: NDArray[Any], more: int) -> NDArray[Any]:
    """``table`` with ``more`` rows of zeros behind it."""
    return np.concatenate([table, np.zeros((more, *table.shape[1:]), table.dtype)])


def add_rows(
    samples: NDArray[np.void],
    slots: NDArray[Any],
    rows: NDArray[np.void],
    layers: Sequence[str],
) -> None:
    """Add ``layers`` of ``rows`` to the ``samples`` in ``slots``."""
    for name in layers:
        for c in range(3):
            light = np.ascontiguousarray(rows[name][:, c])
            samples[name][:, c] += np.bincount(slots, light, len(samples))


def directions_to_lights(
    lit: Lit,
    asking: NDArray[np.int32],
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    lengths: NDArray[np.float32],
) -> NDArray[np.float64]:
    """Unit directions (n, 3) from vertices to lights, given shadow rays from beside them."""
    found = directions.astype(np.float64)
    near = lengths < FAR
    start = lit.vertices["p"][asking[near]]
    found[near] += origins[near] - start
    return np.ascontiguousarray(found / np.linalg.norm(found, axis=1, keepdims=True))


@kernel
def _share_out(
    kinds: tuple[Vector, Vector, Vector], light: Row, first: int, fallback: int, out: Row
) -> None:
    """Add ``light`` (3,) to three rows of ``out`` in proportion to ``kinds``."""
    diffuse, glossy, transmitted = kinds
    for c in range(3):
        total = diffuse[c] + glossy[c] + transmitted[c]
        if total > 0.0:
            unit = light[c] / total
            out[first, c] += diffuse[c] * unit
            out[first + 1, c] += glossy[c] * unit
            out[first + 2, c] += transmitted[c] * unit
        else:
            out[first + fallback, c] += light[c]


@kernel
def add_by_kind(
    lobes: Table,
    vertices: Table,
    asking: Table,
    directions: Table,
    light: Table,
    chain: Table,
    indirect: bool,
    out: Table,
) -> None:
    """See ``KindLight.add``. ``chain``: kinds of the paths that are past a first surface."""
    for j in range(len(asking)):
        vertex = vertices[asking[j]]
        target = out[vertex.slot]
        kind = chain[vertex.slot]
        if vertex.depth > 1:
            for c in range(3):
                target[_KINDS + kind, c] += light[j, c]
            continue
        wi = vector(directions[j])
        ns = vector(vertex.ns)
        kinds = eval_kinds(vertex, lobes, ns, vector(vertex.wo), wi, vertex.part)
        fallback = TRANSMITTED_KIND if dot(ns, wi) < 0.0 else GLOSSY_KIND
        _share_out(kinds, light[j], _KINDS if indirect else 0, fallback, target)


@kernel
def split_photons(
    lobes: Table,
    camera: Row,
    photon_map: Row,
    borders: Row,
    radii: Table,
    vertices: Table,
    chain: Table,
    gathered: Table,
    sight: Table,
    out: Table,
) -> None:
    """See ``KindLight.add_photons``: photons are gathered again where kinds are mixed."""
    for k in range(len(vertices)):
        vertex = vertices[k]
        light = gathered[vertex.slot]
        target = out[vertex.slot]
        if max(light[0], max(light[1], light[2])) == 0.0:
            continue
        kind = chain[vertex.slot]
        if vertex.depth == 1:
            kind = one_kind(vertex, lobes)
        if kind >= 0:
            for c in range(3):
                target[_KINDS + kind, c] += light[c]
            continue
        radius = disc_radius(camera, radii, vertex.length)
        p, ng = vector(vertex.p), vector(vertex.ng)
        look_around(borders, p, ng, vertex.entering != 0, radius, sight)
        kinds = _gather_kinds(photon_map, vertex, lobes, radius, sight)
        _share_out(kinds, light, _KINDS, GLOSSY_KIND, target)


@kernel
def _gather_kinds(
    photon_map: Row, vertex: Row, lobes: Table, radius: float, sight: Table
) -> tuple[Vector, Vector, Vector]:
    """As ``gather_radiance``, by kinds and up to a common factor."""
    p, ng = vector(vertex.p), vector(vertex.ng)
    ns, wo = vector(vertex.ns), vector(vertex.wo)
    both = is_twosided(vertex, lobes)
    diffuse = glossy = transmitted = (0.0, 0.0, 0.0)
    radius = min(radius, largest_radius(photon_map.cell))
    parted = sight[SECTORS] != 0.0
    inverse = 1.0 / (radius * radius)
    rows = rows_near(photon_map.cell, p, ng, radius)
    for j in range(rows[3]):
        first, last, row = photons_near(photon_map, rows, j, p, ng, radius)
        for k in range(first, last):
            weight = disc_weight(photon_map.places, k, p, ng, radius, inverse)
            if weight <= 0.0 or row_of(photon_map.keys[k]) != row:
                continue
            photon = photon_map.photons[k]
            cosine = facing(photon, ng, both)
            if cosine == 0.0 or (parted and is_hidden(sight, to_photon(photon, p), ng, radius)):
                continue
            wi = vector(photon.direction)
            d, g, t = eval_kinds(vertex, lobes, ns, wo, wi, photon.part)
            flux = scale(vector(photon.flux), weight * cosine)
            diffuse = _plus(diffuse, d, flux)
            glossy = _plus(glossy, g, flux)
            transmitted = _plus(transmitted, t, flux)
    return diffuse, glossy, transmitted


@kernel
def _plus(total: Vector, f: Vector, flux: Vector) -> Vector:
    return (
        total[0] + f[0] * flux[0],
        total[1] + f[1] * flux[1],
        total[2] + f[2] * flux[2],
    )
