"""The caustic of a glass ball, seen through a magnifying lens.

Run: python sample_blends/scripts/magnifier.py OUT.blend
"""

from __future__ import annotations

import math

import common
from mathutils import Vector


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(480, 360)
    table = common.diffuse("Table", (0.65, 0.60, 0.50))
    common.add_room((-3.0, -3.0, 0.0), (3.0, 3.0, 2.0), {"floor": table}, name="Table")
    clear = common.glass("Glass")
    common.add_sphere("Ball", (-0.5, 0.35, 0.3 + common.GAP), 0.3, clear)
    eye, seen = Vector((0.35, -1.9, 1.5)), Vector((-0.3, 0.2, 0.0))
    lens = common.lathe("Lens", lens_profile(), clear, segments=72, smooth_below=60.0)
    lens.location = seen.lerp(eye, 0.3)
    lens.rotation_euler = (eye - seen).to_track_quat("Z", "Y").to_euler()
    common.add_aimed_light("Lamp", "SPOT", (-1.5, 1.0, 1.6), (-0.5, 0.35, 0.3), 160.0, 70.0)
    common.add_camera(tuple(eye), tuple(seen), 52.0)


def lens_profile() -> list[tuple[float, float]]:
    """Radius and height of a biconvex lens, 0.66 m across."""
    centre = 1.2
    half = math.degrees(math.asin(0.33 / 1.244))
    under = common.arc((0.0, centre), 1.244, -90.0, -90.0 + half, 12)
    over = common.arc((0.0, -centre), 1.244, 90.0 - half, 90.0, 12)
    return under[:-1] + over


if __name__ == "__main__":
    common.run(build, passes=64)
