"""Rows of cells around a place: where the photons of a disc may lie.

Cells that follow each other along x are one piece of a photon map, so that a disc is asked
for by rows, each cut to what the disc's slab can reach of it.
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector
from ..jit import Row, kernel
from .cells import bucket_of, cell_key, row_of

#: Photons count when they lie within this part of the radius of the disc's plane.
MOST_HEIGHT = 0.3
#: Edge of a cell in radii of the usual disc.
CELL = 1.0
#: A radius covers at most this many cells to each side of its own.
MOST_CELLS = 6
#: Buckets that stand a second time behind the last one, for rows that go on at the first.
REPEATED = 2 * MOST_CELLS + 2


@kernel
def largest_radius(cell: float) -> float:
    """Radius that a query may have at most in a grid of this cell."""
    return cell * MOST_CELLS


@kernel
def rows_near(cell: float, p: Vector, ng: Vector, radius: float) -> tuple[int, int, int, int]:
    """Rows that the disc about ``p``, with its height, meets.

    Returns the first in y and in z, how many there are in y, and how many there are.
    """
    high = MOST_HEIGHT * radius
    reach_y = radius * math.sqrt(max(0.0, 1.0 - ng[1] * ng[1])) + high * abs(ng[1])
    reach_z = radius * math.sqrt(max(0.0, 1.0 - ng[2] * ng[2])) + high * abs(ng[2])
    y = int(math.floor((p[1] - reach_y) / cell))
    z = int(math.floor((p[2] - reach_z) / cell))
    wide = int(math.floor((p[1] + reach_y) / cell)) - y + 1
    deep = int(math.floor((p[2] + reach_z) / cell)) - z + 1
    return y, z, wide, wide * deep


@kernel
def photons_near(
    photon_map: Row,
    rows: tuple[int, int, int, int],
    k: int,
    p: Vector,
    ng: Vector,
    radius: float,
) -> tuple[int, int, int]:
    """Photons of row ``k`` of ``rows_near`` that may lie in the disc: (first, last + 1, row).

    Photons of other rows may be among them; ``row_of`` their keys tells them apart.
    """
    cell = photon_map.cell
    y = rows[0] + k % rows[2]
    z = rows[1] + k // rows[2]
    high = MOST_HEIGHT * radius
    y0 = y * cell - p[1]
    z0 = z * cell - p[2]
    y1 = y0 + cell
    z1 = z0 + cell
    gap_y = max(0.0, y0, -y1)
    gap_z = max(0.0, z0, -z1)
    # The disc's corners stick out of the ball by at most the slab's height.
    left = radius * radius + high * high - gap_y * gap_y - gap_z * gap_z
    if left < 0.0:
        return 0, 0, 0
    last = math.sqrt(left)
    first = -last
    # Heights over the disc's plane within the row, its x left out.
    low = min(y0 * ng[1], y1 * ng[1]) + min(z0 * ng[2], z1 * ng[2])
    top = max(y0 * ng[1], y1 * ng[1]) + max(z0 * ng[2], z1 * ng[2])
    if abs(ng[0]) > 1e-3:
        a = (-high - top) / ng[0]
        b = (high - low) / ng[0]
        first = max(first, min(a, b))
        last = min(last, max(a, b))
    elif low - 1e-3 * last > high or top + 1e-3 * last < -high:
        return 0, 0, 0
    if first > last:
        return 0, 0, 0
    x0 = int(math.floor((p[0] + first) / cell))
    x1 = int(math.floor((p[0] + last) / cell))
    key = cell_key(x0, y, z)
    bucket = bucket_of(key, photon_map.buckets)
    return photon_map.start[bucket], photon_map.start[bucket + x1 - x0 + 1], row_of(key)
