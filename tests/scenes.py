"""Small scenes for all tests; lengths in metres, the camera looks along -Z of its matrix."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photon_map.core.scene.builder import (
    Lobe,
    SceneBuilder,
    dielectric,
    diffuse,
    mirror,
)
from photon_map.core.scene.camera_data import CameraData
from photon_map.core.scene.scene import Scene

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]
DOWN = np.eye(4)  # a light's or camera's own matrix: it faces -Z


def look_at(eye: ArrayLike, target: ArrayLike, up: ArrayLike = (0, 0, 1)) -> NDArray:
    """Object-to-world matrix at ``eye`` whose -Z points at ``target``."""
    position = np.asarray(eye, float)
    z = position - np.asarray(target, float)
    z /= np.linalg.norm(z)
    x = np.cross(np.asarray(up, float), z)
    if np.linalg.norm(x) < 1e-9:
        x = np.cross((0.0, 1.0, 0.0), z)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3] = np.stack([x, np.cross(z, x), z, position], axis=1)
    return matrix


def camera(
    eye: ArrayLike, target: ArrayLike, width: int, height: int, up: ArrayLike = (0, 0, 1),
    fov: float = np.radians(40), **others: float,
) -> CameraData:  # fmt: skip
    """A camera with the field of view ``fov`` [rad] over its larger side."""
    lens = 36.0 / (2 * np.tan(fov / 2))
    matrix = look_at(eye, target, up)
    return CameraData(width=width, height=height, matrix=matrix, lens=lens, **others)  # type: ignore[arg-type]


def quad(a: ArrayLike, b: ArrayLike, c: ArrayLike, d: ArrayLike) -> Mesh:
    """Two triangles, counter-clockwise a b c d."""
    return np.array([a, b, c, d], float), np.array([[0, 1, 2], [0, 2, 3]])


def plane(half: float = 1.0, z: float = 0.0) -> Mesh:
    """A square in z = ``z`` whose normal is +z."""
    h = half
    return quad((-h, -h, z), (h, -h, z), (h, h, z), (-h, h, z))


def box(low: ArrayLike, high: ArrayLike) -> Mesh:
    """A box of 12 triangles, normals outside."""
    (x0, y0, z0), (x1, y1, z1) = np.asarray(low, float), np.asarray(high, float)
    points = np.array([(x, y, z) for z in (z0, z1) for y in (y0, y1) for x in (x0, x1)])
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return points, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def sphere(centre: ArrayLike, radius: float, subdivisions: int = 2) -> Mesh:
    """An icosphere of 20 * 4^subdivisions faces, normals outside."""
    g = (1 + 5**0.5) / 2
    points: list[tuple[float, float, float]] = [
        (-1, g, 0),
        (1, g, 0),
        (-1, -g, 0),
        (1, -g, 0),
        (0, -1, g),
        (0, 1, g),
    ]
    points += [(0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    fan = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4)]
    fan += [(11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8)]
    fan += [(3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    triangles = np.asarray(points, float)[np.array(fan)]
    for _ in range(subdivisions):
        a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        ab, bc, ca = a + b, b + c, c + a
        four = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = np.concatenate([np.stack(t, axis=1) for t in four])
        triangles /= np.linalg.norm(triangles, axis=2, keepdims=True)
    triangles /= np.linalg.norm(triangles, axis=2, keepdims=True)
    corners = triangles.reshape(-1, 3) * radius + np.asarray(centre, float)
    return corners, np.arange(len(corners)).reshape(-1, 3)


def sphere_normals(mesh: Mesh, centre: ArrayLike) -> NDArray[np.float32]:
    """Smooth corner normals (F, 3, 3) of a sphere."""
    away = mesh[0][mesh[1]] - np.asarray(centre, float)
    return (away / np.linalg.norm(away, axis=2, keepdims=True)).astype(np.float32)


def floor_scene(
    lobes: list[Lobe], half: float = 4.0, size: int = 8, height: float = 4.0
) -> SceneBuilder:
    """A builder with a floor at z = 0 and a camera above that looks straight down."""
    b = SceneBuilder("floor")
    b.add_mesh("floor", *plane(half), b.add_material("floor", lobes))
    b.set_camera(camera((0, 0, height), (0, 0, 0), size, size, up=(0, 1, 0)))
    return b


def floor_mean(
    scene: Scene, value: Callable[[NDArray, NDArray], NDArray], order: int = 6
) -> NDArray:
    """Mean (h, w) over each pixel of ``value(x, y)`` on the floor of ``floor_scene``."""
    c = scene.camera
    assert c is not None and c.width == c.height
    half = c.matrix[2, 3] * c.sensor_width / (2 * c.lens)
    nodes, weights = np.polynomial.legendre.leggauss(order)
    middle = (np.arange(c.width) + 0.5) / c.width * 2 * half - half
    at = middle[:, None] + nodes * half / c.width
    x, y = at[None, :, None, :], at[:, None, :, None]
    return np.einsum("hwij,i,j->hw", value(x, y) + 0 * x * y, weights, weights) / 4


def furnace_box(albedo: float = 0.5, emission: float = 1.0, size: int = 8) -> Scene:
    """The inside of a glowing box: radiance emission / (1 - albedo) everywhere."""
    b = SceneBuilder("furnace box")
    material = b.add_material("wall", [diffuse(albedo)], emission=emission)
    b.add_mesh("box", *box((-1, -1, -1), (1, 1, 1)), material)
    b.set_camera(camera((0.2, -0.3, 0.1), (1, 0.2, -0.4), size, size, fov=np.radians(80)))
    return b.build()


def closed_sphere(albedo: float = 0.5, intensity: float = np.pi, size: int = 4) -> Scene:
    """A sphere of radius 1 around a point light: radiance I a / (pi (1 - a)), I in W/sr."""
    b = SceneBuilder("closed sphere")
    shell = sphere((0, 0, 0), 1.0, 3)
    b.add_mesh("shell", *shell, b.add_material("shell", [diffuse(albedo)]))
    b.add_point_light("lamp", (0, 0, 0), intensity)
    b.set_camera(camera((0.3, 0.1, 0), (1, 0.3, 0.2), size, size, fov=np.radians(60)))
    return b.build()


def glass_slab(ior: float, low: float = 0.5, high: float = 0.7, half: float = 40.0) -> Mesh:
    """The box of a wide horizontal slab."""
    return box((-half, -half, low), (half, half, high))


def cornell_glass(size: int = 16, smooth: bool = False, subdivisions: int = 1) -> Scene:
    """Box 2 x 2 x 2 open to the camera, glass and mirror sphere, area light in the top."""
    b = SceneBuilder("cornell glass" + (" smooth" if smooth else ""))
    white = b.add_material("white", [diffuse(0.75)])
    red = b.add_material("red", [diffuse((0.65, 0.06, 0.05))])
    green = b.add_material("green", [diffuse((0.12, 0.45, 0.1))])
    glass = b.add_material("glass", [dielectric(1.5)])
    silver = b.add_material("silver", [mirror(0.9)])
    h = 1.0
    b.add_mesh("floor", *quad((-h, -h, -h), (h, -h, -h), (h, h, -h), (-h, h, -h)), white)
    b.add_mesh("ceiling", *quad((-h, -h, h), (-h, h, h), (h, h, h), (h, -h, h)), white)
    b.add_mesh("back", *quad((-h, h, -h), (h, h, -h), (h, h, h), (-h, h, h)), white)
    b.add_mesh("left", *quad((-h, -h, -h), (-h, h, -h), (-h, h, h), (-h, -h, h)), red)
    b.add_mesh("right", *quad((h, -h, -h), (h, -h, h), (h, h, h), (h, h, -h)), green)
    for name, centre, material in (
        ("glass ball", (0.42, -0.35, -0.6), glass),
        ("mirror ball", (-0.45, 0.3, -0.6), silver),
    ):
        ball = sphere(centre, 0.39, subdivisions)
        normals = sphere_normals(ball, centre) if smooth else None
        b.add_mesh(name, *ball, material, normals)
    light = np.eye(4)
    light[2, 3] = 0.98
    b.add_area_light("lamp", light, 12.0, 0.6, 0.6)
    b.set_camera(camera((0, -4.9, 0), (0, 0, 0), size, size, fov=np.radians(27)))
    return b.build()


def mirror_caustic(size: int = 8, radius: float = 0.1) -> Scene:
    """A floor lit by a small sphere lamp and by its image in a vertical mirror x = 2."""
    b = floor_scene([diffuse(0.8)], half=4.0, size=size, height=3.0)
    wall = quad((2, -40, 0), (2, 40, 0), (2, 40, 40), (2, -40, 40))
    b.add_mesh("mirror", *wall, b.add_material("mirror", [mirror(1.0)]))
    b.add_point_light("lamp", (0.5, 0.2, 1.5), 4.0, radius=radius)
    return b.build()
