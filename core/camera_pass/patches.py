"""Patches: gather rays that end near each other share one estimate of the irradiance.

Christensen 1999 asks the photon map once for each photon and lets final-gather rays take the
nearest answer. Here the places are those of a grid in the plane of the surface, so that they
have nothing to do with where photons lie, and an answer hangs on the place alone: whichever
ray, chunk or thread asks first, it is the same to the last bit, and may be worked out twice.

A border that runs through a patch as one straight line makes two halves of it, each with a
place and an answer of its own; more lines make smaller patches of it.
"""

from __future__ import annotations

import math
import threading

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import albedo_nonspecular, is_lambertian
from ..geometry.vector import Vector, add, basis, dot, scale, store, subtract, times, vector
from ..jit import Row, Table, kernel
from ..photons.coverage import ONE_LINE, line_near, look_around
from ..photons.gather import gather_irradiance
from ..sampling.rng import mix
from ..sampling.warps import INV_PI
from .estimate import add_estimate
from .seen import add as add_light

#: Edges of patches, in radii of the disc about their middle: the usual one, and that of those
#: that a patch is parted into.
EDGE, SMALL_EDGE = 0.5, 0.125
#: Patches of one plane are at most this far apart in height, in radii.
_STEP = 1e-3
#: Normals are rounded to multiples of 1 / this: faces of one plane share theirs.
_FINE = float(1 << 20)

#: What ``cut`` tells of a patch: shared as it is, in halves, or not at all.
WHOLE, HALVES, APART = 0, 1, 2
#: ``key``: hash of place and map; ``whole`` and ``inner``: irradiance [W/m^2] by the disc and
#: by half its area, both divided by what of it lies on surfaces. If in halves, ``whole`` is the
#: normal of the line between them, which is ``inner[0]`` [m] away from the middle along that.
PATCH = np.dtype(
    [("key", "u8"), ("cut", "i8"), ("whole", "f8", 3), ("inner", "f8", 3)], align=True
)
#: Patches that a thread remembers (a power of two): 2.1 MB.
REMEMBERED = 1 << 15


class _Rooms(threading.local):
    """A table of patches for each thread."""

    def __init__(self) -> None:
        self.table = np.zeros(REMEMBERED, PATCH)


_ROOMS = _Rooms()


def own_patches() -> NDArray[np.void]:
    """This thread's table (REMEMBERED,) ``PATCH``; maps tell theirs by their salt."""
    return _ROOMS.table


@kernel
def place_of(
    p: Vector, ng: Vector, radius: float, outside: bool, salt: int, edge: float
) -> tuple[np.uint64, Vector, Vector]:
    """Key, middle and normal of the patch of ``edge`` [radii] that ``p`` lies in."""
    x = int(math.floor(ng[0] * _FINE + 0.5))
    y = int(math.floor(ng[1] * _FINE + 0.5))
    z = int(math.floor(ng[2] * _FINE + 0.5))
    n = (x / _FINE, y / _FINE, z / _FINE)
    t, s = basis(n)
    small = edge < EDGE
    edge *= radius
    step = _STEP * radius
    a = int(math.floor(dot(p, t) / edge))
    b = int(math.floor(dot(p, s) / edge))
    c = int(math.floor(dot(p, n) / step + 0.5))
    key = np.uint64(4 * salt + (2 if small else 0) + (1 if outside else 0))
    for low, high in ((x, y), (z, c), (a, b)):
        key = mix(key ^ np.uint64(low) ^ (np.uint64(high) << np.uint64(32)))
    middle = add(
        add(scale(t, (a + 0.5) * edge), scale(s, (b + 0.5) * edge)), scale(n, c * step)
    )
    return key, middle, n


@kernel
def fill(
    patch: Row,
    key: np.uint64,
    p: Vector,
    ng: Vector,
    outside: bool,
    photon_map: Row,
    borders: Row,
    radius: float,
    sight: Table,
    edge: float,
) -> None:
    """Work out what is known of a patch about its middle ``p``.

    A border between ``p`` and a place of the patch comes as near as half the diagonal.
    """
    lines, normal, away = line_near(borders, p, outside, radius, edge * math.sqrt(0.5), ng)
    if lines == 0:
        answer(patch, key, p, ng, outside, photon_map, borders, radius, sight)
        return
    patch.key = key
    patch.cut = HALVES if lines == 1 else APART
    store(patch.whole, normal)
    patch.inner[0] = away * radius


