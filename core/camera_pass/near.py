"""Gather rays that end near their start: light there is gathered once more.

A disc much wider than the way to it brings light of places that the start cannot see: of the
other side of a thin wall or a slit, of the rim of a hollow. So where the way is shorter than a
part of the disc's radius, the end is lit as the start is: by lamps, caustics and a gather ray
of its own (Jensen 2001, 7.4, goes back to full evaluation near corners for the same reason).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..jit import Table, kernel
from ..sampling.rng import mix
from .seen import add

#: Ways that are shorter than this part of the global disc's radius are too short.
NEAR = 0.5
#: Ends that carry less than this part of what a camera path does go on by chance.
FAINT = 0.5
#: Gathers that may follow each other; a disc serves behind the last.
MOST_LEVELS = 16


def ends_near(vertices: NDArray[np.void], least: float, level: int) -> NDArray[np.bool_]:
    """Which ``vertices`` lie at the end of ways shorter than ``least`` [m]."""
    if level >= MOST_LEVELS:
        return np.zeros(len(vertices), np.bool_)
    return np.asarray(vertices["way"] < least)


@kernel
def begin_again(vertices: Table, sent: int) -> None:
    """Make the ends of chains starts, in rows of their own.

    Their random numbers are others than those that have chosen the way there. Faint ends are
    lit too, but send a ray in the mean of their ``portion`` only; no ray carries more for it
    than the first ones, of which there were ``sent``.
    """
    for k in range(len(vertices)):
        beta = vertices[k].beta
        carried = sent * max(beta[0], beta[1], beta[2])
        vertices[k].portion = min(1.0, max(carried, 1e-3) / FAINT)
        vertices[k].slot = k
        vertices[k].pixel_key = mix(vertices[k].key + np.uint64(1))


@kernel
def add_as_indirect(light: Table, slots: Table, rows: Table) -> None:
    """Add all ``light`` (n,) ``SAMPLE`` to the indirect layer of rows ``slots`` (n,)."""
    for k in range(len(slots)):
        row = rows[slots[k]]
        for layer in (light[k].direct, light[k].caustics, light[k].indirect):
            add(row.indirect, layer, (1.0, 1.0, 1.0), 1.0)
        add(row.shrink, light[k].shrink, (1.0, 1.0, 1.0), 1.0)
