"""A tiled pool in the sun, its bottom seen through the waves.

Run: python sample_blends/scripts/pool.py OUT.blend
"""

from __future__ import annotations

import math

import common

CELLS = 96
EDGE = 1.02
LOW = -0.05
#: Height, length, direction and phase of each wave.
WAVES = ((0.012, 0.9, 20, 0.3), (0.008, 0.53, 75, 1.1), (0.005, 0.37, 140, 2.0))


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(480, 360)
    tile = common.diffuse("Tile", (0.50, 0.68, 0.75))
    walls = dict.fromkeys(("floor", "left", "right", "front", "back"), tile)
    common.add_room((-1.0, -1.0, 0.0), (1.0, 1.0, 1.1), walls, name="Pool")
    add_water()
    common.add_aimed_light("Sun", "SUN", (0.7, 1.0, 2.6), (0.0, 0.0, 0.0), 5.0, 0.5)
    common.add_camera((0.25, 1.5, 3.2), (0.0, 0.05, 0.3), 50.0)


def height(x: float, y: float) -> float:
    """The surface of the water."""
    z = 0.9
    for size, length, angle, phase in WAVES:
        turn = math.radians(angle)
        way = math.cos(turn) * x + math.sin(turn) * y
        z += size * math.sin(2 * math.pi * way / length + phase)
    return z


def add_water() -> None:
    """A closed body that reaches a little into the tiles."""
    line = [EDGE * (2 * k / CELLS - 1) for k in range(CELLS + 1)]
    points = [(x, y, height(x, y)) for y in line for x in line]
    n = CELLS + 1
    faces = [
        (j * n + i, j * n + i + 1, (j + 1) * n + i + 1, (j + 1) * n + i)
        for j in range(CELLS)
        for i in range(CELLS)
    ]
    rim = [*range(n), *(j * n + CELLS for j in range(1, n))]
    rim += [CELLS * n + i for i in range(CELLS - 1, -1, -1)]
    rim += [j * n for j in range(CELLS - 1, 0, -1)]
    start = len(points)
    points += [(points[k][0], points[k][1], LOW) for k in rim]
    for k in range(len(rim)):
        after = (k + 1) % len(rim)
        faces.append((rim[k], start + k, start + after, rim[after]))
    faces.append(tuple(range(len(points) - 1, start - 1, -1)))
    water = common.glass("Water", (1.0, 1.0, 1.0), 1.33)
    common.add_mesh("Water", points, faces, [water], smooth_below=20.0)


if __name__ == "__main__":
    common.run(build, passes=64)
