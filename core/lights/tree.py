"""A tree of boxes around the lamps: which ones a ray may cross, and which one to ask.

Nodes stand in depth-first order: the first child follows its parent, the second stands at
the first one's ``skip``. To ask one of many, clusters of about the root of their number are
weighed by strength over the square of the distance, near ones lamp by lamp: a descent of the
tree by the same rule loses at each level around the point (see "Decisions").
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.vector import Vector
from ..jit import Row, kernel

#: Lamps in a cluster, at least; of many lamps it is the root of their number.
CLUSTER = 16
#: A cluster nearer than this many of its radii is weighed lamp by lamp.
NEAR = 3.0


class LightTree(NamedTuple):
    """Boxes around local lamps that shine.

    low, high (M, 3); strength (M,): sum of what is inside; skip (M,): the node behind this
    one and all inside of it; entry (M,): the lamp of a leaf or -1; leaf (N + 2,): node of an
    entry, -1 when it is not in the tree; clusters (C,): nodes whose lamps are drawn
    together; cluster (N + 2,): that of an entry, -1 as for ``leaf``.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    strength: NDArray[np.float64]
    skip: NDArray[np.int32]
    entry: NDArray[np.int32]
    leaf: NDArray[np.int32]
    clusters: NDArray[np.int32]
    cluster: NDArray[np.int32]


def light_tree(
    place: NDArray[np.float64],
    half: NDArray[np.float64],
    strength: NDArray[np.float64],
    local: NDArray[np.intp],
) -> LightTree:
    """Cut lamps in halves by place until each stands alone.

    ``place`` and ``half`` (N, 3): middles and half sizes of the boxes around the lamps;
    ``strength`` (N + 2,) as in ``LightSet``; ``local``: the lamps to take.
    """
    count = max(0, 2 * len(local) - 1)
    low, high = np.zeros((count, 3)), np.zeros((count, 3))
    total = np.zeros(count)
    skip = np.zeros(count, np.int32)
    entry, leaf = np.full(count, -1, np.int32), np.full(len(strength), -1, np.int32)
    clusters, cluster = [], leaf.copy()
    most = max(CLUSTER, int(len(local) ** 0.5))
    pending = [(local, False)] if count else []
    node = 0
    while pending:
        group, inside = pending.pop()
        low[node] = (place[group] - half[group]).min(axis=0)
        high[node] = (place[group] + half[group]).max(axis=0)
        total[node] = strength[group].sum()
        skip[node] = node + 2 * len(group) - 1
        if not inside and len(group) <= most:
            inside = True
            clusters.append(node)
            cluster[group] = node
        if len(group) == 1:
            entry[node], leaf[group[0]] = group[0], node
        else:
            axis = int(np.ptp(place[group], axis=0).argmax())
            order = group[np.argsort(place[group, axis], kind="stable")]
            middle = len(order) // 2
            pending += [(order[middle:], inside), (order[:middle], inside)]
        node += 1
    nodes = np.array(clusters, np.int32)
    return LightTree(low, high, total, skip, entry, leaf, nodes, cluster)


@kernel
def _crosses(tree: Row, k: int, o: Vector, inverse: Vector, reach: float) -> bool:
    """Slab test of the ray against box ``k``."""
    near = 0.0
    far = reach
    for axis in range(3):
        a = (tree.low[k, axis] - o[axis]) * inverse[axis]
        b = (tree.high[k, axis] - o[axis]) * inverse[axis]
        near = max(near, min(a, b))
        far = min(far, max(a, b))
    return near <= far


@kernel
def _inverse(x: float) -> float:
    return 1.0 / x if abs(x) > 1e-30 else 1e30


@kernel
def next_lamp(tree: Row, k: int, o: Vector, d: Vector, reach: float) -> tuple[int, int]:
    """The next lamp from node ``k`` on whose box the ray crosses: (entry or -1, next node).

    Start with node 0 and go on with the node given, until the entry is -1.
    """
    inverse = (_inverse(d[0]), _inverse(d[1]), _inverse(d[2]))
    while k < len(tree.skip):
        if not _crosses(tree, k, o, inverse, reach):
            k = tree.skip[k]
            continue
        entry = tree.entry[k]
        k += 1
        if entry >= 0:
            return entry, k
    return -1, k


@kernel
def _squares(tree: Row, k: int, p: Vector) -> tuple[float, float]:
    """Squared distance from ``p`` to the middle of box ``k``, and of its half diagonal."""
    d2 = 0.0
    size2 = 0.0
    for axis in range(3):
        to_middle = 0.5 * (tree.low[k, axis] + tree.high[k, axis]) - p[axis]
        half = 0.5 * (tree.high[k, axis] - tree.low[k, axis])
        d2 += to_middle * to_middle
        size2 += half * half
    return d2, size2


@kernel
def node_strength(tree: Row, k: int, p: Vector) -> float:
    """About the irradiance at ``p`` from what is in box ``k``."""
    d2, size2 = _squares(tree, k, p)
    return tree.strength[k] / max(d2, size2, 1e-30)


@kernel
def _lamps_strength(tree: Row, k: int, p: Vector) -> float:
    """Strength at ``p`` of the lamps in box ``k``, each by itself."""
    total = 0.0
    for j in range(k, tree.skip[k]):
        if tree.entry[j] >= 0:
            total += node_strength(tree, j, p)
    return total


@kernel
def _cluster_strength(tree: Row, k: int, p: Vector) -> float:
    """Strength at ``p`` of cluster ``k``: as one from afar, else lamp by lamp."""
    d2, size2 = _squares(tree, k, p)
    if d2 < NEAR * NEAR * size2:
        return _lamps_strength(tree, k, p)
    return tree.strength[k] / max(d2, size2, 1e-30)


@kernel
def tree_strength(tree: Row, p: Vector) -> float:
    """About the irradiance at ``p`` from all lamps of the tree."""
    total = 0.0
    for j in range(len(tree.clusters)):
        total += _cluster_strength(tree, tree.clusters[j], p)
    return total


@kernel
def sample_tree(tree: Row, p: Vector, total: float, u: float) -> tuple[int, float]:
    """Draw a lamp for ``p``: (entry, probability); ``total`` is ``tree_strength``."""
    chosen = -1
    share = 0.0
    before = 0.0
    for j in range(len(tree.clusters)):
        chosen = tree.clusters[j]
        share = _cluster_strength(tree, chosen, p) / total
        if u < before + share:
            break
        before += share
    u = (u - before) / share
    whole = _lamps_strength(tree, chosen, p)
    entry = -1
    part = 0.0
    before = 0.0
    for j in range(chosen, tree.skip[chosen]):
        if tree.entry[j] < 0:
            continue
        entry = tree.entry[j]
        part = node_strength(tree, j, p) / whole
        before += part
        if u < before:
            break
    return entry, share * part


@kernel
def tree_probability(tree: Row, p: Vector, total: float, entry: int) -> float:
    """Probability that ``sample_tree`` draws ``entry``."""
    leaf = tree.leaf[entry]
    cluster = tree.cluster[entry]
    whole = _lamps_strength(tree, cluster, p)
    share = _cluster_strength(tree, cluster, p) / total
    return share * node_strength(tree, leaf, p) / whole
