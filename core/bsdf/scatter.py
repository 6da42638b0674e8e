"""One event at a surface, for light and camera paths alike."""

from __future__ import annotations

from typing import Any

from ..geometry.media import cross_surface, ior_around, is_hidden
from ..geometry.vector import dot, vector
from ..jit import Row, Table, kernel
from .dispatch import pass_weight, sample_part
from .lobe import is_delta, narrow_share


@kernel
def has_rough_narrow(surface: Row, lobes: Table) -> bool:
    """Whether a part of a lobe is narrow without being a Dirac delta."""
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        if not is_delta(lobes[k]) and narrow_share(lobes[k]) > 0.0:
            return True
    return False


@kernel
def goes_through(materials: Table, path: Row, hit: Row, visible: bool) -> bool:
    """Whether the surface is not there for this path: invisible, or inside another medium."""
    if not visible:
        return True
    if is_hidden(materials, path, hit.row, hit.entering != 0):
        cross_surface(path, hit.row, hit.entering != 0)
        return True
    return False


@kernel
def choose_transparency(path: Row, lobes: Table, scattering: float, u: float) -> Any:
    """Go straight through or not, at random: (through, factor (3,)).

    ``scattering``: mean weight of all that is not transparent. The factor divides by the
    probability of what was chosen.
    """
    t = pass_weight(path, lobes)
    passing = (t[0] + t[1] + t[2]) / 3.0
    if passing <= 0.0:
        return False, (1.0, 1.0, 1.0)
    total = passing + scattering
    if u * total < passing:
        k = total / passing
        return True, (t[0] * k, t[1] * k, t[2] * k)
    k = total / scattering
    return False, (k, k, k)


@kernel
def scatter(
    materials: Table,
    lobes: Table,
    path: Row,
    hit: Row,
    part: int,
    u_lobe: float,
    u: float,
    v: float,
) -> Any:
    """Draw an event of one part of a surface: (wi, weight (3,), pdf_w, transmitted, eta).

    ``path`` (or a vertex) carries the lobes; the index on the far side comes from its
    media. ``weight`` is zero when nothing is scattered, ``pdf_w`` is 0 for a delta. A
    shading normal that would send a delta to the wrong side of the face gives way to the
    true one.
    """
    ng = vector(hit.ng)
    wo = vector(hit.wo)
    entering = hit.entering != 0
    around = ior_around(materials, path, hit.row, entering)
    possible, wi, weight, pdf_w, transmitted, eta = sample_part(
        path, lobes, vector(hit.ns), wo, entering, around, part, u_lobe, u, v
    )
    if possible and (dot(wi, ng) < 0.0) != transmitted:
        possible = False
        if pdf_w == 0.0:
            possible, wi, weight, pdf_w, transmitted, eta = sample_part(
                path, lobes, ng, wo, entering, around, part, u_lobe, u, v
            )
    if not possible:
        return wi, (0.0, 0.0, 0.0), pdf_w, transmitted, eta
    return wi, weight, pdf_w, transmitted, eta
