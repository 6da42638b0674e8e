"""How much of a gather disc lies on the surface: the remedy for dark borders.

A density estimate divides by the area of its disc. Beyond the edge of a table or the corner
of a room there is no surface that could hold photons of this one, and the estimate is too
dark, by a half at the border itself (boundary bias: Jensen 2001, section 7.2). Divided by
the share of the kernel that lies on surfaces it is right for even light.

The share is a sum over the borders near by (Green's theorem): a piece of a border hides, of
the sector that it spans about the disc's middle, what lies beyond it; one seen from behind
begins another part of the surface and adds as much. So the surface may have any shape, holes
and separate parts included, and the pieces stand in no order.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.borders import ABOVE, BELOW, CROSSING, Borders
from ..geometry.vector import Vector, add, basis, dot, read, scale, subtract
from ..jit import Row, Table, kernel
from .cells import bucket_of, cell_key
from .gather import LEAST_COSINE
from .rows import MOST_HEIGHT
from .sight import SECTORS, end_sight, open_sight, seen_share

#: Radius of a disc of half the area.
HALF_AREA = 1.0 / math.sqrt(2.0)
#: Least share that an estimate is divided by.
LEAST_SHARE = 0.1
#: Pieces of borders, each cut into 8 at most where its sides differ (81 bytes, and up to 8
#: entries of 12 bytes in the grid).
MOST_PIECES = 100_000
#: A cell with more pieces is left without: its surfaces are finer than the disc.
MOST_IN_CELL = 256
#: Faces turned over belong to a surface when they lie in its plane, to this part of the
#: radius; else they are the back of something thin.
_IN_PLANE = 1e-3


#: Pieces lie on one line if their ends are this near to it [radii].
ONE_LINE = 1e-2


class BorderGrid(NamedTuple):
    """Borders in the cells of a hashed grid.

    ends, normal, gap, parts: see ``Borders``; for each entry its cell ``keys`` (P,) i8 and
    ``piece`` (P,) i4; ``start`` (B+1,) i4 of the buckets; ``cell`` [m].
    """

    ends: NDArray[np.float64]
    normal: NDArray[np.float64]
    gap: NDArray[np.float64]
    parts: NDArray[np.int8]
    keys: NDArray[np.int64]
    piece: NDArray[np.int32]
    start: NDArray[np.int32]
    cell: float


def border_grid(borders: Borders, radius: float) -> BorderGrid:
    """Put each piece, at most ``radius`` long, into the cells within ``radius`` of it."""
    cell = 2.0 * radius
    low = np.floor((borders.ends.min(axis=1) - radius) / cell).astype(np.int64)
    high = np.floor((borders.ends.max(axis=1) + radius) / cell).astype(np.int64)
    places, owners = [], []
    # A piece's box with its margin is at most 3 radii wide: up to 3 cells.
    for dx, dy, dz in np.ndindex(3, 3, 3):
        place = low + (dx, dy, dz)
        inside = np.flatnonzero((place <= high).all(axis=1))
        places.append(place[inside])
        owners.append(inside.astype(np.int32))
    cells, piece = np.concatenate(places), np.concatenate(owners)
    keys = np.zeros(len(cells), np.int64)
    bucket = np.zeros(len(cells), np.int32)
    buckets = 1 << max(4, math.ceil(math.log2(max(1, len(cells)))))
    find_buckets(cells, buckets, keys, bucket)
    _, inverse, count = np.unique(keys, return_inverse=True, return_counts=True)
    few = np.flatnonzero(count[inverse.reshape(-1)] <= MOST_IN_CELL)
    few = few[np.argsort(bucket[few], kind="stable")]
    start = np.zeros(buckets + 1, np.int32)
    start[1:] = np.cumsum(np.bincount(bucket[few], minlength=buckets))
    return BorderGrid(*borders, keys[few], piece[few], start, cell)


@kernel
def find_buckets(cells: Table, buckets: int, keys: Table, bucket: Table) -> None:
    """Key and bucket of each of ``cells`` (P, 3) i8."""
    for k in range(len(cells)):
        keys[k] = cell_key(cells[k, 0], cells[k, 1], cells[k, 2])
        bucket[k] = bucket_of(keys[k], buckets)


@kernel
def _primitive(distance: float, along: float) -> float:
    """Integral of (1 - (distance / cos)^2)^2 over the angle, up to ``along`` on the line."""
    square = distance * distance
    rest = square + along * along / 3.0 - 2.0
    return math.atan2(along, distance) + distance * along * rest


@kernel
def share_beyond(x0: float, y0: float, x1: float, y1: float) -> float:
    """Share of the Epanechnikov kernel of radius 1 beyond a line from (x0, y0) to (x1, y1).

    Seen from the middle along a ray, (1 - x^2)^2 / (2 pi) of it per angle lies beyond x.
    Negative where the line runs clockwise about the middle.
    """
    dx = x1 - x0
    dy = y1 - y0
    length = math.sqrt(dx * dx + dy * dy)
    if length <= 0.0:
        return 0.0
    turn = (x0 * y1 - x1 * y0) / length
    distance = abs(turn)
    if distance >= 1.0:
        return 0.0
    half = math.sqrt(1.0 - distance * distance)
    first = min(max((x0 * dx + y0 * dy) / length, -half), half)
    last = min(max((x1 * dx + y1 * dy) / length, -half), half)
    share = (_primitive(distance, last) - _primitive(distance, first)) / (2.0 * math.pi)
    return share if turn >= 0.0 else -share


@kernel
def pieces_near(grid: Row, p: Vector) -> tuple[int, int, int]:
    """Entries that may lie in the cell of ``p``: (first, last + 1, key); others are not."""
    key = cell_key(
        int(math.floor(p[0] / grid.cell)),
        int(math.floor(p[1] / grid.cell)),
        int(math.floor(p[2] / grid.cell)),
    )
    bucket = bucket_of(key, len(grid.start) - 1)
    return grid.start[bucket], grid.start[bucket + 1], key


@kernel
def lies_by(grid: Row, k: int, key: int, p: Vector, n: Vector, radius: float) -> float:
    """Cosine between ``n`` and the normal of a piece in the plane of the disc, else 0.

    ``n``: normal by winding of the face that ``p`` is on. The surface does not go on beside.
    """
    e = grid.piece[k]
    if grid.keys[k] != key or grid.gap[e] <= MOST_HEIGHT * radius:
        return 0.0
    cosine = dot(read(grid.normal, e), n)
    if abs(cosine) < LEAST_COSINE:
        return 0.0
    a = subtract(read(grid.ends[e], 0), p)
    b = subtract(read(grid.ends[e], 1), p)
    height = 0.5 * abs(dot(a, n) + dot(b, n))
    flat = MOST_HEIGHT if cosine > 0.0 or grid.parts[e] & CROSSING else _IN_PLANE
    return cosine if height <= flat * radius else 0.0


@kernel
def on_disc(
    grid: Row, e: int, p: Vector, frame: tuple[Vector, Vector], factor: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Both ends of piece ``e`` in the plane of ``frame`` about ``p``, times ``factor``."""
    t, s = frame
    a = subtract(read(grid.ends[e], 0), p)
    b = subtract(read(grid.ends[e], 1), p)
    return (dot(a, t) * factor, dot(a, s) * factor), (dot(b, t) * factor, dot(b, s) * factor)


