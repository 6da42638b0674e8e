"""A density estimate that becomes light of a pixel, and what tells its bias."""

from __future__ import annotations

from ..geometry.vector import scale, subtract, vector
from ..jit import Row, Table, kernel
from ..photons.coverage import look_around
from ..photons.gather import gather_radiance
from .seen import add


@kernel
def add_estimate(
    layer: Table,
    sample: Row,
    vertex: Row,
    lobes: Table,
    photon_map: Row,
    borders: Row,
    radius: float,
    sight: Table,
) -> None:
    """Add the light that photons within ``radius`` of ``vertex`` bring to ``layer``.

    Each estimate is divided by the share of its disc within ``borders``. What it would
    lose with half the area goes to ``sample.shrink``. ``sight`` (SIGHT,) is overwritten.
    """
    p = vector(vertex.p)
    ng = vector(vertex.ng)
    outside = vertex.entering != 0
    _, share, half = look_around(borders, p, ng, outside, radius, sight)
    radiance, inner, found = gather_radiance(
        photon_map, p, ng, vector(vertex.ns), vector(vertex.wo), radius, vertex, lobes, sight
    )
    if found == 0:
        return
    radiance = scale(radiance, 1.0 / share)
    inner = scale(inner, 1.0 / half)
    add(layer, vertex.beta, radiance, 1.0)
    add(sample.shrink, vertex.beta, subtract(radiance, inner), 1.0)
