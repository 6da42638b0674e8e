"""The report's figure 1: a glass cuboid without Fresnel's terms (frame 1) and with them (2).

The left wall is red, the right one green: only with Fresnel's terms does the cuboid mirror a
part of the walls. Frame 1 has Blender's Refraction shader, which also ends what would be
reflected totally; the report followed it in both.

Run: python sample_blends/scripts/fresnel_cuboid.py OUT.blend
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
        "front": common.diffuse("Grey", (0.4, 0.4, 0.4)),
        "left": common.diffuse("Red", common.RED),
        "right": common.diffuse("Green", common.GREEN),
    }
    common.add_room((-1.2, -2.4, 0.0), (1.2, 1.2, 2.0), walls)
    size = (0.9, 0.5, 0.9)
    for frame, material in ((1, common.refraction("No Fresnel")), (2, common.glass("Fresnel"))):
        place = (0.0, -0.1, 0.5 * size[2] + common.GAP)
        cuboid = common.add_box(f"Cuboid {frame}", place, size, material, 32.0)
        common.show_in(frame, cuboid)
    common.add_area_light("Lamp", (0.0, 0.0, 1.98), 40.0, 0.6)
    common.add_camera((0.0, -2.2, 1.25), (0.0, 0.0, 0.55), 30.0)
    scene.frame_set(1)


if __name__ == "__main__":
    common.run(build, passes=64)
