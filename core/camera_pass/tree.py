"""The tree of view rays: a camera path at smooth glass becomes a reflected and a refracted one.

Whitted 1980, as the report had it; without it one of the two is drawn by chance. Here the
first ``Settings.split_depth`` events of a path split. Branches that would carry less than
``Settings.split_least`` are followed by Russian roulette (Arvo and Kirk 1990), and then carry
that. The heavier branch carries what is left, all where there is no other: the branches of a
path always carry together what it did. Where branches of a small portion end they are lit by
another roulette, and gather rays are shared out among all. Off, no kernel of this is compiled
or called.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..bsdf.dispatch import reflected_share
from ..bsdf.hit import meet
from ..geometry.intersector import Hits
from ..geometry.media import ior_around, is_hidden
from ..geometry.vector import vector
from ..jit import Row, Table, kernel
from ..room import ROOM
from ..sampling.rng import mix, uniform
from .records import PATH, REFLECTED, REFRACTED, SPLIT, THIN

if TYPE_CHECKING:
    from ..prepared import Prepared
    from ..settings import Settings
    from .rays import Rays

#: Branches of a smaller portion than this are lit at their ends in that ratio only.
LIT = 0.25
#: Makes other random numbers of a path's for its branch.
_BRANCH = 0x5DEECE66D


def split(
    prepared: Prepared, settings: Settings, rays: Rays, hits: Hits, count: int
) -> tuple[Hits, int]:
    """Split those of ``count`` paths that are about to scatter: their hits and number then."""
    make_room(prepared, rays, 2 * count)
    source = np.arange(2 * count, dtype=np.int32)
    total = split_paths(
        prepared.mesh, prepared.materials, prepared.lobes, prepared.glass,
        settings.split_depth, settings.split_least, hits.face, hits.u, hits.v, rays.hits,
        count, rays.origins, rays.directions, rays.paths, source,
    )  # fmt: skip
    if total == count:
        return hits, count
    own = source[:total]
    return Hits(hits.face[own], hits.u[own], hits.v[own]), total


def make_room(prepared: Prepared, rays: Rays, count: int) -> None:
    """Let there be rows for ``count`` paths; those under way keep theirs."""
    own = len(rays.paths)
    if count <= own:
        return
    rays.origins = ROOM.take("origins", count, "f4", 3, own)
    rays.directions = ROOM.take("directions", count, "f4", 3, own)
    rays.paths = ROOM.take("paths", count, PATH, 0, own)
    rays.lobes = prepared.lobe_room(count)


@kernel
def split_paths(
    mesh: Row,
    materials: Table,
    lobes: Table,
    glass: Table,
    most_depth: int,
    least: float,
    hit_face: Table,
    hit_u: Table,
    hit_v: Table,
    hits: Table,
    count: int,
    origins: Table,
    directions: Table,
    paths: Table,
    source: Table,
) -> int:
    """Append lighter branches behind the ``count`` paths, which become the heavier ones.

    There must be room for as many more. ``source``: of which path each one is a branch.
    ``glass`` (M,): the materials that split. Returns how many paths there are.
    """
    total = count
    hit = hits[0]
    for k in range(count):
        path = paths[k]
        if hit_face[k] < 0 or path.depth >= most_depth:
            continue
        if not glass[mesh.material[hit_face[k]]]:
            continue
        if (mesh.visible[hit_face[k]] & path.event) == 0:
            continue
        meet(hit, mesh, hit_face[k], hit_u[k], hit_v[k], origins, k, path)
        entering = hit.entering != 0
        if is_hidden(materials, path, hit.row, entering):
            continue
        material = materials[hit.row]
        path.lobe_start = material.lobe_start
        path.lobe_count = material.lobe_count
        share = reflected_share(
            path, lobes, vector(hit.ns), vector(hit.ng), vector(hit.wo), entering,
            ior_around(materials, path, hit.row, entering),
        )  # fmt: skip
        if share <= 0.0:
            continue
        light = min(share, 1.0 - share)
        lighter, heavier = (REFLECTED, REFRACTED) if share <= 0.5 else (REFRACTED, REFLECTED)
        path.forced = heavier
        # At least the chance that it has without splitting, so that no portion grows.
        keep = light * max(1.0, max(path.beta[0], path.beta[1], path.beta[2]) / least)
        if keep < 1.0:
            if uniform(path.key, SPLIT + path.steps) >= keep:
                continue
            light /= keep
        if light >= 1.0:
            path.forced = lighter
            continue
        paths[total] = paths[k]
        branch = paths[total]
        branch.forced = lighter
        path.portion *= 1.0 - light
        for c in range(3):
            path.beta[c] *= 1.0 - light
        branch.key = mix(path.key + np.uint64(_BRANCH))
        branch.pixel_key = mix(path.pixel_key + np.uint64(_BRANCH))
        branch.portion *= light
        for c in range(3):
            branch.beta[c] *= light
            origins[total, c] = origins[k, c]
            directions[total, c] = directions[k, c]
        source[total] = k
        total += 1
    return total


@kernel
def thin_out(vertices: Table) -> int:
    """Russian roulette among ends of branches; those left stand first. Their number."""
    left = 0
    for k in range(len(vertices)):
        vertex = vertices[k]
        keep = vertex.portion / LIT
        if keep < 1.0:
            if uniform(vertex.key, THIN) >= keep:
                continue
            vertex.portion = LIT
            for c in range(3):
                vertex.beta[c] /= keep
        if left != k:
            vertices[left] = vertices[k]
        left += 1
    return left