@kernel
def near_on_disc(
    grid: Row, k: int, key: int, p: Vector, n: Vector, radius: float, reach: float
) -> tuple[bool, tuple[float, float], tuple[float, float]]:
    """Whether a piece lies by ``p`` and as near as ``reach``, and its ends [radii].

    ``n``: normal by winding. The ends are ``on_disc`` in the plane of its ``basis``.
    """
    if lies_by(grid, k, key, p, n, radius) == 0.0:
        return False, (0.0, 0.0), (0.0, 0.0)
    a, b = on_disc(grid, grid.piece[k], p, basis(n), 1.0 / radius)
    return _nearest(a[0], a[1], b[0], b[1]) < reach * reach, a, b


@kernel
def line_near(
    grid: Row,
    p: Vector,
    outside: bool,
    radius: float,
    reach: float,
    n: Vector,
) -> tuple[int, Vector, float]:
    """Borders that come as near to ``p`` as ``reach`` (1 at most) of the radius.

    Returns how many lines they lie on (0, 1, or 2 for more) and, of one, a unit normal in the
    plane and its distance from ``p`` along that [radii]. ``n``, ``outside``: as for
    ``look_around``.
    """
    none = (0.0, 0.0, 0.0)
    first, last, key = pieces_near(grid, p)
    if first == last:
        return 0, none, 0.0
    by_winding = n if outside else scale(n, -1.0)
    longest = 0.0
    x = y = distance = 0.0
    found = 0
    for k in range(first, last):
        near, a, b = near_on_disc(grid, k, key, p, by_winding, radius, reach)
        if not near:
            continue
        found += 1
        dx = b[0] - a[0]
        dy = b[1] - a[1]
        length = math.sqrt(dx * dx + dy * dy)
        if length > longest:
            longest = length
            x = -dy / length
            y = dx / length
            distance = x * a[0] + y * a[1]
    if found == 0:
        return 0, none, 0.0
    if longest == 0.0:
        return 2, none, 0.0
    for k in range(first, last):
        near, a, b = near_on_disc(grid, k, key, p, by_winding, radius, reach)
        if not near:
            continue
        for end in (a, b):
            if abs(x * end[0] + y * end[1] - distance) > ONE_LINE:
                return 2, none, 0.0
    t, s = basis(by_winding)
    return 1, add(scale(t, x), scale(s, y)), distance


