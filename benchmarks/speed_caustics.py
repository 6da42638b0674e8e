"""Scenes of caustics and of skies."""

from __future__ import annotations

import numpy as np
from speed_shapes import (
    GAP,
    SIZE,
    WHITE,
    add_lamp,
    add_room,
    ball,
    box,
    camera,
    height_field,
    lathe,
    look_at,
    quad,
    vertex_normals,
)

from photon_map.core import Scene, SceneBuilder
from photon_map.core.scene.lobes import dielectric, diffuse, mirror


def floor(b: SceneBuilder, half: float, color: tuple[float, float, float]) -> None:
    """A square floor at z = 0."""
    h = half
    corners = ((-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0))
    b.add_mesh("floor", *quad(*corners), b.add_material("floor", [diffuse(color)]))


def point_light() -> Scene:
    """A glass ball and a glass ring on a floor under a lamp without size."""
    b = SceneBuilder("point light")
    floor(b, 3.0, (0.6, 0.55, 0.5))
    glass = b.add_material("glass", [dielectric(1.5)])
    b.add_mesh("ball", *ball((-0.45, 0.1, 0.4 + GAP), 0.4), glass)
    angle = np.linspace(0.0, -2 * np.pi, 49)
    torus = [(0.35 + 0.1 * np.cos(a), 0.1 + GAP + 0.1 * np.sin(a)) for a in angle]
    b.add_mesh("ring", *lathe(torus, 192, (0.55, -0.25, 0)), glass)
    b.add_point_light("lamp", (-1.1, 0.9, 2.2), 8.0)
    b.set_camera(camera((0.2, -3.2, 2.6), (0, 0.0, 0.15), SIZE, SIZE, fov=np.radians(36)))
    return b.build()


def nephroid() -> Scene:
    """A ring of polished metal on a floor, in the sun: the nephroid."""
    b = SceneBuilder("nephroid ring")
    floor(b, 3.0, WHITE)
    metal = b.add_material("metal", [mirror((0.9, 0.75, 0.45))])
    profile = [(0.55, GAP), (0.55, 0.3), (0.5, 0.3), (0.5, GAP), (0.55, GAP)]
    b.add_mesh("ring", *lathe(profile, 512, (0, 0, 0)), metal)
    sun = look_at((-2.0, 0.6, 1.3), (0, 0, 0))
    b.add_sun_light("sun", sun, 4.0, np.radians(0.5))
    b.set_camera(camera((0, -1.6, 2.4), (0, 0, 0.05), SIZE, SIZE, fov=np.radians(32)))
    return b.build()


