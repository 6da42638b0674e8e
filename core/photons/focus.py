"""Places where photons crowd: light from there is brought by photons, not by gather rays.

A small bright place, such as the focus of a lens, is met by few gather rays, and each of them
brings a lot: white speckle. The photons that are scattered there are many, and land wherever
that light goes. So each photon's flux is shared out where it lies, by a number that hangs on
the place alone: ``kept`` of it stays for gather rays to find, and the rest is counted where
the photon lands next. The sum is the same whatever the number is; the balance heuristic
(Veach 1997, 9.2) makes its variance small: as many gather rays meet a place as photons that
leave it land in a disc.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import CASTING, NARROW, SPREADING, WIDE, eval_part, part_share
from ..geometry.vector import Vector, store, vector
from ..jit import Row, Table, kernel
from ..sampling.rng import mix
from .cells import cell_key

if TYPE_CHECKING:
    from .trace import Walk

#: Photons around a place whose distance tells how bright the usual place is.
NEIGHBOURS = 20
#: Irradiance from which on a place is crowded, in that of the place of the median photon, ...
BRIGHT = 2.5
#: ... photons there for one at the place of the median photon: fewer would be blotches, ...
DENSE = 25.0
#: ... photons that tell so in a cell, ...
TELLING = 8
#: ... and the part that stays for gather rays there; it falls with the irradiance.
KEPT = 0.5
#: In place of a photon's part: the row belongs into the map of what crowded places send out,
#: where all WIDE lobes answer to it.
FOCUSED = 4
_FREE = -1


class Cells(NamedTuple):
    """The crowded cells: an open hash table (T,) of their keys, and what is kept there.

    ``edge`` [m], 0 where there are none.
    """

    keys: NDArray[np.int64]
    kept: NDArray[np.float64]
    edge: float


class Focus(NamedTuple):
    """Where photons crowd: those that have met casters alone, and all others.

    The former go on as caustic photons where there are any (``apart``), which are many there.
    """

    caustic: Cells
    others: Cells
    apart: bool

    @property
    def found(self) -> int:
        """How many crowded cells there are."""
        return int(sum((cells.keys != _FREE).sum() for cells in (self.caustic, self.others)))


def _no_cells() -> Cells:
    return Cells(np.full(1, _FREE, np.int64), np.ones(1), 0.0)


def no_focus() -> Focus:
    """Of a scene without crowded places."""
    return Focus(_no_cells(), _no_cells(), False)


def find_focus(global_: Walk, caustic: Walk | None, most_depth: int) -> Focus:
    """Where the photons of pilot walks of as many paths crowd; no camera decides it.

    ``most_depth``: bound on the events of their paths.
    """
    photons = global_.photons
    density = _usual_density(photons)
    usual = density, density * _mean_flux(photons)
    if caustic is None:
        return Focus(_no_cells(), _crowded(photons, *usual), False)
    met = (photons["part"] == SPREADING) & (global_.order % most_depth > 0)
    return Focus(_crowded(caustic.photons, *usual), _crowded(photons[~met], *usual), True)


def _usual_density(photons: NDArray[np.void]) -> float:
    """Photons per area [1/m^2] where the median photon lies."""
    from scipy.spatial import cKDTree

    if len(photons) < 2 * NEIGHBOURS:
        return 0.0
    places = photons["position"].astype(np.float64)
    some = places[:: max(1, len(places) // 1024)]
    distance, _ = cKDTree(places).query(some, k=[NEIGHBOURS])
    area = np.pi * float(np.median(distance)) ** 2
    return NEIGHBOURS / area if area > 0.0 else 0.0


def _mean_flux(photons: NDArray[np.void]) -> float:
    return float(photons["flux"].mean()) if len(photons) else 0.0


def _crowded(photons: NDArray[np.void], density: float, irradiance: float) -> Cells:
    """Cells in which ``photons`` are ``DENSE`` and bring ``BRIGHT`` light.

    In units of the usual ``density`` [1/m^2] and ``irradiance`` [W/m^2]. A cell is just so
    large that they are then ``TELLING``.
    """
    flux = _mean_flux(photons)
    if not irradiance > 0.0 or not flux > 0.0:
        return _no_cells()
    edge = math.sqrt(TELLING / max(DENSE * density, BRIGHT * irradiance / flux))
    keys = np.zeros(len(photons), np.int64)
    cells_of(photons["position"], edge, keys)
    own, count = np.unique(keys, return_counts=True)
    own, count = own[count >= TELLING], count[count >= TELLING]
    if len(own) == 0:
        return _no_cells()
    size = 4 << math.ceil(math.log2(len(own)))
    table = Cells(np.full(size, _FREE, np.int64), np.ones(size), edge)
    enter(table.keys, table.kept, own, KEPT * TELLING / count)
    return table


@kernel
def cells_of(places: Table, cell: float, keys: Table) -> None:
    """Key of the cell of each of ``places`` (n, 3), into ``keys`` (n,)."""
    for k in range(len(places)):
        p = places[k]
        keys[k] = _cell(p[0], p[1], p[2], cell)


@kernel
def _cell(x: float, y: float, z: float, edge: float) -> int:
    return cell_key(
        int(math.floor(x / edge)), int(math.floor(y / edge)), int(math.floor(z / edge))
    )


@kernel
def _slot(keys: Table, key: int) -> int:
    """Where ``key`` is in the table, or would be."""
    mask = len(keys) - 1
    at = np.int64(mix(np.uint64(key)) & np.uint64(mask))
    while keys[at] != key and keys[at] != _FREE:
        at = (at + 1) & mask
    return int(at)


@kernel
def enter(keys: Table, kept: Table, own: Table, share: Table) -> None:
    """Put cells ``own`` (n,) with what they keep into the table, which has room for them."""
    for k in range(len(own)):
        at = _slot(keys, own[k])
        keys[at] = own[k]
        kept[at] = share[k]


@kernel
def kept_at(cells: Row, p: Vector) -> float:
    """Part of a photon's flux at ``p`` that is left to gather rays."""
    if cells.edge == 0.0:
        return 1.0
    at = _slot(cells.keys, _cell(p[0], p[1], p[2], cells.edge))
    return 1.0 if cells.keys[at] == _FREE else float(cells.kept[at])


