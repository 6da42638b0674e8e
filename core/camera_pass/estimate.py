"""A density estimate that becomes light of a pixel, and what tells its bias."""

from __future__ import annotations

import math

from ..geometry.vector import scale, subtract, vector
from ..jit import Row, Table, kernel
from ..photons.coverage import coverage
from ..photons.gather import gather_radiance
from .seen import add

_HALF_AREA = 1.0 / math.sqrt(2.0)


@kernel
def add_estimate(
    layer: Table,
    sample: Row,
    vertex: Row,
    lobes: Table,
    photon_map: Row,
    borders: Row,
    radius: float,
) -> None:
    """Add the light that photons within ``radius`` of ``vertex`` bring to ``layer``.

    Each estimate is divided by the share of its disc within ``borders``. What it would
    lose with half the area goes to ``sample.shrink``.
    """
    p = vector(vertex.p)
    ng = vector(vertex.ng)
    radiance, inner, found = gather_radiance(
        photon_map, p, ng, vector(vertex.ns), vector(vertex.wo), radius, vertex, lobes
    )
    if found == 0:
        return
    outside = vertex.entering != 0
    share = coverage(borders, p, ng, outside, radius)
    if share < 1.0:
        radiance = scale(radiance, 1.0 / share)
        share = coverage(borders, p, ng, outside, _HALF_AREA * radius)
        inner = scale(inner, 1.0 / share)
    add(layer, vertex.beta, radiance, 1.0)
    add(sample.shrink, vertex.beta, subtract(radiance, inner), 1.0)
