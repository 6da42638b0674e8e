"""Which light a shading point asks: by unoccluded strength there, with a floor.

Few lights are weighed one by one. Of many, those without a place (suns, world, emissive
faces) are, beside the tree of all local lamps as one more.
"""

from __future__ import annotations

from ..geometry.vector import Vector
from ..jit import Row, kernel
from .tree import sample_tree, tree_probability, tree_strength

#: Up to this many entries each one's strength is weighed at the point itself.
FEW = 64
#: Share that is spread evenly over all lights: an estimate may never starve one.
FLOOR = 0.1


@kernel
def local_strength(lights: Row, entry: int, p: Vector) -> float:
    """About the irradiance that entry sends to ``p`` when nothing blocks it."""
    s = lights.strength[entry]
    if s <= 0.0 or lights.distant[entry]:
        return s
    x = p[0] - lights.place[entry, 0]
    y = p[1] - lights.place[entry, 1]
    z = p[2] - lights.place[entry, 2]
    size = lights.size[entry]
    return s / max(x * x + y * y + z * z, size * size, 1e-30)


@kernel
def _uses_tree(lights: Row) -> bool:
    return len(lights.strength) > FEW and len(lights.tree.skip) > 0


@kernel
def _totals(lights: Row, p: Vector) -> tuple[float, float, int]:
    """Strength of the tree, if used, that of all to choose between, and how many shine."""
    total = 0.0
    on = 0
    if _uses_tree(lights):
        total = tree_strength(lights.tree, p)
        on = 1
    tree = total
    for j in range(len(lights.choices)):
        s = local_strength(lights, lights.choices[j], p)
        total += s
        if s > 0.0:
            on += 1
    return tree, total, on


@kernel
def select_light(lights: Row, p: Vector, u: float) -> tuple[int, float]:
    """Draw an entry: (entry, probability); -1 when there is no light."""
    tree, total, on = _totals(lights, p)
    if on == 0:
        return -1, 0.0
    before = 0.0
    if tree > 0.0:
        share = FLOOR / on + (1.0 - FLOOR) * tree / total
        if u < share or on == 1:
            entry, prob = sample_tree(lights.tree, p, tree, min(u / share, 1.0 - 1e-12))
            return entry, prob * share
        before = share
    chosen = -1
    prob = 0.0
    for j in range(len(lights.choices)):
        s = local_strength(lights, lights.choices[j], p)
        if s <= 0.0:
            continue
        chosen = lights.choices[j]
        prob = FLOOR / on + (1.0 - FLOOR) * s / total
        before += prob
        if u < before:
            break
    return chosen, prob


@kernel
def selection_probability(lights: Row, p: Vector, entry: int) -> float:
    """Probability that ``select_light`` draws ``entry`` at ``p``."""
    tree, total, on = _totals(lights, p)
    if on == 0:
        return 0.0
    if tree > 0.0 and lights.tree.leaf[entry] >= 0:
        share = FLOOR / on + (1.0 - FLOOR) * tree / total
        return share * tree_probability(lights.tree, p, tree, entry)
    s = local_strength(lights, entry, p)
    if s <= 0.0:
        return 0.0
    return FLOOR / on + (1.0 - FLOOR) * s / total
