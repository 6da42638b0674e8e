"""The zones that gather rays are guided by, and their histograms from what rays brought."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera_pass.guide import BINS, SIDES, Guide, no_guide

#: Places in a zone, at most.
PLACES = 64
#: A zone's box is wider than its places by this part of its diagonal: as far as they are
#: from each other.
MARGIN = 0.15
#: What a bin is in the zone around counts like so many rays of its own.
BELIEF = 8.0
#: Share of the BSDF's own directions.
FLOOR = 0.2


class Zones(NamedTuple):
    """A guide without histograms, and the nodes of its tree: ``parent`` (T,), -1 for roots."""

    guide: Guide
    parent: NDArray[np.int32]

    def levels(self) -> list[slice]:
        """Which nodes are equally deep, from the roots on."""
        found = [slice(0, SIDES)]
        while found[-1].stop < len(self.parent):
            # Nodes are in the order of their parents.
            end = found[-1].stop
            found.append(slice(end, end + int(np.searchsorted(self.parent[end:], end))))
        return found


def find_zones(places: NDArray[np.float64], side: NDArray[np.int32]) -> Zones:
    """Halve ``places`` (P, 3) of each ``side`` (P,) until few are left; -1 is left out."""
    nodes: list[NDArray[np.intp]] = [np.flatnonzero(side == k) for k in range(SIDES)]
    axis, cut, child, parent = [], [], [], [-1] * SIDES
    boxes: list[NDArray[np.float64]] = []
    k = 0
    while k < len(nodes):
        own = places[nodes[k]]
        along, middle, below = _halves(own)
        axis.append(along)
        cut.append(middle)
        if along >= 0:
            child.append(len(nodes))
            parent += [k, k]
            nodes += [nodes[k][below], nodes[k][~below]]
        elif len(own):
            child.append(len(boxes))
            low, high = own.min(axis=0), own.max(axis=0)
            margin = MARGIN * np.linalg.norm(high - low)
            boxes.append(np.stack([low - margin, high + margin]))
        else:
            child.append(-1)
        nodes[k] = nodes[k][:0]
        k += 1
    if not boxes:
        return Zones(no_guide(), np.zeros(0, np.int32))
    corners = np.stack(boxes)
    guide = no_guide()._replace(
        axis=np.array(axis, np.int32),
        cut=np.array(cut),
        child=np.array(child, np.int32),
        low=corners[:, 0].copy(),
        high=corners[:, 1].copy(),
    )
    even = np.ones((len(boxes), BINS, BINS))
    return Zones(guide.with_density(even), np.array(parent, np.int32))


def _halves(places: NDArray[np.float64]) -> tuple[int, float, NDArray[np.bool_]]:
    """Longest axis, median, which lie below it; axis -1 where there is nothing to halve."""
    if len(places) > PLACES:
        along = int(np.argmax(np.ptp(places, axis=0)))
        middle = float(np.median(places[:, along]))
        below = places[:, along] < middle
        if below.any():
            return along, middle, below
    return -1, 0.0, np.zeros(len(places), np.bool_)


class Learnt:
    """Sums of what gather rays brought, by zone and bin."""

    def __init__(self, zones: Zones) -> None:
        self.zones = zones
        self.squares = np.zeros(zones.guide.zones * BINS * BINS)
        self.counts = np.zeros(zones.guide.zones * BINS * BINS)

    def add(
        self, zone: NDArray[np.int32], bins: NDArray[np.int32], square: NDArray[np.float64]
    ) -> None:
        """Rays in ``bins`` (n,) of ``zone`` (n,), the squares (n,) of what they brought.

        Squares as the BSDF alone would have had them. A bin's mean does not hang on how many
        rays fell into it, so guided rays teach as well as others.
        """
        known = (zone >= 0) & (bins >= 0) & np.isfinite(square)
        at = zone[known] * (BINS * BINS) + bins[known]
        self.squares += np.bincount(at, square[known], minlength=len(self.squares))
        self.counts += np.bincount(at, minlength=len(self.counts))

    def guide(self) -> Guide:
        """Densities in proportion to the root of the mean square, above the floor.

        That is the least variance (Rath et al. 2020, "Variance-aware path guiding").
        A bin's mean square leans on that of the larger zone around, scaled to what the
        smaller one has brought, as far as it has few rays of its own.
        """
        guide, parent = self.zones
        nodes = len(parent)
        squares, counts = np.zeros((2, nodes, BINS * BINS))
        leaves = np.flatnonzero((guide.axis < 0) & (guide.child >= 0))
        squares[leaves] = self.squares.reshape(-1, BINS * BINS)[guide.child[leaves]]
        counts[leaves] = self.counts.reshape(-1, BINS * BINS)[guide.child[leaves]]
        levels = self.zones.levels()
        for level in reversed(levels[1:]):
            # Halves of a zone follow each other.
            above = parent[level][::2]
            squares[above] = squares[level][::2] + squares[level][1::2]
            counts[above] = counts[level][::2] + counts[level][1::2]
        means = np.ones_like(squares)
        for level in levels:
            roots = parent[level] < 0
            around = np.where(roots[:, None], 1.0, means[parent[level]])
            expected = (counts[level] * around).sum(axis=1)
            scale = squares[level].sum(axis=1) / np.where(expected > 0.0, expected, np.inf)
            leant = squares[level] + BELIEF * scale[:, None] * around
            means[level] = leant / (counts[level] + BELIEF)
        density = np.sqrt(means[leaves])
        sums = density.mean(axis=1, keepdims=True)
        density = np.where(sums > 0.0, density / np.where(sums > 0.0, sums, 1.0), 1.0)
        found = np.empty((guide.zones, BINS, BINS))
        mixed = FLOOR + (1.0 - FLOOR) * density
        found[guide.child[leaves]] = mixed.reshape(-1, BINS, BINS)
        return guide.with_density(found)