@kernel
def look_around(
    grid: Row, p: Vector, ng: Vector, outside: bool, radius: float, sight: Table
) -> tuple[bool, float, float]:
    """Whether surfaces part the disc about ``p``, and the share of the kernel that counts.

    Returns (parted, share, share of the kernel on half the area), of what lies on surfaces
    that the gather would count photons of; ``LEAST_SHARE`` at least. ``outside`` tells that
    ``ng`` is the side that the face's winding calls outside. If parted, ``sight`` (SIGHT,)
    ends at all borders, else it is not asked for. A wall at the end of a surface parts the
    disc only if another surface begins behind.
    """
    sight[SECTORS] = 0.0
    first, last, key = pieces_near(grid, p)
    if first == last:
        return False, 1.0, 1.0
    n = ng if outside else scale(ng, -1.0)
    frame = basis(n)
    inverse = 1.0 / radius
    share = half = 1.0
    wall = beyond = crossed = False
    for k in range(first, last):
        cosine = lies_by(grid, k, key, p, n, radius)
        if cosine == 0.0:
            continue
        e = grid.piece[k]
        a, b = on_disc(grid, e, p, frame, inverse)
        square = _nearest(a[0], a[1], b[0], b[1])
        if square >= 1.0:
            continue
        if grid.parts[e] & CROSSING:
            crossed = True
            continue
        side = 1.0 if cosine > 0.0 else -1.0
        part = side * share_beyond(a[0], a[1], b[0], b[1])
        share -= part
        if square < HALF_AREA * HALF_AREA:
            a, b = on_disc(grid, e, p, frame, inverse / HALF_AREA)
            half -= side * share_beyond(a[0], a[1], b[0], b[1])
        beyond = beyond or part < 0.0
        above = (cosine > 0.0) == outside
        wall = wall or (grid.parts[e] & (ABOVE if above else BELOW)) != 0
    if not crossed and not (wall and beyond):
        return False, min(1.0, max(LEAST_SHARE, share)), min(1.0, max(LEAST_SHARE, half))
    open_sight(sight)
    frame = basis(ng)
    for k in range(first, last):
        if lies_by(grid, k, key, p, n, radius) != 0.0:
            a, b = on_disc(grid, grid.piece[k], p, frame, inverse)
            end_sight(sight, a[0], a[1], b[0], b[1])
    return (
        True,
        max(LEAST_SHARE, seen_share(sight, 1.0)),
        max(LEAST_SHARE, seen_share(sight, HALF_AREA)),
    )


@kernel
def _nearest(x0: float, y0: float, x1: float, y1: float) -> float:
    """Squared distance from the middle to a line from (x0, y0) to (x1, y1)."""
    dx = x1 - x0
    dy = y1 - y0
    square = dx * dx + dy * dy
    along = 0.0
    if square > 0.0:
        along = min(1.0, max(0.0, -(x0 * dx + y0 * dy) / square))
    x = x0 + along * dx
    y = y0 + along * dy
    return x * x + y * y
