"""Patches: gather rays that end near each other share one estimate of the irradiance.

Christensen 1999 asks the photon map once for each photon and lets final-gather rays take the
nearest answer. Here the places are those of a grid in the plane of the surface, so that they
have nothing to do with where photons lie, and an answer hangs on the place alone: whichever
ray, chunk or thread asks first, it is the same to the last bit, and may be worked out twice.
All threads share the table of a photon map, without locks: an answer that one of them is
just writing does not fit its key (Hyatt & Mann 2002, "A lock-less transposition table").

A border that runs through a patch as one straight line makes two halves of it, each with a
place and an answer of its own; more lines make smaller patches of it.
"""

from __future__ import annotations

import math
from typing import Any

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

#: Odd numbers for ``hash_of``, one for each part: multiples of 2^64 / the golden ratio.
_ODD = tuple(np.uint64(0x9E3779B97F4A7C15 * k % 2**64) for k in range(1, 15, 2))

#: What ``cut`` tells of a patch: shared as it is, in halves, or not at all.
WHOLE, HALVES, APART = 0, 1, 2
#: ``seal``: hash of the place and of what follows it. ``whole`` and ``inner``: irradiance
#: [W/m^2] by the disc and by half its area, both divided by what of it lies on surfaces. If in
#: halves, ``whole`` is the normal of the line between them, and ``inner[0]`` its distance from
#: the middle along that [m].
PATCH = np.dtype(
    [("seal", "u8"), ("cut", "i8"), ("whole", "f8", 3), ("inner", "f8", 3)], align=True
)
#: Patches that a photon map remembers (a power of two): 2.1 MB.
REMEMBERED = 1 << 15
#: Rows that a patch may be in, the next ones by the lowest bits of its key.
WAYS = 4


def no_patches() -> NDArray[np.void]:
    """A table (REMEMBERED,) ``PATCH`` for a photon map of which none is known yet."""
    return np.zeros(REMEMBERED, PATCH)


@kernel
def _spread(x: np.uint64, factor: np.uint64) -> np.uint64:
    return (x ^ (x >> np.uint64(32))) * factor


@kernel
def _bits(x: Any) -> np.uint64:
    bits: np.uint64 = x.view(np.uint64)
    return bits


@kernel
def hash_of(cut: np.int64, whole: Vector, inner: Vector) -> np.uint64:
    """Of all bits of an answer, so that no part of it goes with one of another."""
    x = _spread(np.uint64(cut), _ODD[0])
    x += _spread(_bits(whole[0]), _ODD[1])
    x += _spread(_bits(whole[1]), _ODD[2])
    x += _spread(_bits(whole[2]), _ODD[3])
    x += _spread(_bits(inner[0]), _ODD[4])
    x += _spread(_bits(inner[1]), _ODD[5])
    return x + _spread(_bits(inner[2]), _ODD[6])


@kernel
def known(patch: Row) -> tuple[np.uint64, np.int64, Vector, Vector]:
    """Key, cut and both vectors; the key is that of no place if another thread writes now."""
    cut, whole, inner = patch.cut, vector(patch.whole), vector(patch.inner)
    return patch.seal ^ hash_of(cut, whole, inner), cut, whole, inner


@kernel
def remember(patch: Row, key: np.uint64, cut: np.int64, whole: Vector, inner: Vector) -> None:
    """What ``known`` then tells."""
    patch.seal = key ^ hash_of(cut, whole, inner)
    patch.cut = cut
    store(patch.whole, whole)
    store(patch.inner, inner)


