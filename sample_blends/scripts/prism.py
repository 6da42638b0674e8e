"""Prisms on a table in the beam of a spot lamp: bent light, and light turned around inside.

Run: python sample_blends/scripts/prism.py OUT.blend
"""

from __future__ import annotations

import math

import bpy
import common


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(480, 360)
    table = common.diffuse("Table", (0.5, 0.5, 0.5))
    wall = common.diffuse("Wall", (0.6, 0.6, 0.6))
    common.add_room((-2.0, -2.0, 0.0), (2.0, 1.2, 1.6), {"floor": table, "back": wall})
    clear = common.glass("Flint glass", (1.0, 1.0, 1.0), 1.62)
    add_prism("Bends", (-0.45, 0.0), 0.3, 60.0, 10.0, clear)
    add_prism("Turns around", (0.5, 0.15), 0.26, 90.0, -30.0, clear)
    for name, x in (("Left", -1.5), ("Right", 1.5)):
        target = (-0.45, 0.0, 0.2) if x < 0 else (0.5, 0.1, 0.2)
        common.add_aimed_light(name, "SPOT", (x, -0.35, 0.5), target, 120.0, 24.0)
    common.add_camera((0.0, -1.7, 1.5), (0.0, 0.1, 0.15), 38.0)


def add_prism(
    name: str,
    place: tuple[float, float],
    side: float,
    apex: float,
    turn: float,
    material: bpy.types.Material,
) -> None:
    """An upright prism whose base is an isosceles triangle with that angle at its apex."""
    half = math.radians(0.5 * apex)
    x, y = side * math.sin(half), side * math.cos(half)
    base = [(0.0, 0.5 * y), (-x, -0.5 * y), (x, -0.5 * y)]
    points = [(a, b, c) for c in (common.GAP, 0.4) for a, b in base]
    faces = [(2, 1, 0), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)]
    prism = common.add_mesh(name, points, faces, [material])
    prism.location = (*place, 0.0)
    prism.rotation_euler[2] = math.radians(turn)


if __name__ == "__main__":
    common.run(build, passes=64)
