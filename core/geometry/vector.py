"""Small vectors as tuples of three floats: they live in registers inside kernels."""

from __future__ import annotations

import math

from ..jit import Table, kernel

Vector = tuple[float, float, float]


@kernel
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@kernel
def add(a: Vector, b: Vector) -> Vector:
    """Sum."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def subtract(a: Vector, b: Vector) -> Vector:
    """Difference a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def scale(a: Vector, s: float) -> Vector:
    """Vector times number."""
    return (a[0] * s, a[1] * s, a[2] * s)


@kernel
def times(a: Vector, b: Vector) -> Vector:
    """Product per channel."""
    return a[0] * b[0], a[1] * b[1], a[2] * b[2]


@kernel
def along(p: Vector, d: Vector, t: float) -> Vector:
    """Point p + t d."""
    return (p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2])


@kernel
def normalize(a: Vector) -> Vector:
    """Unit vector; the zero vector stays zero."""
    length = math.sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2])
    if length == 0.0:
        return (0.0, 0.0, 0.0)
    return (a[0] / length, a[1] / length, a[2] / length)


@kernel
def read(array: Table, i: int) -> Vector:
    """Row ``i`` of an (N, 3) array, in float64."""
    return (float(array[i, 0]), float(array[i, 1]), float(array[i, 2]))


@kernel
def vector(row: Table) -> Vector:
    """A (3,) array as a tuple, in float64."""
    # Inside a kernel float() of a float32 stays one.
    return (1.0 * row[0], 1.0 * row[1], 1.0 * row[2])


@kernel
def store(row: Table, a: Vector) -> None:
    """Write a tuple into a (3,) array."""
    row[0] = a[0]
    row[1] = a[1]
    row[2] = a[2]


@kernel
def basis(n: Vector) -> tuple[Vector, Vector]:
    """Two unit tangents that make a right-handed frame with unit ``n``.

    Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
    """
    sign = 1.0 if n[2] >= 0.0 else -1.0
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    t = (1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0])
    s = (b, sign + n[1] * n[1] * a, -n[1])
    return t, s


@kernel
def to_world(local: Vector, n: Vector) -> Vector:
    """A direction given in the frame whose z is unit ``n``."""
    t, s = basis(n)
    return (
        local[0] * t[0] + local[1] * s[0] + local[2] * n[0],
        local[0] * t[1] + local[1] * s[1] + local[2] * n[1],
        local[0] * t[2] + local[1] * s[2] + local[2] * n[2],
    )
