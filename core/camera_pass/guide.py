"""Gather rays guided to where the light comes from: a histogram of directions for each zone.

Jensen 1995, "Importance driven path tracing using the photon map", draws directions from a
histogram over the hemisphere. Here its bins are those of the unit square that cosine lobes are
sampled from, so all have the same share of the cosine: a density of 1 in all bins is the
BSDF's own, and a floor below them is the mixture with it. A stratified point of the square is
warped row by row, so that it stays stratified. Zones are the leaves of a k-d tree over the
places that the camera sees, one tree for each of the six main directions of the normal (as
the spatial tree of Mueller, Gross and Novak 2017, "Practical path guiding", by halves).

Other lobes of a surface are sampled as ever; all densities are those of the mixture.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import WIDE, cosine_share, pdf_part
from ..geometry.vector import Vector, basis, dot, vector
from ..jit import Row, Table, kernel
from ..sampling.distributions import warp
from ..sampling.rng import mix
from ..sampling.warps import INV_PI, square_of_disk

#: Rows and columns of bins.
BINS = 8
#: Main directions of a normal: +x, -x, +y, -y, +z, -z.
SIDES = 6


class Guide(NamedTuple):
    """Zones of surfaces and the histogram of each.

    A k-d tree of T nodes, its first ``SIDES`` the roots: ``axis`` (T,) i4, -1 for a leaf;
    ``cut`` (T,): what is below lies in ``child``, the rest in ``child`` + 1; ``child`` of a
    leaf is its zone, -1 none. ``low``, ``high`` (R, 3): the box of a zone's places [m].
    ``density`` (R, BINS, BINS): relative to the BSDF's, mean 1; ``rows`` (R, BINS) and
    ``columns`` (R, BINS, BINS): cumulative, of whole rows and within each.
    """

    axis: NDArray[np.int32]
    cut: NDArray[np.float64]
    child: NDArray[np.int32]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    density: NDArray[np.float64]
    rows: NDArray[np.float64]
    columns: NDArray[np.float64]

    @property
    def zones(self) -> int:
        """How many zones there are; 0 when nothing is guided."""
        return len(self.density)

    def with_density(self, density: NDArray[np.float64]) -> Guide:
        """The same zones with other histograms (R, BINS, BINS), of mean 1 each."""
        sums = density.sum(axis=2)
        columns = np.cumsum(density / sums[:, :, None], axis=2)
        rows = np.cumsum(sums / sums.sum(axis=1, keepdims=True), axis=1)
        # The last entry is 1, so that rounding leaves nothing behind it.
        columns[:, :, -1] = 1.0
        rows[:, -1] = 1.0
        return self._replace(density=density, rows=rows, columns=columns)


def no_guide() -> Guide:
    """Nothing is guided: every place sends its rays as its BSDF says."""
    none = np.zeros(0)
    return Guide(
        np.zeros(0, np.int32), none, np.zeros(0, np.int32), none.reshape(0, 3),
        none.reshape(0, 3), none.reshape(0, BINS, BINS), none.reshape(0, BINS),
        none.reshape(0, BINS, BINS),
    )  # fmt: skip


@kernel
def side_of(n: Vector) -> int:
    """The main direction that ``n`` is nearest to: a root of the tree."""
    x, y, z = abs(n[0]), abs(n[1]), abs(n[2])
    if x >= y and x >= z:
        return 0 if n[0] >= 0.0 else 1
    if y >= z:
        return 2 if n[1] >= 0.0 else 3
    return 4 if n[2] >= 0.0 else 5


@kernel
def zone_of(guide: Row, p: Vector, n: Vector) -> int:
    """The zone that a place with shading normal ``n`` lies in; -1 where there is none."""
    if len(guide.density) == 0:
        return -1
    node = side_of(n)
    while guide.axis[node] >= 0:
        axis = guide.axis[node]
        at = p[0] if axis == 0 else (p[1] if axis == 1 else p[2])
        node = guide.child[node] + (0 if at < guide.cut[node] else 1)
    zone = guide.child[node]
    if zone < 0:
        return -1
    low, high = guide.low[zone], guide.high[zone]
    for c in range(3):
        if not low[c] <= p[c] <= high[c]:
            return -1
    return zone


@kernel
def warp_square(guide: Row, zone: int, u: float, v: float) -> tuple[float, float, float]:
    """The point of the unit square that (u, v) stands for, and the density there."""
    row, a, _ = warp(guide.rows[zone], u)
    column, b, _ = warp(guide.columns[zone, row], v)
    return (row + a) / BINS, (column + b) / BINS, guide.density[zone, row, column]


@kernel
def bin_of(n: Vector, wi: Vector) -> tuple[int, int]:
    """Row and column of a direction above ``n``."""
    t, s = basis(n)
    u, v = square_of_disk(dot(wi, t), dot(wi, s))
    return min(int(u * BINS), BINS - 1), min(int(v * BINS), BINS - 1)


@kernel
def guided_share(zone: int, vertex: Row, lobes: Table) -> float:
    """Share of a place's gather rays that its zone guides; 0 where it has none."""
    return cosine_share(vertex, lobes, WIDE) if zone >= 0 else 0.0


