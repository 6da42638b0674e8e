"""Shadow rays: all or nothing, or through surfaces that let light pass."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import pass_weight
from ..bsdf.hit import HIT, meet, shade
from ..geometry.interaction import leave
from ..geometry.vector import dot, normalize, store, vector
from ..jit import Row, Table, kernel
from ..prepared import Prepared
from ..scene.tables import Visibility
from .records import PATH

_SHADOW_BIT = int(Visibility.SHADOW)


def free_part(
    prepared: Prepared,
    lobes: NDArray[np.void],
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    lengths: NDArray[np.float32],
) -> tuple[NDArray[np.float64], int]:
    """What part of the light gets through each ray: (N, 3), and the rays traced.

    Rays end at origin + length * direction; all three arrays lose their content. ``lobes``
    has room for one more surface behind the scene's own where a scene has closures.
    """
    count = len(origins)
    if not prepared.has_sieves:
        free = prepared.intersector.is_free(origins, directions, lengths)
        return np.repeat(free[:, None].astype(np.float64), 3, axis=1), count
    part = np.ones((count, 3))
    ids = np.arange(count, dtype=np.int32)
    hits = np.zeros(1, HIT)
    path = np.zeros(1, PATH)
    alive, traced = count, 0
    while alive:
        traced += alive
        found = prepared.intersector.nearest(origins[:alive], directions[:alive])
        alive = step_shadows(
            prepared.mesh, prepared.materials, lobes, prepared.shading, found.face, found.u,
            found.v, len(prepared.lobes), hits, path, alive, ids, origins, directions,
            lengths, part,
        )  # fmt: skip
    return part, traced


@kernel
def step_shadows(
    mesh: Row,
    materials: Table,
    lobes: Table,
    shading: Row,
    hit_face: Table,
    hit_u: Table,
    hit_v: Table,
    spare: int,
    hits: Table,
    paths: Table,
    count: int,
    ids: Table,
    origins: Table,
    directions: Table,
    lengths: Table,
    part: Table,
) -> int:
    """One surface for each shadow ray; returns how many have to go on. Compacts all rows."""
    alive = 0
    hit = hits[0]
    path = paths[0]
    for k in range(count):
        if hit_face[k] < 0:
            continue
        d = vector(directions[k])
        unit = normalize(d)
        store(path.direction, unit)
        meet(hit, mesh, hit_face[k], hit_u[k], hit_v[k], origins, k, path)
        rest = lengths[k] - hit.way / math.sqrt(dot(d, d))
        if rest <= 0.0:
            continue
        ray = ids[k]
        if mesh.visible[hit.face] & _SHADOW_BIT:
            through = (0.0, 0.0, 0.0)
            if materials[hit.row].passes:
                shade(hit, path, mesh, materials, lobes, shading, spare)
                through = pass_weight(path, lobes)
            for c in range(3):
                part[ray, c] *= through[c]
            if not max(through) > 0.0:
                continue
        store(origins[alive], leave(vector(hit.p), vector(hit.ng), unit, hit.offset))
        store(directions[alive], d)
        lengths[alive] = rest
        ids[alive] = ray
        alive += 1
    return alive