@kernel
def place_of(
    p: Vector, ng: Vector, radius: float, outside: bool, edge: float
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
    key = np.uint64((2 if small else 0) + (1 if outside else 0))
    for low, high in ((x, y), (z, c), (a, b)):
        key = mix(key ^ np.uint64(low) ^ (np.uint64(high) << np.uint64(32)))
    middle = add(
        add(scale(t, (a + 0.5) * edge), scale(s, (b + 0.5) * edge)), scale(n, c * step)
    )
    return key, middle, n


@kernel
def row_of(patches: Table, place: np.uint64) -> np.int64:
    """The row that tells of ``place``, or where to ``remember`` it.

    Places share ``WAYS`` rows. With one each, those that meet in it would forget each other.
    """
    last = np.uint64(len(patches) - 1)
    for k in range(WAYS):
        row = np.int64((place ^ np.uint64(k)) & last)
        if patches[row].seal == 0 or known(patches[row])[0] == place:
            return row
    return np.int64((place ^ (place >> np.uint64(62))) & last)


@kernel
def lines_through(
    p: Vector, ng: Vector, outside: bool, borders: Row, radius: float, edge: float
) -> tuple[np.int64, Vector, Vector]:
    """How borders cut the patch with the middle ``p``: what there is to ``remember``.

    A border between ``p`` and a place of the patch comes as near as half the diagonal.
    """
    lines, normal, away = line_near(borders, p, outside, radius, edge * math.sqrt(0.5), ng)
    cut = WHOLE if lines == 0 else HALVES if lines == 1 else APART
    return np.int64(cut), normal, (away * radius, 0.0, 0.0)


@kernel
def answer(
    p: Vector,
    ng: Vector,
    outside: bool,
    photon_map: Row,
    borders: Row,
    radius: float,
    sight: Table,
) -> tuple[Vector, Vector]:
    """The irradiance at ``p``, by the disc and by half its area [W/m^2]."""
    _, share, half = look_around(borders, p, ng, outside, radius, sight)
    whole, inner, _ = gather_irradiance(photon_map, p, ng, radius, sight)
    return scale(whole, 1.0 / share), scale(inner, 1.0 / half)


@kernel
def middle_of_half(
    middle: Vector, n: Vector, normal: Vector, away: float, beyond: bool, edge: float
) -> tuple[bool, Vector]:
    """Where the half of a patch that lies ``beyond`` a line, or the other, has its answer.

    That is on the line's ``normal`` through the ``middle``, and the middle itself where just
    a corner is cut off. The corner has none (False): what stood for it would lie beside the
    patch. ``edge``, ``away`` [m].
    """
    t, s = basis(n)
    out = 0.5 * edge / max(abs(dot(normal, t)), abs(dot(normal, s)))
    if abs(away) >= out:
        return beyond != (away > 0.0), middle
    at = 0.5 * (away + (out if beyond else -out))
    return True, add(middle, scale(normal, at))


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
    edge: float,
) -> tuple[np.int64, Vector, Vector]:
    """``WHOLE`` and the ``answer`` for ``p``, or why it has none.

    ``HALVES``: ``p`` is very near to the line between two, or in a corner that it cuts off.
    """
    place, q, n = place_of(p, ng, radius, outside, edge)
    row = row_of(patches, place)
    key, cut, whole, inner = known(patches[row])
    if key != place:
        cut, whole, inner = lines_through(q, n, outside, borders, radius, edge)
        if cut != WHOLE:
            remember(patches[row], place, cut, whole, inner)
    if cut == APART:
        return cut, whole, inner
    if cut == HALVES:
        away = inner[0]
        beyond = dot(subtract(p, q), whole) - away
        there, q = middle_of_half(q, n, whole, away, beyond > 0.0, edge * radius)
        if not there or abs(beyond) < 2.0 * ONE_LINE * radius:
            return cut, whole, inner
        place = mix(place ^ np.uint64(1 if beyond > 0.0 else 2))
        row = row_of(patches, place)
        key, cut, whole, inner = known(patches[row])
    if key != place:
        cut = np.int64(WHOLE)
        whole, inner = answer(q, n, outside, photon_map, borders, radius, sight)
        remember(patches[row], place, cut, whole, inner)
    return cut, whole, inner


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
) -> None:
    """As ``add_estimate``, by the patch that ``vertex`` lies in where it has one.

    It has none where several borders run through even a small one, nor very near to a border,
    nor where light is not scattered alike to all sides.
    """
    if is_lambertian(vertex, lobes):
        p, ng = vector(vertex.p), vector(vertex.ng)
        outside = vertex.entering != 0
        for edge in (EDGE, SMALL_EDGE):
            cut, whole, inner = patch_at(
                p, ng, outside, photon_map, borders, radius, sight, patches, edge
            )
            if cut != APART:
                break
        if cut == WHOLE:
            a = scale(albedo_nonspecular(vertex, lobes), INV_PI)
            add_light(layer, vertex.beta, times(a, whole), 1.0)
            add_light(sample.shrink, vertex.beta, times(a, subtract(whole, inner)), 1.0)
            return
    add_estimate(layer, sample, vertex, lobes, photon_map, borders, radius, sight)
