"""The report's last picture: the room's far wall is a mirror, with caustics on the floor.

Run: python sample_blends/scripts/mirror_wall.py OUT.blend
"""

from __future__ import annotations

import common


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(480, 360)
    white = common.diffuse("White", common.WHITE)
    low, high = (-1.2, -2.4, 0.0), (1.2, 1.6, 2.0)
    walls = {
        "floor": white,
        "ceiling": white,
        "front": common.diffuse("Blue", common.BLUE),
        "left": common.diffuse("Red", common.RED),
        "right": common.diffuse("Green", common.GREEN),
    }
    common.add_room(low, high, walls)
    common.add_room(low, high, {"back": common.mirror("Mirror")}, name="Mirror wall")
    common.add_sphere("Glass", (-0.5, 0.3, 0.35 + common.GAP), 0.35, common.glass("Glass"))
    yellow = common.diffuse("Yellow", (0.8, 0.6, 0.1))
    common.add_sphere("Ball", (0.5, 0.5, 0.3 + common.GAP), 0.3, yellow)
    common.add_point_light("Lamp", (0.1, 0.6, 1.75), 34.0, 0.03)
    common.add_camera((0.0, -2.2, 1.25), (0.0, 0.4, 0.75), 26.0)


if __name__ == "__main__":
    common.run(build, passes=64)
