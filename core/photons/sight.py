"""What a gather disc sees of its surface where other surfaces run through it.

A wall that stands in a floor parts the light: photons beyond it tell nothing of this side,
and under the wall there are none. The disc is divided into sectors, each of which ends at
the nearest border; photons count if they lie within, and the estimate is divided by the share
of the kernel that is left. Both use the same sectors, so even light stays exact.
"""

from __future__ import annotations

import math

import numpy as np

from ..geometry.vector import Vector, basis, dot
from ..jit import Table, kernel

#: Sectors of a disc, evenly spaced in y / (|x| + |y|), which takes no arcus tangent.
SECTORS = 64
_OF_QUARTER = SECTORS // 4
#: A table of sight has their lengths in radii, and whether they are asked for at all.
SIGHT = SECTORS + 1
#: Lines that pass this near to the middle, in radii, hide nothing: it lies on them.
_ON_LINE = 1e-9


def _rays() -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors (SECTORS + 1, 2) between the sectors; the share (SECTORS,) of each."""
    q = np.arange(SECTORS + 1) / _OF_QUARTER - 1.0
    y = np.where(q < 1.0, q, 2.0 - q)
    x = np.where(q < 1.0, 1.0, -1.0) * (1.0 - np.abs(y))
    ray = np.column_stack([x, y]) / np.hypot(x, y)[:, None]
    angle = np.unwrap(np.arctan2(ray[:, 1], ray[:, 0]))
    return ray, np.diff(angle) / (2.0 * math.pi)


_RAYS, _SHARES = _rays()


@kernel
def sector_of(x: float, y: float) -> int:
    """Sector that a place lies in."""
    size = abs(x) + abs(y)
    if size <= 0.0:
        return 0
    q = y / size
    if x < 0.0:
        q = 2.0 - q
    return min(int((q + 1.0) * _OF_QUARTER), SECTORS - 1)


@kernel
def open_sight(sight: Table) -> None:
    """Let ``sight`` (SIGHT,) reach to the rim of the disc everywhere."""
    for k in range(SIGHT):
        sight[k] = 1.0


@kernel
def end_sight(sight: Table, x0: float, y0: float, x1: float, y1: float) -> None:
    """End the sectors of ``sight`` at a line from (x0, y0) to (x1, y1), in radii."""
    turn = x0 * y1 - x1 * y0
    if turn < 0.0:
        x0, y0, x1, y1, turn = x1, y1, x0, y0, -turn
    dx = x1 - x0
    dy = y1 - y0
    length = math.sqrt(dx * dx + dy * dy)
    if turn >= length or turn <= _ON_LINE * length:
        return
    first = sector_of(x0, y0)
    last = sector_of(x1, y1)
    steps = last - first
    if steps < 0:
        steps += SECTORS
    for j in range(steps + 1):
        k = (first + j) % SECTORS
        if j == 0:
            near = math.sqrt(x0 * x0 + y0 * y0)
        else:
            near = turn / (_RAYS[k, 0] * dy - _RAYS[k, 1] * dx)
        if j == steps:
            far = math.sqrt(x1 * x1 + y1 * y1)
        else:
            far = turn / (_RAYS[k + 1, 0] * dy - _RAYS[k + 1, 1] * dx)
        sight[k] = min(sight[k], min(near, far))


@kernel
def is_hidden(sight: Table, to: Vector, ng: Vector, radius: float) -> bool:
    """Whether the place ``to`` from the disc's middle lies beyond what it sees."""
    t, s = basis(ng)
    x = dot(to, t)
    y = dot(to, s)
    reach = sight[sector_of(x, y)] * radius
    return x * x + y * y > reach * reach


@kernel
def seen_share(sight: Table, part: float) -> float:
    """Share of the kernel within sight; of the smaller kernel of ``part`` of the radius."""
    share = 0.0
    for k in range(SECTORS):
        reach = min(1.0, sight[k] / part)
        rest = 1.0 - reach * reach
        share += _SHARES[k] * (1.0 - rest * rest)
    return share
