"""Caustic photons connected with the camera (light tracing).

A camera ray is sent towards each photon, and where it arrives the surface sends the photon's
light back into the film (Arvo 1986; Dutre, Lafortune & Willems 1993). There is no disc, so
nothing is blurred. What the camera sees by a mirror or through glass is not reached.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import WIDE, eval_part, is_twosided
from ..camera.lens import towards
from ..film.film import SAMPLE
from ..geometry.vector import dot, store, subtract, vector
from ..jit import Row, Table, kernel
from ..photons.focus import FOCUSED
from ..photons.gather import facing
from ..photons.trace import Walk
from ..room import ROOM
from ..sampling.rng import CONNECTION, mix, stream, uniform
from .paths import step_paths
from .rays import Rays
from .records import VERTEX
from .start import begin_path

if TYPE_CHECKING:
    from ..prepared import Prepared
    from ..settings import Settings

#: Photons connected at a time; nothing hangs on it.
TOGETHER = 8192
#: A ray arrives where its photon lies, up to this part of the way.
ASIDE = 2e-4

#: A photon that the camera sees: its ``order`` among those of the pass, its place on the film
#: [pixels of the whole image], its light there [radiance times pixels].
SEEN = np.dtype([("order", "i8"), ("x", "f8"), ("y", "f8"), ("light", "f4", 3)], align=True)
_UNDER_WAY = np.dtype(
    [("x", "f8"), ("y", "f8"), ("photon", "i8"), ("importance", "f8")], align=True
)


class Connected(NamedTuple):
    """What the camera sees of some photons: (n,) ``SEEN``, by so many ``rays``.

    ``sent`` (m, 2): where on the film those are that a ray was sent to [pixels].
    """

    seen: NDArray[np.void]
    sent: NDArray[np.float64]
    rays: int


def connect(
    prepared: Prepared,
    settings: Settings,
    corner: tuple[int, int],
    wanted: NDArray[np.uint8],
    i: int,
    walk: Walk,
) -> Connected:
    """Connect the photons of ``walk``, of pass ``i``, with the camera.

    Those that fall into the pixels ``wanted`` (h, w), the first of which is ``corner``. What
    crowded places send out (``photons.focus``) is left to its discs.
    """
    own, traced = len(prepared.lobes), 0
    parts, sent = [np.zeros(0, SEEN)], [np.zeros((0, 2))]
    bits = np.ascontiguousarray(walk.photons["position"]).view(np.uint32)
    for start in range(0, len(walk.photons), TOGETHER):
        room = min(TOGETHER, len(walk.photons) - start)
        rays = Rays(prepared, room)
        under_way = ROOM.take("connections", room, _UNDER_WAY)
        count = start_connections(
            prepared.camera, prepared.camera_media, corner, wanted, settings.seed, i,
            walk.photons, bits, start, room, rays.origins, rays.directions, rays.paths,
            under_way,
        )  # fmt: skip
        sent.append(np.stack([under_way["x"][:count], under_way["y"][:count]], axis=1))
        # What the rays see on their way is not asked for.
        samples = ROOM.take("unseen", count, SAMPLE)
        while count:
            traced += count
            hits = prepared.intersector.nearest(rays.origins[:count], rays.directions[:count])
            vertices = ROOM.take("ends", count, VERTEX)
            count, lit, _ = step_paths(
                prepared.mesh, prepared.materials, rays.lobes, prepared.shading,
                prepared.lights, prepared.camera, False, settings.transparent, 1,
                settings.min_throughput, own, hits.face, hits.u, hits.v, rays.hits, count,
                rays.origins, rays.directions, rays.paths, vertices, samples,
            )  # fmt: skip
            seen = np.zeros(lit, SEEN)
            found = arrive(
                prepared.camera, rays.lobes, walk.photons, walk.order, vertices, lit,
                under_way, seen,
            )  # fmt: skip
            parts.append(seen[:found])
    return Connected(np.concatenate(parts), np.concatenate(sent), traced)


@kernel
def start_connections(
    camera: Row,
    camera_media: Table,
    corner: tuple[int, int],
    wanted: Table,
    seed: int,
    i: int,
    photons: Table,
    bits: Table,
    start: int,
    room: int,
    origins: Table,
    directions: Table,
    paths: Table,
    under_way: Table,
) -> int:
    """Camera rays to those of ``room`` photons, ``start`` and on, that may fall into the film.

    ``wanted`` (h, w): 1 where they may, by the filter too; beside it the next pixel counts.

    Random numbers hang on the pass and on where a photon lies, ``bits`` (n, 3), so that baked
    photons draw what traced ones do. Returns how many rays there are.
    """
    count = 0
    aside = camera.filter_table[0, -1]
    height, width = wanted.shape
    low_x, low_y = corner[0] - aside, corner[1] - aside
    high_x, high_y = corner[0] + width + aside, corner[1] + height + aside
    for k in range(start, start + room):
        photon = photons[k]
        if photon.part == FOCUSED:
            continue
        # Of the lights that a group leaves out, photons are dark.
        if not photon.flux[0] + photon.flux[1] + photon.flux[2] > 0.0:
            continue
        place = np.uint64(bits[k, 0]) ^ (np.uint64(bits[k, 1]) << np.uint64(32))
        place = mix(mix(place) ^ np.uint64(bits[k, 2]))
        key = mix(stream(seed, CONNECTION, i, 0) ^ place)
        x, y, o, d, before, reach, importance = towards(
            camera, vector(photon.position), uniform(key, 0), uniform(key, 1)
        )
        if not importance > 0.0:
            continue
        if x <= low_x or y <= low_y or x >= high_x or y >= high_y:
            continue
        column = min(max(int(math.floor(x)) - corner[0], 0), width - 1)
        line = min(max(int(math.floor(y)) - corner[1], 0), height - 1)
        if wanted[line, column] == 0:
            continue
        row = under_way[count]
        row.x = x
        row.y = y
        row.photon = k
        row.importance = importance
        path = paths[count]
        path.key = key
        path.pixel_key = key
        path.slot = count
        path.number = i
        begin_path(path, camera_media, o, d, before, reach)
        store(origins[count], o)
        store(directions[count], d)
        count += 1
    return count


@kernel
def arrive(
    camera: Row,
    lobes: Table,
    photons: Table,
    order: Table,
    vertices: Table,
    count: int,
    under_way: Table,
    seen: Table,
) -> int:
    """Write the photons at which rays have arrived, ``vertices``, to ``seen``; how many."""
    found = 0
    for k in range(count):
        vertex = vertices[k]
        if vertex.part != WIDE:
            continue
        row = under_way[vertex.slot]
        photon = photons[row.photon]
        p, ng, wo = vector(vertex.p), vector(vertex.ng), vector(vertex.wo)
        gap = subtract(vector(photon.position), p)
        limit = ASIDE * vertex.length
        if dot(gap, gap) > limit * limit:
            continue
        if facing(photon, ng, is_twosided(vertex, lobes)) == 0.0:
            continue
        f = eval_part(
            vertex, lobes, vector(vertex.ns), wo, vector(photon.direction), photon.part
        )
        length = 1.0 if camera.orthographic else vertex.length
        factor = row.importance * abs(dot(ng, wo)) / (length * length)
        out = seen[found]
        out.order = order[row.photon]
        out.x = row.x
        out.y = row.y
        for c in range(3):
            out.light[c] = factor * vertex.beta[c] * f[c] * photon.flux[c]
        found += 1
    return found