@kernel
def guided_ratio(
    guide: Row, zone: int, share: float, n: Vector, wi: Vector, pdf_w: float
) -> float:
    """The density of gather rays over ``pdf_w``, that of the wide part alone.

    ``share``: ``guided_share`` of a place with shading normal ``n``.
    """
    cosine = dot(n, wi)
    if share <= 0.0 or cosine <= 0.0 or not pdf_w > 0.0:
        return 1.0
    row, column = bin_of(n, wi)
    more = guide.density[zone, row, column] - 1.0
    return 1.0 + share * more * cosine * INV_PI / pdf_w


@kernel
def copy_places(vertices: Table, copies: int, number: int, out: Table) -> None:
    """Each of ``vertices`` ``copies`` times, with random numbers and a slot of its own.

    ``number``: that of their paths from now on.
    """
    for k in range(len(out)):
        out[k] = vertices[k // copies]
        other = np.uint64(k % copies + 1)
        out[k].key = mix(out[k].key + other)
        out[k].pixel_key = mix(out[k].pixel_key + other)
        out[k].number = number
        out[k].slot = k


@kernel
def note_rays(
    guide: Row,
    vertices: Table,
    lobes: Table,
    owner: Table,
    directions: Table,
    zone: Table,
    bins: Table,
    ratio: Table,
) -> None:
    """Where gather rays of ``vertices[owner]`` with ``directions`` (n, 3) belong.

    Writes ``zone`` (n,), -1 for none, ``bins`` (n,): row times BINS plus column, -1 below
    the surface, and ``ratio`` (n,): how much denser the guide has made them.
    """
    for k in range(len(owner)):
        vertex = vertices[owner[k]]
        n, wi = vector(vertex.ns), vector(directions[k])
        zone[k] = zone_of(guide, vector(vertex.p), n)
        bins[k] = -1
        ratio[k] = 1.0
        if dot(n, wi) > 0.0:
            row, column = bin_of(n, wi)
            bins[k] = row * BINS + column
            pdf_w = pdf_part(vertex, lobes, n, vector(vertex.wo), wi, WIDE)
            share = guided_share(zone[k], vertex, lobes)
            ratio[k] = guided_ratio(guide, zone[k], share, n, wi, pdf_w)


@kernel
def find_sides(vertices: Table, lobes: Table, side: Table) -> None:
    """``side_of`` each place; -1 where no lobe follows the cosine."""
    for k in range(len(vertices)):
        vertex = vertices[k]
        guided = cosine_share(vertex, lobes, WIDE) > 0.0
        side[k] = side_of(vector(vertex.ns)) if guided else -1