@kernel
def share_out(focus: Row, path: Row, hit: Row, lobes: Table, caustic: bool) -> Any:
    """Parts of a photon's flux: (left to gather rays here, not counted where it lands next).

    All of it is left on rough mirrors and glass: there gather rays and photons part the lobes
    in different ways.
    """
    apart = focus.apart and path.depth > 0 and (caustic or path.part == SPREADING)
    if caustic and (not apart or is_focused(path)):
        return 1.0, 1.0
    left = kept_at(focus.caustic if apart else focus.others, vector(hit.p))
    if left < 1.0 and not _parts_alike(path, lobes):
        left = 1.0
    return (1.0, left) if caustic else (left, 1.0 if apart else left)


@kernel
def is_focused(path: Row) -> bool:
    """Whether a photon was last scattered where photons take over from gather rays."""
    return bool(path.focused[0] + path.focused[1] + path.focused[2] > 0.0)


@kernel
def _parts_alike(surface: Row, lobes: Table) -> bool:
    """Whether gather rays and photons share out the lobes in the same way."""
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        if part_share(lobes[k], WIDE) != part_share(lobes[k], SPREADING):
            return False
    return True


@kernel
def mark(
    path: Row, hit: Row, lobes: Table, part: int, wi: Vector, pdf_w: float, kept: float
) -> None:
    """What of a photon that was scattered to ``wi`` counts where it lands next.

    All but what was ``kept``; of a rough mirror's lobe, no delta, only what gather rays follow,
    since the rest ends them there.
    """
    if part != CASTING:
        store(path.focused, (1.0 - kept, 1.0 - kept, 1.0 - kept))
    elif pdf_w > 0.0 and is_focused(path):
        n, wo = vector(hit.ns), vector(hit.wo)
        whole = eval_part(path, lobes, n, wo, wi, CASTING)
        narrow = eval_part(path, lobes, n, wo, wi, NARROW)
        for c in range(3):
            path.focused[c] *= narrow[c] / whole[c] if whole[c] > 0.0 else 0.0


def parted(walks: list[Walk]) -> tuple[list[Walk], list[Walk]]:
    """Walks without what comes from crowded places, and that alone (where there is any)."""
    others, focused = [], []
    for walk in walks:
        apart = walk.photons["part"] == FOCUSED
        if not apart.any():
            others.append(walk)
            continue
        others.append(walk._replace(photons=walk.photons[~apart], order=walk.order[~apart]))
        rows = walk.photons[apart]
        rows["part"] = WIDE
        focused.append(walk._replace(photons=rows, order=walk.order[apart], rays=0, seen=None))
    return others, focused
