"""Shadow photons: which places a lamp reaches, guessed from photons instead of shadow rays.

Jensen 1996, and section 3.4 of the report that this project comes from: a lamp's photons go
on straight through the scene and leave *shadow photons* behind the first surface. Where one
sort alone lies around a place the shadow ray is saved. The report decided by the bare share
of shadow photons; here a share has to be known well enough (Wilson's interval, Wilson 1927),
and photons of other surfaces, sides and lamps do not count.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.interaction import OFFSET
from ..geometry.vector import dot, vector
from ..jit import Row, Table, kernel
from ..sampling.rng import PHOTON_GLOBAL
from ..scene.tables import Visibility
from .cells import row_of
from .emit import PHOTON_PATH, emit_photons
from .gather import disc_weight, facing
from .photon_map import PhotonMap, build_photon_map
from .rows import CELL, largest_radius, photons_near, rows_near
from .trace import PHOTON, Walk

if TYPE_CHECKING:
    from ..prepared import Prepared
    from ..settings import Settings

#: Pass number of their random streams; no real pass and no pilot reaches it.
SHADOW_PASS = 2_000_000_001
#: Photons of one lamp that a disc has in the middle.
NEIGHBOURS = 128
#: Surfaces that a path goes through.
_MOST_STEPS = 64
#: Normal quantile of the intervals: 95 % on both sides together.
QUANTILE = 1.96

ASK, LIT, SHADOWED = range(3)


class ShadowMap(NamedTuple):
    """Direct and shadow photons of all lamps.

    In ``photons`` the field ``part`` is 2 * light entry + 1 behind the first surface, + 0 on
    it. ``radius`` [m] of the discs; ``lit``, ``dark``: shares of shadow photons below and
    above which a place counts as lit or shadowed; ``least`` photons to decide by.
    """

    photons: PhotonMap
    radius: float
    lit: float
    dark: float
    least: int


def shadow_map(prepared: Prepared, settings: Settings) -> ShadowMap:
    """Trace ``settings.shadow_photons`` straight paths from the lamps."""
    photons = _trace(prepared, settings, settings.shadow_photons)
    lamps = max(1, len(np.unique(photons["part"] // 2)))
    radius = _radius(photons["position"], lamps, prepared.centre.radius)
    walk = Walk(photons, np.arange(len(photons), dtype=np.int64), 0)
    return ShadowMap(
        build_photon_map([walk], CELL * radius), radius, settings.shadow_lit,
        settings.shadow_dark, settings.shadow_least,
    )  # fmt: skip


def _radius(places: NDArray[np.float32], lamps: int, size: float) -> float:
    """Median distance to so many photons that each lamp has its ``NEIGHBOURS``."""
    from scipy.spatial import cKDTree

    k = min(NEIGHBOURS * lamps, len(places))
    if k == 0:
        return 0.01 * size
    # A search for many neighbours takes as long as many searches.
    count = min(512, max(8, 2_000_000 // k))
    asked = places[:: max(1, len(places) // count)]
    distance, _ = cKDTree(places).query(asked, k=[k])
    return float(max(np.median(distance), 1e-6 * size))


def _trace(prepared: Prepared, settings: Settings, count: int) -> NDArray[np.void]:
    """Rows of ``PHOTON`` for every surface on straight ways from the lamps."""
    origins, directions = np.zeros((2, count, 3), np.float32)
    paths = np.zeros(count, PHOTON_PATH)
    alive = emit_photons(
        prepared.mesh, prepared.materials, prepared.shading, prepared.lights,
        prepared.light_media, prepared.aim.spheres, prepared.aim.histogram,
        prepared.lights.photon_cdf, False,
        settings.seed, PHOTON_GLOBAL, SHADOW_PASS, 0, count, count, origins, directions, paths,
    )  # fmt: skip
    entry = paths["entry"][:alive]
    lamps = prepared.lights.lamps
    # Only lamps: glowing surfaces and the world are many lights in one.
    known = entry < len(lamps)
    known[known] = lamps["shadow"][entry[known]] != 0
    rays = origins[:alive][known], directions[:alive][known]
    return _straight_on(prepared, *rays, entry[known])


def _straight_on(
    prepared: Prepared,
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    entry: NDArray[np.int32],
) -> NDArray[np.void]:
    """Photons where the rays meet surfaces; they end at one that lets a part through."""
    mesh = prepared.mesh
    dark = np.zeros(len(entry), np.int32)
    stored = [np.zeros(0, PHOTON)]
    for _ in range(_MOST_STEPS):
        if len(entry) == 0:
            break
        hits = prepared.intersector.nearest(origins, directions)
        met = hits.face >= 0
        face, directions, entry, dark = hits.face[met], directions[met], entry[met], dark[met]
        corners = mesh.vertices[mesh.faces[face]].astype(np.float64)
        u, v = hits.u[met, None].astype(np.float64), hits.v[met, None].astype(np.float64)
        place = (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normal /= np.where(length > 0, length, 1.0)
        normal[(normal * directions).sum(axis=1) > 0] *= -1.0
        rows = np.zeros(len(face), PHOTON)
        rows["position"], rows["normal"], rows["direction"] = place, normal, -directions
        rows["part"] = 2 * entry + dark
        blocks = (mesh.visible[face] & int(Visibility.SHADOW)) != 0
        clear = (prepared.materials["passes"][mesh.material[face]] == 0) | ~blocks
        # A surface that lets a part of the light through is neither: rays ask behind it.
        stored.append(rows[blocks])
        dark = np.where(blocks, 1, dark)[clear].astype(np.int32)
        offset = OFFSET * np.abs(corners).max(axis=(1, 2))[:, None]
        origins = (place - offset * normal).astype(np.float32)[clear]
        directions, entry = directions[clear], entry[clear]
    return np.concatenate(stored)


@kernel
def share_bounds(shadow: int, count: int) -> tuple[float, float]:
    """Wilson's interval of the share of shadow photons, at ``QUANTILE``."""
    z2 = QUANTILE * QUANTILE
    share = shadow / count
    middle = (share + 0.5 * z2 / count) / (1.0 + z2 / count)
    spread = share * (1.0 - share) / count + 0.25 * z2 / (count * count)
    half = QUANTILE * math.sqrt(spread) / (1.0 + z2 / count)
    return middle - half, middle + half


