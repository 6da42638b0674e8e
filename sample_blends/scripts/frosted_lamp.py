"""A lamp behind a pane of frosted glass, in a dark room.

Run: python sample_blends/scripts/frosted_lamp.py OUT.blend
"""

from __future__ import annotations

import common


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(480, 360)
    plaster = common.diffuse("Plaster", (0.62, 0.60, 0.57))
    walls = dict.fromkeys(("floor", "ceiling", "left", "right", "back"), plaster)
    common.add_room((-1.5, -2.5, 0.0), (1.5, 1.5, 2.2), walls)
    frosted = common.glass("Frosted glass", (1.0, 1.0, 1.0), common.GLASS_IOR, 0.35)
    common.add_box("Pane", (0.0, 0.5, 0.62), (1.1, 0.04, 1.2), frosted)
    wood = common.diffuse("Wood", (0.35, 0.22, 0.12))
    common.add_box("Foot", (0.0, 0.5, 0.01), (1.3, 0.3, 0.018), wood)
    common.add_point_light("Lamp", (0.0, 0.95, 0.7), 28.0, 0.05)
    common.add_sphere("Ball", (-0.75, -0.1, 0.22), 0.22, common.diffuse("Red", common.RED))
    common.add_box("Block", (0.7, -0.1, 0.2), (0.3, 0.3, 0.4), plaster, 30.0)
    common.add_camera((0.3, -2.3, 1.2), (0.0, 0.3, 0.6), 30.0)


if __name__ == "__main__":
    common.run(build, passes=64)
