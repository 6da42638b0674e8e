"""Meshes and placements of the benchmark's scenes; lengths in metres, z upwards."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photon_map.core import SceneBuilder
from photon_map.core.scene.lobes import diffuse
from tests.scenes import Mesh, box, camera, look_at, quad, sphere

__all__ = ["Mesh", "box", "camera", "look_at", "quad", "sphere"]

SIZE = 128
WHITE = (0.73, 0.73, 0.73)
RED = (0.6, 0.05, 0.04)
GREEN = (0.1, 0.42, 0.08)
BLUE = (0.1, 0.2, 0.78)
#: Between a lamp and what is behind it, or a thing and what it stands on.
GAP = 0.001


def lathe(profile: Sequence[tuple[float, float]], around: int, centre: ArrayLike) -> Mesh:
    """A profile of (radius, height) turned about a vertical axis through ``centre``.

    Normals point to the left of the profile's way: outwards when it runs downwards.
    """
    angle = 2 * np.pi * np.arange(around) / around
    rings = [(r * np.cos(angle), r * np.sin(angle), np.full(around, z)) for r, z in profile]
    points = np.stack([np.stack(ring, axis=1) for ring in rings]).reshape(-1, 3)
    k, j = np.meshgrid(np.arange(len(profile) - 1), np.arange(around), indexing="ij")
    a, b = k * around + j, k * around + (j + 1) % around
    c, d = a + around, b + around
    first, second = np.stack([a, c, d], axis=-1), np.stack([a, d, b], axis=-1)
    faces = np.concatenate([first.reshape(-1, 3), second.reshape(-1, 3)])
    corners = points[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return points + np.asarray(centre, float), faces[np.linalg.norm(cross, axis=1) > 1e-14]


def height_field(
    low: tuple[float, float], high: tuple[float, float], steps: int, height: Callable[..., Any]
) -> Mesh:
    """A grid of 2 * steps^2 triangles at z = height(x, y), normals upwards."""
    x, y = np.meshgrid(
        np.linspace(low[0], high[0], steps + 1), np.linspace(low[1], high[1], steps + 1)
    )
    points = np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(steps), np.arange(steps), indexing="ij")
    a = (i * (steps + 1) + j).ravel()
    b, c, d = a + 1, a + steps + 1, a + steps + 2
    return points, np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)])


def vertex_normals(mesh: Mesh) -> NDArray[np.float32]:
    """Smooth corner normals (F, 3, 3): means of the faces around, by area."""
    points, faces = mesh
    corners = points[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(points)
    for k in range(3):
        np.add.at(total, faces[:, k], cross)
    total /= np.linalg.norm(total, axis=1, keepdims=True)
    return total[faces].astype(np.float32)


def add_room(
    builder: SceneBuilder,
    low: ArrayLike,
    high: ArrayLike,
    walls: dict[str, int],
) -> None:
    """Walls of a room by name, seen from inside; those not named stay open.

    Names: floor, ceiling, left (-x), right (+x), front (-y), back (+y).
    """
    (x0, y0, z0), (x1, y1, z1) = np.asarray(low, float), np.asarray(high, float)
    corners = {
        "floor": [(x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)],
        "ceiling": [(x0, y0, z1), (x0, y1, z1), (x1, y1, z1), (x1, y0, z1)],
        "left": [(x0, y0, z0), (x0, y1, z0), (x0, y1, z1), (x0, y0, z1)],
        "right": [(x1, y0, z0), (x1, y0, z1), (x1, y1, z1), (x1, y1, z0)],
        "front": [(x0, y0, z0), (x0, y0, z1), (x1, y0, z1), (x1, y0, z0)],
        "back": [(x0, y1, z0), (x1, y1, z0), (x1, y1, z1), (x0, y1, z1)],
    }
    for name, material in walls.items():
        builder.add_mesh(name, *quad(*corners[name]), material)


def add_ceiling_lamp(
    builder: SceneBuilder, centre: ArrayLike, size_x: float, size_y: float, radiance: ArrayLike
) -> None:
    """A rectangle that shines down, two gaps below ``centre``."""
    matrix = np.eye(4)
    matrix[:3, 3] = np.asarray(centre, float) - (0, 0, 2 * GAP)
    add_area(builder, "lamp", matrix, size_x, size_y, radiance)


def add_lamp(
    builder: SceneBuilder, eye: ArrayLike, target: ArrayLike, size: float, radiance: ArrayLike
) -> None:
    """A square lamp at ``eye`` that faces ``target``."""
    add_area(builder, "lamp", look_at(eye, target), size, size, radiance)


def add_area(
    builder: SceneBuilder,
    name: str,
    matrix: NDArray[np.float64],
    size_x: float,
    size_y: float,
    radiance: ArrayLike,
) -> None:
    """A lamp with a black shield behind it.

    The lamps of some engines block rays, those of others do not: the shield always does.
    """
    builder.add_area_light(name, matrix, radiance, size_x, size_y)
    x, y = size_x / 2, size_y / 2
    corners = np.array([(-x, -y, GAP), (x, -y, GAP), (x, y, GAP), (-x, y, GAP)])
    black = builder.add_material(f"{name} shield", [diffuse(0.0)])
    shield = quad(*(corners @ matrix[:3, :3].T + matrix[:3, 3]))
    builder.add_mesh(f"{name} shield", *shield, black)


def ball(centre: ArrayLike, radius: float, subdivisions: int = 5) -> Mesh:
    """A sphere of flat faces, so small that no pixel shows one: the same in all engines."""
    return sphere(centre, radius, subdivisions)
