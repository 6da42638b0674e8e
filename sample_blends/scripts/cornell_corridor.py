"""The final image of the report: a corridor with every effect in one picture.

Red and green side walls, a blue wall behind the camera (seen in the mirror that closes the
far end), a glass sphere and a glass cuboid of index 1.52, a mirror dish that throws its
caustic on the ceiling, one small point lamp behind the glass, so that its caustics fall
towards the camera, and a wide lens focused on the glass: the near and the far edges of the
walls are soft.

Run: python sample_blends/scripts/cornell_corridor.py OUT.blend
"""

from __future__ import annotations

import common

CORRIDOR = ((-1.2, -1.2, 0.0), (1.2, 4.7, 2.2))
CAMERA = (0.0, -0.9, 1.25)
TARGET = (0.0, 3.0, 0.86)


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(640, 480)
    white = common.diffuse("White", common.WHITE)
    polished = common.mirror("Mirror")
    clear = common.glass("Glass")
    walls = {
        "floor": white,
        "ceiling": white,
        "left": common.diffuse("Red", common.RED),
        "right": common.diffuse("Green", common.GREEN),
        "front": common.diffuse("Blue", common.BLUE),
    }
    common.add_room(*CORRIDOR, walls)
    common.add_room(*CORRIDOR, {"back": polished}, name="Mirror wall")

    radius = 0.4
    common.add_sphere("Glass sphere", (-0.55, 1.75, radius + common.GAP), radius, clear)
    size = (0.42, 0.42, 0.95)
    common.add_box("Glass cuboid", (0.62, 2.0, 0.5 * size[2] + common.GAP), size, clear, 28.0)
    dish = common.lathe("Mirror dish", dish_profile(), polished, segments=80)
    dish.location = (0.05, 3.35, common.GAP)

    common.add_point_light("Lamp", (0.0, 2.65, 1.5), 36.0, 0.03)
    common.add_camera(CAMERA, TARGET, 28.0, f_stop=0.5, focus=(-0.55, 1.6, 0.4))


def dish_profile() -> list[tuple[float, float]]:
    """Radius and height of a dish on a foot, from the middle of its foot to its hollow.

    The hollow is part of a sphere of radius 1.45 m: the lamp, 1.5 m above, comes to a focus
    a little below the ceiling.
    """
    foot = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.015)]
    stem = common.arc((0.2, 0.115), 0.1, 270.0, 180.0, 8)
    bottom = common.arc((0.0, 1.59), 1.48, -86.0, -72.0, 8)
    hollow = common.arc((0.0, 1.62), 1.45, -71.5, -90.0, 24)
    return foot + stem[1:] + bottom + hollow


if __name__ == "__main__":
    common.run(build)
