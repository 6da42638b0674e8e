"""One specular event at a surface, for light and camera paths alike."""

from __future__ import annotations

from typing import Any

from ..geometry.media import ior_around
from ..geometry.vector import Vector, dot
from ..jit import Row, Table, kernel
from .dispatch import sample_specular


@kernel
def scatter_specular(
    materials: Table,
    lobes: Table,
    path: Row,
    row: int,
    ng: Vector,
    ns: Vector,
    entering: bool,
    wo: Vector,
    u_lobe: float,
    u: float,
) -> Any:
    """Draw a specular event of material ``row``: (wi, weight (3,), transmitted, eta).

    The index on the far side comes from the path's media. ``weight`` is zero when nothing
    is scattered. A shading normal that would send the ray to the wrong side of the face
    gives way to the true one.
    """
    around = ior_around(materials, path, row, entering)
    material = materials[row]
    possible, wi, weight, transmitted, eta = sample_specular(
        material, lobes, ns, wo, entering, around, u_lobe, u
    )
    if possible and (dot(wi, ng) < 0.0) != transmitted:
        possible, wi, weight, transmitted, eta = sample_specular(
            material, lobes, ng, wo, entering, around, u_lobe, u
        )
    if not possible:
        return wi, (0.0, 0.0, 0.0), transmitted, eta
    return wi, weight, transmitted, eta
