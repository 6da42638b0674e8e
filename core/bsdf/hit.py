"""Where a ray met a surface, and what the surface is like there."""

from __future__ import annotations

import numpy as np

from ..geometry.interaction import interact
from ..geometry.media import ior_around
from ..geometry.vector import dot, read, scale, store, subtract, vector
from ..jit import Row, Table, kernel
from ..textures.normals import shading_normal
from .resolve import resolve

#: A hit. ``row``: material; ``u`` and ``v``: barycentrics; ``way`` from the ray's start [m];
#: ``own`` tells that the lobes were worked out for this hit. The rest as in ``interact``.
HIT = np.dtype(
    [
        ("face", "i4"),
        ("row", "i4"),
        ("entering", "i4"),
        ("own", "i4"),
        ("u", "f8"),
        ("v", "f8"),
        ("way", "f8"),
        ("offset", "f8"),
        ("p", "f8", 3),
        ("ng", "f8", 3),
        ("ns", "f8", 3),
        ("wo", "f8", 3),
    ],
    align=True,
)


@kernel
def meet(
    hit: Row, mesh: Row, face: int, u: float, v: float, origins: Table, k: int, path: Row
) -> None:
    """Fill ``hit``: ray ``k`` of ``path`` meets ``face`` at the barycentrics ``u``, ``v``."""
    d = vector(path.direction)
    wo = scale(d, -1.0)
    p, ng, ns, entering, offset = interact(mesh, face, u, v, wo)
    hit.face = face
    hit.row = mesh.material[face]
    hit.entering = entering
    hit.own = 0
    hit.u = u
    hit.v = v
    hit.way = dot(subtract(p, read(origins, k)), d)
    hit.offset = offset
    store(hit.p, p)
    store(hit.ng, ng)
    store(hit.ns, ns)
    store(hit.wo, wo)


@kernel
def shade(
    hit: Row, path: Row, mesh: Row, materials: Table, lobes: Table, shading: Row, spare: int
) -> None:
    """Bend the normal of ``hit`` as the material says, and give ``path`` its lobes.

    Those of a constant material stand in the table already; others are worked out for the
    viewer in ``wo`` and written to the rows of ``lobes`` from ``spare`` on.
    """
    material = materials[hit.row]
    if material.normal_texture >= 0 or material.bump_texture >= 0:
        ns = shading_normal(
            shading, mesh, material, hit.face, hit.u, hit.v, vector(hit.ng), vector(hit.ns),
            vector(hit.wo),
        )  # fmt: skip
        store(hit.ns, ns)
    if material.closure_count == 0:
        path.lobe_start = material.lobe_start
        path.lobe_count = material.lobe_count
        return
    entering = hit.entering != 0
    around = ior_around(materials, path, hit.row, entering)
    hit.own = 1
    path.lobe_start = spare
    path.lobe_count = resolve(
        material, shading, mesh, hit.face, hit.u, hit.v, vector(hit.ns), vector(hit.wo),
        entering, around, lobes, spare,
    )  # fmt: skip
