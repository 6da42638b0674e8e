"""Ray optics in closed form, apart from the engine: Fresnel, Snell, and where rays land."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def reflectance(cos_i: Array | float, eta: float) -> Array:
    """Unpolarised Fresnel reflectance, ``eta`` = n_transmitted / n_incident."""
    c = np.asarray(cos_i, float)
    inside = 1 - (1 - c * c) / eta**2
    t = np.sqrt(np.maximum(inside, 0.0))
    s, p = (c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t)
    return np.where(inside > 0, (s * s + p * p) / 2, 1.0)


def meet_sphere(o: Array, d: Array, centre: float, radius: float, first: bool) -> Array:
    """Hits (N, 2) of rays in the plane (x, z) with the circle about (0, ``centre``)."""
    gap = o - np.array([0.0, centre])
    b = (gap * d).sum(axis=1)
    root = np.sqrt(np.maximum(b * b - (gap * gap).sum(axis=1) + radius**2, 0.0))
    t = -b - root if first else -b + root
    hit: Array = o + t[:, None] * d
    return hit


def refract(d: Array, n: Array, eta: float) -> tuple[Array, Array]:
    """Snell: unit directions (N, 2) after the surface and the share that passes (N,)."""
    c = -(d * n).sum(axis=1)
    n = np.where(c[:, None] < 0, -n, n)
    c = np.abs(c)
    t = np.sqrt(np.maximum(1 - (1 - c * c) / eta**2, 0.0))
    out = d / eta + (c / eta - t)[:, None] * n
    return out, 1 - reflectance(c, eta)


def through_lens(
    heights: Array, ior: float, top: tuple[float, float], bottom: tuple[float, float],
    floor: float,
) -> tuple[Array, Array]:  # fmt: skip
    """Rays that fall along -z at ``heights`` off the axis: (radius on the floor, share).

    ``top`` and ``bottom``: (centre on the axis, radius) of the spherical faces; the lens
    lies in both balls. No internal reflections.
    """
    far = np.full_like(heights, 1e3)
    o = np.stack([heights, far], axis=1)
    d = np.broadcast_to(np.array([0.0, -1.0]), o.shape)
    share = np.ones_like(heights)
    for (centre, radius), first, eta in ((top, True, ior), (bottom, False, 1 / ior)):
        o = meet_sphere(o, d, centre, radius, first)
        n = (o - np.array([0.0, centre])) / radius
        d, passed = refract(d, n, eta)
        share = share * passed
    return o[:, 0] + d[:, 0] * (o[:, 1] - floor) / -d[:, 1], share


def through_ball(
    heights: Array, ior: float, centre: float, radius: float, inner: int
) -> tuple[Array, Array]:
    """Rays along -z through a ball after ``inner`` reflections inside: as ``through_lens``.

    The floor is z = 0; rays that leave upwards have no share.
    """
    o = np.stack([heights, np.full_like(heights, 1e3)], axis=1)
    d = np.broadcast_to(np.array([0.0, -1.0]), o.shape)
    middle = np.array([0.0, centre])
    o = meet_sphere(o, d, centre, radius, True)
    d, share = refract(d, (o - middle) / radius, ior)
    for k in range(inner + 1):
        o = meet_sphere(o, d, centre, radius, False)
        n = (o - middle) / radius
        out, passed = refract(d, n, 1 / ior)
        share = share * (passed if k == inner else 1 - passed)
        d = out if k == inner else d - 2 * (d * n).sum(axis=1)[:, None] * n
    falls = d[:, 1] < -1e-9
    landed = o[:, 0] + d[:, 0] * o[:, 1] / np.where(falls, -d[:, 1], 1.0)
    return np.where(falls, landed, 1e9), np.where(falls, share, 0.0)


def radial_irradiance(heights: Array, landed: Array, share: Array, edges: Array) -> Array:
    """Irradiance in rings between ``edges`` of a beam of 1 W/m^2, rays by ``heights``."""
    middle = (heights[1:] + heights[:-1]) / 2
    power = 2 * np.pi * middle * np.diff(heights)
    at = (np.abs(landed[1:]) + np.abs(landed[:-1])) / 2
    share = (share[1:] + share[:-1]) / 2
    rings = np.histogram(at, edges, weights=power * share)[0]
    irradiance: Array = rings / (np.pi * np.diff(edges**2))
    return irradiance


def pixel_means(
    x: Array, y: Array, width: float, edges: Array, values: Array, order: int = 12
) -> Array:
    """Means over square pixels of side ``width`` about (x, y) of ``values`` by radius."""
    steps = (np.arange(order) + 0.5) / order - 0.5
    total = np.zeros(np.broadcast(x, y).shape)
    for i in steps:
        for j in steps:
            r = np.hypot(x + i * width, y + j * width)
            k = np.clip(np.searchsorted(edges, r) - 1, 0, len(values) - 1)
            total += np.where(r < edges[-1], values[k], 0.0)
    return total / order**2


def nephroid(
    radius: float, elevation: float, height: float, edges: Array, count: int = 3000
) -> Array:
    """Irradiance (n, n) on a grid of ``edges``: sun of 1 W/m^2 into a half cylinder.

    The sun's rays fly along +x and down by ``elevation``; the mirror is x > 0 of the
    cylinder x^2 + y^2 = radius^2 up to ``height``. Seen from above a ray that meets it at
    the angle phi goes on at 2 phi from it; its caustic is s = radius cos(phi) / 2 from the
    wall. Quadrature over the wall's angle and height, with all its reflections.
    """
    phi = (np.arange(count) + 0.5) / count * np.pi - np.pi / 2
    z = (np.arange(count) + 0.5) / count * height
    weight = np.cos(elevation) * np.cos(phi) * radius * (np.pi / count) * (height / count)
    image = np.zeros((len(edges) - 1,) * 2)
    for rows in np.array_split(np.arange(count), 20):
        a, left = (
            m.ravel() for m in np.meshgrid(phi[rows], z / np.tan(elevation), indexing="ij")
        )
        w = np.repeat(weight[rows], count)
        x, y = radius * np.cos(a), radius * np.sin(a)
        dx, dy = -np.cos(2 * a), -np.sin(2 * a)
        for _ in range(30):
            # The next meeting with the circle, if it is on the mirror and before the floor.
            chord = -2 * (x * dx + y * dy)
            again = (left > chord) & (x + chord * dx > 0)
            land = ~again
            image += np.histogram2d(
                y[land] + left[land] * dy[land], x[land] + left[land] * dx[land],
                (edges, edges), weights=w[land],
            )[0]  # fmt: skip
            if not again.any():
                break
            x, y, left, w = x[again], y[again], left[again], w[again]
            dx, dy, chord = dx[again], dy[again], chord[again]
            x, y, left = x + chord * dx, y + chord * dy, left - chord
            dot = 2 * (x * dx + y * dy) / radius**2
            dx, dy = dx - dot * x, dy - dot * y
    area = np.diff(edges)
    return image / (area[:, None] * area[None, :])