@kernel
def count_photons(shadows: Row, entry: int, p: Row, ng: Row) -> tuple[int, int]:
    """Direct and shadow photons of light ``entry`` in the disc about ``p``."""
    photon_map = shadows.photons
    radius = min(shadows.radius, largest_radius(photon_map.cell))
    inverse = 1.0 / (radius * radius)
    rows = rows_near(photon_map.cell, p, ng, radius)
    direct = 0
    shadow = 0
    for j in range(rows[3]):
        first, last, row = photons_near(photon_map, rows, j, p, ng, radius)
        for k in range(first, last):
            photon = photon_map.photons[k]
            if photon.part // 2 != entry or row_of(photon_map.keys[k]) != row:
                continue
            if disc_weight(photon_map.places, k, p, ng, radius, inverse) <= 0.0:
                continue
            if facing(photon, ng, False) == 0.0:
                continue
            if photon.part % 2:
                shadow += 1
            else:
                direct += 1
    return direct, shadow


@kernel
def decide(
    shadows: Row,
    vertices: Table,
    asking: Table,
    entries: Table,
    directions: Table,
    count: int,
    verdicts: Table,
) -> int:
    """Verdict for each of ``count`` shadow rays; how many have to be asked.

    ``asking`` (n,): the vertex of each; ``entries``: its light; ``directions`` to it.
    """
    left = 0
    for k in range(count):
        vertex = vertices[asking[k]]
        p = vector(vertex.p)
        ng = vector(vertex.ng)
        verdicts[k] = ASK
        if dot(vector(directions[k]), ng) > 0.0:
            direct, shadow = count_photons(shadows, entries[k], p, ng)
            if direct + shadow >= shadows.least:
                low, high = share_bounds(shadow, direct + shadow)
                if high < shadows.lit:
                    verdicts[k] = LIT
                elif low > shadows.dark:
                    verdicts[k] = SHADOWED
        if verdicts[k] == ASK:
            left += 1
    return left
