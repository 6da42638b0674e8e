"""Light that falls through a keyhole into a dark room, and all that it reaches.

Run: python sample_blends/scripts/keyhole.py OUT.blend
"""

from __future__ import annotations

import math

import bpy
import common

#: Corners of the wall, across and up, about the keyhole's middle.
WALL = ((-1.5, -0.9), (1.5, -0.9), (1.5, 1.3), (-1.5, 1.3))


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(480, 360)
    plaster = common.diffuse("Plaster", (0.70, 0.68, 0.64))
    walls = dict.fromkeys(("floor", "ceiling", "left", "right", "front"), plaster)
    walls["right"] = common.diffuse("Red", common.RED)
    common.add_room((-1.5, -2.5, 0.0), (1.5, 1.0, 2.2), walls)
    add_door(plaster)
    common.add_sphere("Ball", (0.35, -0.5, 0.3 + common.GAP), 0.3, common.glass("Glass"))
    common.add_aimed_light("Lamp", "SPOT", (-0.6, 2.6, 2.0), (0.0, 1.0, 0.9), 9000.0, 30.0)
    common.add_camera((-1.0, -2.2, 1.3), (0.25, 0.2, 0.55), 26.0)


def add_door(material: bpy.types.Material) -> None:
    """The wall at y = 1 with a keyhole: a disc above a slit that widens downwards."""
    hole = []
    for k in range(25):
        angle = math.radians(-60.0 + 300.0 * k / 24)
        hole.append((0.09 * math.cos(angle), 0.09 * math.sin(angle)))
    hole += [(-0.075, -0.3), (0.075, -0.3)]
    outer = [_on_wall(math.atan2(z, x)) for x, z in hole]
    count = len(hole)
    points = [(x, 1.0, 0.9 + z) for x, z in hole + outer + list(WALL)]
    faces = [(k, (k + 1) % count, count + (k + 1) % count, count + k) for k in range(count)]
    # Corners of the wall lie between two rays from the middle: a triangle each.
    for number, (x, z) in enumerate(WALL):
        angle = math.atan2(z, x)
        for k in range(count):
            a, b = hole[k], hole[(k + 1) % count]
            low, high = math.atan2(a[1], a[0]), math.atan2(b[1], b[0])
            if low < angle < (high if high > low else high + 2 * math.pi):
                faces.append((count + k, count + (k + 1) % count, 2 * count + number))
    common.add_mesh("Door", points, faces, [material])


def _on_wall(angle: float) -> tuple[float, float]:
    """Where a ray from the keyhole's middle leaves the wall."""
    x, z = math.cos(angle), math.sin(angle)
    across = (1.5 if x > 0 else -1.5) / x if abs(x) > 1e-9 else math.inf
    up = (1.3 if z > 0 else -0.9) / z if abs(z) > 1e-9 else math.inf
    way = min(across, up)
    return way * x, way * z


if __name__ == "__main__":
    common.run(build, passes=64)
