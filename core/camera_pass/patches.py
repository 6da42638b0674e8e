"""Patches: gather rays that end near each other share one estimate of the irradiance.

Christensen 1999 asks the photon map once for each photon and lets final-gather rays take the
nearest answer. Here the places are those of a grid in the plane of the surface, so that they
have nothing to do with where photons lie, and an answer hangs on the place alone: whichever
ray, chunk or thread asks first, it is the same to the last bit, and may be worked out twice.
"""

from __future__ import annotations

import math
import threading

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import albedo_nonspecular, is_lambertian
from ..geometry.vector import Vector, add, basis, dot, scale, store, subtract, times, vector
from ..jit import Row, Table, kernel
from ..photons.coverage import comes_near, look_around
from ..photons.gather import gather_irradiance
from ..sampling.rng import mix
from ..sampling.warps import INV_PI
from .estimate import add_estimate
from .seen import add as add_light

#: Edge of a patch, in radii of the disc about its middle.
EDGE = 0.5
#: Patches of one plane are at most this far apart in height, in radii.
_STEP = 1e-3
#: Normals are rounded to multiples of 1 / this: faces of one plane share theirs.
_FINE = float(1 << 20)

#: ``key``: hash of place and map; ``cut``: not 0 where a border comes too near to share;
#: ``whole`` and ``inner``: irradiance [W/m^2] by the disc and by half its area, both divided
#: by what of it lies on surfaces.
PATCH = np.dtype(
    [("key", "u8"), ("cut", "i8"), ("whole", "f8", 3), ("inner", "f8", 3)], align=True
)
#: Patches that a thread remembers (a power of two): 1.8 MB.
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
    p: Vector, ng: Vector, radius: float, outside: bool, salt: int
) -> tuple[np.uint64, Vector, Vector]:
    """Key, middle and normal of the patch that ``p`` lies in."""
    x = int(math.floor(ng[0] * _FINE + 0.5))
    y = int(math.floor(ng[1] * _FINE + 0.5))
    z = int(math.floor(ng[2] * _FINE + 0.5))
    n = (x / _FINE, y / _FINE, z / _FINE)
    t, s = basis(n)
    edge = EDGE * radius
    step = _STEP * radius
    a = int(math.floor(dot(p, t) / edge))
    b = int(math.floor(dot(p, s) / edge))
    c = int(math.floor(dot(p, n) / step + 0.5))
    key = np.uint64(2 * salt + (1 if outside else 0))
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
) -> None:
    """Work out the irradiance at the middle ``p`` of a patch.

    A border between ``p`` and a place of the patch comes as near as half the diagonal.
    """
    patch.key = key
    patch.cut = comes_near(borders, p, ng, outside, radius, EDGE * math.sqrt(0.5))
    if patch.cut:
        return
    _, share, half = look_around(borders, p, ng, outside, radius, sight)
    whole, inner, _ = gather_irradiance(photon_map, p, ng, radius, sight)
    store(patch.whole, scale(whole, 1.0 / share))
    store(patch.inner, scale(inner, 1.0 / half))


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

    It has none where a border runs through the patch, nor where light is not scattered alike
    to all sides.
    """
    if is_lambertian(vertex, lobes):
        p, ng = vector(vertex.p), vector(vertex.ng)
        outside = vertex.entering != 0
        key, middle, n = place_of(p, ng, radius, outside, salt)
        patch = patches[np.int64(key & np.uint64(len(patches) - 1))]
        if patch.key != key:
            fill(patch, key, middle, n, outside, photon_map, borders, radius, sight)
        if not patch.cut:
            a = scale(albedo_nonspecular(vertex, lobes), INV_PI)
            whole, inner = vector(patch.whole), vector(patch.inner)
            add_light(layer, vertex.beta, times(a, whole), 1.0)
            add_light(sample.shrink, vertex.beta, times(a, subtract(whole, inner)), 1.0)
            return
    add_estimate(layer, sample, vertex, lobes, photon_map, borders, radius, sight)
