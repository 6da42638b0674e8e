"""Maps from the unit square to shapes and directions, each with its density."""

from __future__ import annotations

import math

from ..geometry.vector import Vector
from ..jit import kernel

INV_PI = 1.0 / math.pi


@kernel
def sample_disk(u: float, v: float) -> tuple[float, float]:
    """Uniform point of the unit disc (concentric map, Shirley & Chiu 1997)."""
    a = 2.0 * u - 1.0
    b = 2.0 * v - 1.0
    if a == 0.0 and b == 0.0:
        return 0.0, 0.0
    if abs(a) > abs(b):
        r = a
        phi = (math.pi / 4.0) * (b / a)
    else:
        r = b
        phi = math.pi / 2.0 - (math.pi / 4.0) * (a / b)
    return r * math.cos(phi), r * math.sin(phi)


@kernel
def square_of_disk(x: float, y: float) -> tuple[float, float]:
    """The point of the unit square that ``sample_disk`` maps to (x, y)."""
    r = math.sqrt(x * x + y * y)
    if r == 0.0:
        return 0.5, 0.5
    if abs(x) > abs(y):
        a = r if x > 0.0 else -r
        b = a * (4.0 / math.pi) * math.atan(y / x)
    else:
        b = r if y > 0.0 else -r
        a = b * (4.0 / math.pi) * math.atan(x / y)
    return min(1.0, max(0.0, 0.5 * (a + 1.0))), min(1.0, max(0.0, 0.5 * (b + 1.0)))


@kernel
def sample_cosine_hemisphere(u: float, v: float) -> Vector:
    """Direction about +z with density cos / pi (Malley's method)."""
    x, y = sample_disk(u, v)
    return x, y, math.sqrt(max(0.0, 1.0 - x * x - y * y))


@kernel
def sample_sphere(u: float, v: float) -> Vector:
    """Direction uniform over the sphere, density 1 / (4 pi)."""
    z = 1.0 - 2.0 * u
    r = math.sqrt(max(0.0, 1.0 - z * z))
    phi = 2.0 * math.pi * v
    return r * math.cos(phi), r * math.sin(phi), z


@kernel
def one_minus_cos(sin_squared: float) -> float:
    """1 - cos of an angle below 90 degrees from sin^2, without cancellation."""
    return sin_squared / (1.0 + math.sqrt(max(0.0, 1.0 - sin_squared)))


@kernel
def sample_cone(versine: float, u: float, v: float) -> Vector:
    """Direction uniform in the cone about +z, ``versine`` = 1 - cos(half angle).

    Its density is ``1 / (2 pi versine)`` per solid angle. Working with 1 - cos keeps
    cones of 1e-8 rad exact.
    """
    h = u * versine
    r = math.sqrt(max(0.0, h * (2.0 - h)))
    phi = 2.0 * math.pi * v
    return r * math.cos(phi), r * math.sin(phi), 1.0 - h


@kernel
def sample_polygon(blades: int, u: float, v: float) -> tuple[float, float]:
    """Uniform point of the regular polygon inscribed in the unit circle, corner at angle 0."""
    u *= blades
    corner = min(int(u), blades - 1)
    u -= corner
    root = math.sqrt(u)
    w = v * root
    step = 2.0 * math.pi / blades
    a = step * corner
    b = a + step
    x = (root - w) * math.cos(a) + w * math.cos(b)
    y = (root - w) * math.sin(a) + w * math.sin(b)
    return x, y


@kernel
def sample_triangle(u: float, v: float) -> tuple[float, float]:
    """Uniform barycentrics (of the second and third corner) of a triangle."""
    root = math.sqrt(u)
    return root * (1.0 - v), root * v
