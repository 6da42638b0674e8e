"""Glass of index 1.52 in the report's appendix: a cuboid (frame 1), a sphere (frame 2).

The wall behind the camera is blue and comes by reflection off the cuboid's side; the sphere
takes a green tint from the right wall.

Run: python sample_blends/scripts/index_152.py OUT.blend
"""

from __future__ import annotations

import common


def build() -> None:
    """Make the scene in the running session."""
    scene = common.new_scene(480, 360)
    white = common.diffuse("White", common.WHITE)
    walls = {
        "floor": white,
        "ceiling": white,
        "back": white,
        "front": common.diffuse("Blue", common.BLUE),
        "left": common.diffuse("Red", common.RED),
        "right": common.diffuse("Green", common.GREEN),
    }
    common.add_room((-1.2, -2.4, 0.0), (1.2, 1.2, 2.0), walls)
    clear = common.glass("Glass")
    size = (0.55, 0.55, 1.0)
    place = (0.0, 0.0, 0.5 * size[2] + common.GAP)
    common.show_in(1, common.add_box("Cuboid", place, size, clear, 24.0))
    ball = common.add_sphere("Sphere", (0.35, 0.0, 0.5 + common.GAP), 0.5, clear)
    common.show_in(2, ball)
    common.add_point_light("Lamp", (-0.2, 0.55, 1.75), 30.0, 0.03)
    common.add_camera((-0.35, -2.1, 1.2), (0.05, 0.0, 0.6), 30.0)
    scene.frame_set(1)


if __name__ == "__main__":
    common.run(build, passes=64)
