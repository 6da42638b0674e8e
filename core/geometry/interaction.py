"""The hit of a ray, recomputed in float64 from its barycentrics."""

from __future__ import annotations

import math

from ..geometry.vector import (
    Vector,
    along,
    cross,
    dot,
    normalize,
    read,
    scale,
    subtract,
)
from ..jit import Row, kernel

#: Offset against self-hits, relative to the largest coordinate of the triangle.
#: embreex starts rays at t = 0; shares of self-hits measured on a unit triangle:
#: none at 1e-6, 0.05 % at 1e-7.
OFFSET = 1e-6
#: Offsets that a photon keeps away from edges: 1e-6 is 16 steps of float32 only.
_ASIDE = 4.0


@kernel
def interact(
    mesh: Row, face: int, u: float, v: float, wo: Vector
) -> tuple[Vector, Vector, Vector, bool, float]:
    """Point, normals, side and offset of a hit: (p, ng, ns, entering, offset).

    ``ng`` and ``ns`` are unit and turned to the side of ``wo``; ``entering`` tells that
    this is the side the winding calls outside. ``offset`` is the length to start new rays
    at. The point is a mean of the corners, so its error is that of the corners, not of
    the ray's length.
    """
    a = read(mesh.vertices, mesh.faces[face, 0])
    b = read(mesh.vertices, mesh.faces[face, 1])
    c = read(mesh.vertices, mesh.faces[face, 2])
    w = 1.0 - u - v
    p = (
        w * a[0] + u * b[0] + v * c[0],
        w * a[1] + u * b[1] + v * c[1],
        w * a[2] + u * b[2] + v * c[2],
    )
    ng = normalize(cross(subtract(b, a), subtract(c, a)))
    entering = dot(ng, wo) > 0.0
    if not entering:
        ng = scale(ng, -1.0)
    ns = ng
    if mesh.smooth[face]:
        ns = _shading_normal(mesh, face, u, v, ng, wo)
    return p, ng, ns, entering, OFFSET * _largest(a, b, c)


@kernel
def inward(mesh: Row, face: int, u: float, v: float) -> tuple[float, float]:
    """Barycentrics of a hit, at least ``_ASIDE`` offsets away from the face's edges.

    A ray that starts closer to the wall on the other side of an edge may begin behind it.
    """
    a = read(mesh.vertices, mesh.faces[face, 0])
    b = read(mesh.vertices, mesh.faces[face, 1])
    c = read(mesh.vertices, mesh.faces[face, 2])
    area = _length(cross(subtract(b, a), subtract(c, a)))
    if area <= 0.0:
        return u, v
    least = _ASIDE * OFFSET * _largest(a, b, c) / area
    least_w = min(least * _length(subtract(c, b)), 1.0 / 3.0)
    least_u = min(least * _length(subtract(c, a)), 1.0 / 3.0)
    least_v = min(least * _length(subtract(b, a)), 1.0 / 3.0)
    w = max(1.0 - u - v, least_w)
    u, v = max(u, least_u), max(v, least_v)
    total = u + v + w
    return u / total, v / total


@kernel
def _length(a: Vector) -> float:
    return math.sqrt(dot(a, a))


@kernel
def _largest(a: Vector, b: Vector, c: Vector) -> float:
    """Largest absolute coordinate of three points."""
    return max(
        max(abs(a[0]), abs(a[1]), abs(a[2])),
        max(abs(b[0]), abs(b[1]), abs(b[2])),
        max(abs(c[0]), abs(c[1]), abs(c[2])),
    )


@kernel
def _shading_normal(mesh: Row, face: int, u: float, v: float, ng: Vector, wo: Vector) -> Vector:
    """Interpolated normal on the side of ``ng``; ``ng`` itself where ``wo`` lies behind it."""
    n0 = read(mesh.normals[face], 0)
    n1 = read(mesh.normals[face], 1)
    n2 = read(mesh.normals[face], 2)
    w = 1.0 - u - v
    ns = normalize(
        (
            w * n0[0] + u * n1[0] + v * n2[0],
            w * n0[1] + u * n1[1] + v * n2[1],
            w * n0[2] + u * n1[2] + v * n2[2],
        )
    )
    if dot(ns, ng) < 0.0:
        ns = scale(ns, -1.0)
    # At silhouettes of coarse meshes the interpolated normal can face away from the
    # viewer; scattering about it would be black there.
    if dot(ns, wo) <= 1e-6 or dot(ns, ng) <= 0.0:
        return ng
    return ns


@kernel
def leave(p: Vector, ng: Vector, wi: Vector, offset: float) -> Vector:
    """Origin of a ray that leaves ``p`` towards ``wi``: pushed to that side of the face."""
    if dot(ng, wi) >= 0.0:
        return along(p, ng, offset)
    return along(p, ng, -offset)
