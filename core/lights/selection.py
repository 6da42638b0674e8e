"""Which light a shading point asks: by unoccluded strength there, with a floor."""

from __future__ import annotations

from ..geometry.vector import Vector
from ..jit import Row, kernel
from ..sampling.distributions import probability, sample_discrete

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
def _totals(lights: Row, p: Vector) -> tuple[float, int]:
    """Sum of the local strengths and the number of lights that are on."""
    total = 0.0
    on = 0
    for k in range(len(lights.strength)):
        s = local_strength(lights, k, p)
        total += s
        if s > 0.0:
            on += 1
    return total, on


@kernel
def select_light(lights: Row, p: Vector, u: float) -> tuple[int, float]:
    """Draw an entry: (entry, probability); -1 when there is no light."""
    count = len(lights.strength)
    if count > FEW:
        k = sample_discrete(lights.photon_cdf, u)
        return k, probability(lights.photon_cdf, k)
    total, on = _totals(lights, p)
    if on == 0:
        return -1, 0.0
    sum_before = 0.0
    chosen = -1
    prob = 0.0
    for k in range(count):
        s = local_strength(lights, k, p)
        if s <= 0.0:
            continue
        chosen = k
        prob = FLOOR / on + (1.0 - FLOOR) * s / total
        sum_before += prob
        if u < sum_before:
            break
    return chosen, prob


@kernel
def selection_probability(lights: Row, p: Vector, entry: int) -> float:
    """Probability that ``select_light`` draws ``entry`` at ``p``."""
    if len(lights.strength) > FEW:
        return probability(lights.photon_cdf, entry)
    s = local_strength(lights, entry, p)
    if s <= 0.0:
        return 0.0
    total, on = _totals(lights, p)
    return FLOOR / on + (1.0 - FLOOR) * s / total
