"""Cornell box with a glass and a mirror sphere under a square area lamp.

The benchmark's scene: `benchmarks/glass_box.py` renders it at 128x128 with a box filter
against `benchmarks/references/cornell_glass_128.exr`. A change here makes that reference
worthless: make a new one with `benchmarks/reference.py`.

Run: python sample_blends/scripts/cornell_glass.py OUT.blend
"""

from __future__ import annotations

import common


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(256, 256)
    white = common.diffuse("White", common.WHITE)
    walls = {
        "floor": white,
        "ceiling": white,
        "back": white,
        "left": common.diffuse("Red", common.RED),
        "right": common.diffuse("Green", common.GREEN),
    }
    common.add_room((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0), walls)
    radius = 0.38
    height = radius + common.GAP
    common.add_sphere("Glass sphere", (0.45, -0.35, height), radius, common.glass("Glass"))
    common.add_sphere("Mirror sphere", (-0.42, 0.35, height), radius, common.mirror("Mirror"))
    common.add_area_light("Lamp", (0.0, 0.0, 1.98), 20.0, 0.4)
    common.add_camera((0.0, -3.7, 1.0), (0.0, 0.0, 1.0), 50.0)


if __name__ == "__main__":
    common.run(build, passes=64)