def waves(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height of the pool's surface: a few sines of different lengths."""
    z = np.full_like(x, 0.9)
    for a, length, angle, phase in (
        (0.012, 0.9, 20, 0.3), (0.008, 0.53, 75, 1.1), (0.005, 0.37, 140, 2.0),
        (0.003, 0.21, 40, 0.7),
    ):  # fmt: skip
        way = np.cos(np.radians(angle)) * x + np.sin(np.radians(angle)) * y
        z = z + a * np.sin(2 * np.pi * way / length + phase)
    return z


def pool() -> Scene:
    """A tiled pool in the sun, its bottom seen through its waves.

    The camera stands on the sun's side, where it sees no glint: LuxCore has none.
    """
    b = SceneBuilder("wavy pool")
    tile = b.add_material("tile", [diffuse((0.55, 0.7, 0.75))])
    walls = dict.fromkeys(("floor", "left", "right", "front", "back"), tile)
    add_room(b, (-1, -1, 0), (1, 1, 1.1), walls)
    water = b.add_material("water", [dielectric(1.33)])
    b.add_mesh("water", *closed_water(), water)
    b.add_sun_light(
        "sun", look_at((0.7, 1.0, 2.6), (0, 0, 0)), (4.0, 3.9, 3.6), np.radians(0.5)
    )
    b.set_camera(camera((0.25, 1.3, 3.4), (0, 0.0, 0.4), SIZE, SIZE, fov=np.radians(30)))
    return b.build()


def closed_water() -> tuple[np.ndarray, np.ndarray]:
    """The waves, reaching a little into the tiles, and a bottom far below them."""
    edge, low = 1.02, -0.05
    points, faces = height_field((-edge, -edge), (edge, edge), 160, waves)
    line = np.arange(161)
    rim = np.concatenate([line, 160 + 161 * line[1:], 161 * 161 - 2 - line[:-1]])
    rim = np.concatenate([rim, 161 * (159 - line[:-2])])
    below = points[rim] * (1, 1, 0) + (0, 0, low)
    start = len(points)
    skirt = []
    for k in range(len(rim)):
        n = (k + 1) % len(rim)
        skirt += [(rim[k], start + k, start + n), (rim[k], start + n, rim[n])]
    e = edge
    bottom = [(-e, -e, low), (-e, e, low), (e, e, low), (e, -e, low)]
    whole = np.concatenate([points, below, np.array(bottom)])
    b = start + len(rim)
    return whole, np.concatenate([faces, skirt, [(b, b + 1, b + 2), (b, b + 2, b + 3)]])


def magnifier() -> Scene:
    """The caustic of a glass ball, seen through a lens that stands before it."""
    b = SceneBuilder("magnifier")
    floor(b, 3.0, (0.65, 0.6, 0.5))
    glass = b.add_material("glass", [dielectric(1.5)])
    b.add_mesh("ball", *ball((-0.5, 0.35, 0.3 + GAP), 0.3), glass)
    half = np.linspace(0.0, 0.3, 25)
    sag = np.sqrt(1.2**2 - half**2) - np.sqrt(1.2**2 - 0.3**2)
    upper = list(zip(half, sag, strict=True))
    profile = upper + [(r, -z) for r, z in upper[-2::-1]]
    points, faces = lathe(profile, 96, (0, 0, 0))
    eye, seen = np.array([0.35, -1.9, 1.5]), np.array([-0.25, 0.17, 0.0])
    matrix = look_at(seen + 0.3 * (eye - seen), eye)
    b.add_mesh("lens", points @ matrix[:3, :3].T + matrix[:3, 3], faces, glass)
    add_lamp(b, (-1.5, 1.0, 1.6), (-0.5, 0.35, 0.3), 0.3, 64.0)
    b.set_camera(camera(eye, seen, SIZE, SIZE, fov=np.radians(30)))
    return b.build()


def sky_map(height: int = 384) -> np.ndarray:
    """A clear evening: blue above, warm at the rim, a bright patch about the sun."""
    rows, columns = np.arange(height) + 0.5, np.arange(2 * height) + 0.5
    up = np.pi * (rows / height - 0.5)[:, None]
    around = (2 * np.pi * (0.5 - columns / (2 * height)))[None, :]
    x, y = np.cos(up) * np.cos(around), np.cos(up) * np.sin(around)
    z = np.sin(up) + 0 * around
    sun = np.array([-0.55, 0.35, 0.76]) / np.linalg.norm([-0.55, 0.35, 0.76])
    towards = x * sun[0] + y * sun[1] + z * sun[2]
    above = np.clip(z, 0, 1)[..., None]
    sky = (1 - above) * np.array([0.5, 0.4, 0.3]) + above * np.array([0.1, 0.2, 0.45])
    sky = np.where(z[..., None] < 0, np.array([0.06, 0.05, 0.04]), sky)
    glow = np.exp((towards - 1) / 0.004)[..., None] * np.array([300.0, 260.0, 200.0])
    return (sky + glow).astype(np.float32)


def hdri_glass() -> Scene:
    """Glass things on a floor under a photographed sky."""
    b = SceneBuilder("HDRI and glass")
    floor(b, 3.0, (0.5, 0.5, 0.5))
    glass = b.add_material("glass", [dielectric(1.5)])
    b.add_mesh("ball", *ball((-0.35, 0, 0.4 + GAP), 0.4), glass)
    b.add_mesh("block", *box((0.25, -0.35, GAP), (0.65, 0.05, 0.6)), glass)
    b.set_world(1.0, sky_map())
    b.set_camera(camera((0.3, -3.0, 1.7), (0, 0, 0.2), SIZE, SIZE, fov=np.radians(38)))
    return b.build()


def million(side: int = 700) -> Scene:
    """2 ``side``^2 triangles of rough ground and a glass ball under a lamp and the sky."""
    b = SceneBuilder("a million triangles")
    random = np.random.default_rng(1)
    terms = [
        (0.12 / (k + 1), (k + 1) * random.normal(size=2) * 2.2, random.uniform(0, 6.3))
        for k in range(24)
    ]

    def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        total = np.zeros_like(x)
        for size, way, phase in terms:
            total += size * np.sin(way[0] * x + way[1] * y + phase) / 1.5
        return total

    ground = height_field((-2, -2), (2, 2), side, height)
    material = b.add_material("ground", [diffuse((0.5, 0.4, 0.3))])
    b.add_mesh("ground", *ground, material, vertex_normals(ground))
    glass = b.add_material("glass", [dielectric(1.5)])
    b.add_mesh("ball", *ball((0.2, -0.5, 0.75), 0.35, 6), glass)
    add_lamp(b, (-1.6, 1.0, 3.0), (0, 0, 0.2), 0.6, 80.0)
    b.set_world((0.15, 0.18, 0.25))
    b.set_camera(camera((0.2, -4.2, 2.4), (0, -0.1, 0.2), SIZE, SIZE, fov=np.radians(36)))
    return b.build()
