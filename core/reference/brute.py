"""Ray against every triangle in float64 (Möller & Trumbore 1997), group boxes aside."""

from __future__ import annotations

import math
from typing import Any

from ..jit import allocating_kernel as kernel
from .flat import Flat
from .vector import Vec, along, cross, dot, unit, vec

Hit = tuple[float, int, float, float]


@kernel
def _misses_box(s: Flat, g: int, o: Vec, inverse: Vec, far: float) -> bool:
    """Whether the ray passes beside the box of group ``g`` or meets it beyond ``far``."""
    near = 0.0
    for axis in range(3):
        a = (s.groups[g].low[axis] - o[axis]) * inverse[axis]
        b = (s.groups[g].high[axis] - o[axis]) * inverse[axis]
        # NaN (a ray in the box's plane) compares false and leaves the bounds alone.
        low, high = (b, a) if a > b else (a, b)
        if low > near:
            near = low
        if high < far:
            far = high
    return near > far


@kernel
def _triangle(face: Any, o: Vec, d: Vec) -> Vec:
    """(t, b1, b2) of the ray in the triangle; t is -1 for a miss."""
    edge_1, edge_2 = vec(face.edge_1), vec(face.edge_2)
    p = cross(d, edge_2)
    det = dot(edge_1, p)
    if det == 0.0:
        return -1.0, 0.0, 0.0
    from_base = along(o, vec(face.base), -1.0)
    u = dot(from_base, p) / det
    if not 0.0 <= u <= 1.0:
        return -1.0, 0.0, 0.0
    q = cross(from_base, edge_1)
    v = dot(d, q) / det
    if v < 0.0 or u + v > 1.0:
        return -1.0, 0.0, 0.0
    return dot(edge_2, q) / det, u, v


@kernel
def closest(s: Flat, o: Vec, d: Vec, skip: int, far: float) -> Hit:
    """The nearest hit (t, face, b1, b2) before ``far``, not on face ``skip``; face -1: none.

    o: origin; d: unit direction; b1, b2: weights of the face's second and third corner.
    """
    best, face, best_u, best_v = far, -1, 0.0, 0.0
    inverse = (1.0 / d[0], 1.0 / d[1], 1.0 / d[2])
    for g in range(len(s.groups)):
        if _misses_box(s, g, o, inverse, best):
            continue
        for i in range(s.groups[g].start, s.groups[g].stop):
            if i == skip:
                continue
            t, u, v = _triangle(s.faces[i], o, d)
            if s.tiny < t < best:
                best, face, best_u, best_v = t, i, u, v
    return best, face, best_u, best_v


@kernel
def blocked(s: Flat, o: Vec, d: Vec, skip: int, target: int, distance: float) -> bool:
    """Whether a face other than ``skip`` and ``target`` lies within ``distance``."""
    far = distance * (1.0 - 1e-9) if distance < math.inf else distance
    face = closest(s, o, d, skip, far)[1]
    if face >= 0 and face == target:
        # The target itself, found early by rounding, hides nothing.
        return False
    return face >= 0


@kernel
def shading_normal(s: Flat, face: int, u: float, v: float, d: Vec, ng: Vec) -> Vec:
    """The interpolated unit normal on the side of ``ng``, which faces the arriving ``d``.

    It is ``ng`` on flat faces and where the interpolated one faces away from the ray.
    """
    if not s.faces[face].smooth:
        return ng
    w = 1.0 - u - v
    n = s.faces[face].corner_normal
    x = w * n[0] + u * n[3] + v * n[6]
    y = w * n[1] + u * n[4] + v * n[7]
    z = w * n[2] + u * n[5] + v * n[8]
    if x * x + y * y + z * z < 1e-12:
        return ng
    ns = unit((x, y, z))
    if dot(ns, ng) < 0.0:
        ns = (-ns[0], -ns[1], -ns[2])
    if dot(d, ns) >= -1e-6 or dot(ns, ng) <= 0.0:
        return ng
    return ns