@kernel
def answer(
    patch: Row,
    key: np.uint64,
    p: Vector,
    ng: Vector,
    outside: bool,
    photon_map: Row,
    borders: Row,
    radius: float,
    sight: Table,
) -> None:
    """Let ``patch`` be the irradiance at ``p``."""
    _, share, half = look_around(borders, p, ng, outside, radius, sight)
    whole, inner, _ = gather_irradiance(photon_map, p, ng, radius, sight)
    patch.key = key
    patch.cut = WHOLE
    store(patch.whole, scale(whole, 1.0 / share))
    store(patch.inner, scale(inner, 1.0 / half))


@kernel
def middle_of_half(
    middle: Vector, n: Vector, normal: Vector, away: float, beyond: bool, edge: float
) -> tuple[bool, Vector]:
    """Where the half of a patch that lies ``beyond`` a line, or the other, has its answer.

    That is on the line's ``normal`` through the ``middle``. A corner that is cut off has none
    (False): what stood for it would lie beside the patch. ``edge``, ``away`` [m].
    """
    t, s = basis(n)
    out = 0.5 * edge / max(abs(dot(normal, t)), abs(dot(normal, s)))
    at = 0.5 * (away + (out if beyond else -out))
    return abs(away) < out, add(middle, scale(normal, at))


@kernel
def patch_at(
    p: Vector,
    ng: Vector,
    outside: bool,
    photon_map: Row,
    borders: Row,
    radius: float,
    sight: Table,
    patches: Table,
    salt: int,
    edge: float,
) -> tuple[int, np.int64]:
    """``WHOLE`` and the row of ``patches`` with the answer for ``p``, or why there is none.

    ``HALVES``: ``p`` is very near to the line between two, or in a corner that it cuts off.
    """
    key, middle, n = place_of(p, ng, radius, outside, salt, edge)
    last = np.uint64(len(patches) - 1)
    row = np.int64(key & last)
    patch = patches[row]
    if patch.key != key:
        fill(patch, key, middle, n, outside, photon_map, borders, radius, sight, edge)
    if patch.cut != HALVES:
        return patch.cut, row
    normal, away = vector(patch.whole), patch.inner[0]
    beyond = dot(subtract(p, middle), normal) - away
    there, q = middle_of_half(middle, n, normal, away, beyond > 0.0, edge * radius)
    if not there or abs(beyond) < 2.0 * ONE_LINE * radius:
        return HALVES, row
    key = mix(key ^ np.uint64(1 if beyond > 0.0 else 2))
    row = np.int64(key & last)
    if patches[row].key != key:
        answer(patches[row], key, q, n, outside, photon_map, borders, radius, sight)
    return WHOLE, row


@kernel
def add_shared(
    layer: Table,
    sample: Row,
    vertex: Row,
    lobes: Table,
    photon_map: Row,
    borders: Row,
    radius: float,
    sight: Table,
    patches: Table,
    salt: int,
) -> None:
    """As ``add_estimate``, by the patch that ``vertex`` lies in where it has one.

    It has none where several borders run through even a small one, nor very near to a border,
    nor where light is not scattered alike to all sides.
    """
    if is_lambertian(vertex, lobes):
        p, ng = vector(vertex.p), vector(vertex.ng)
        outside = vertex.entering != 0
        cut, row = patch_at(
            p, ng, outside, photon_map, borders, radius, sight, patches, salt, EDGE
        )
        if cut == APART:
            cut, row = patch_at(
                p, ng, outside, photon_map, borders, radius, sight, patches, salt, SMALL_EDGE
            )
        if cut == WHOLE:
            patch = patches[row]
            a = scale(albedo_nonspecular(vertex, lobes), INV_PI)
            whole, inner = vector(patch.whole), vector(patch.inner)
            add_light(layer, vertex.beta, times(a, whole), 1.0)
            add_light(sample.shrink, vertex.beta, times(a, subtract(whole, inner)), 1.0)
            return
    add_estimate(layer, sample, vertex, lobes, photon_map, borders, radius, sight)
