"""Blue reflectors under four white point lamps: their caustics on the ceiling are blue.

Run: python sample_blends/scripts/mirror_caustics.py OUT.blend
"""

from __future__ import annotations

import common


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(640, 480)
    white = common.diffuse("White", common.WHITE)
    grey = common.diffuse("Grey", (0.5, 0.5, 0.5))
    sand = common.diffuse("Sand", (0.50, 0.42, 0.33))
    walls = dict.fromkeys(("front", "back", "left", "right"), grey)
    common.add_room(
        (-1.65, -2.9, 0.0), (1.65, 1.4, 1.9), {**walls, "floor": sand, "ceiling": white}
    )

    blue = common.mirror("Blue mirror", (0.06, 0.16, 0.90))
    common.add_sphere("Sphere", (-1.0, 0.35, 0.32 + common.GAP), 0.32, blue)
    common.add_box("Cuboid", (1.02, 0.35, 0.25 + common.GAP), (0.45, 0.45, 0.5), blue, 25.0)
    dish = common.lathe("Dish", dish_profile(), blue, segments=80)
    dish.location = (0.0, -0.1, common.GAP)
    ring = common.lathe(
        "Ring", common.arc((0.2, 0.0), 0.07, 0.0, 345.0, 23), blue, segments=64, closed=True
    )
    ring.location = (-0.72, -0.72, 0.07 + common.GAP)

    for number, (x, y) in enumerate(
        ((-0.5, -0.55), (0.5, -0.55), (-0.5, 0.35), (0.5, 0.35)), 1
    ):
        common.add_point_light(f"Lamp {number}", (x, y, 1.1), 12.0, 0.03)
    common.add_camera((0.0, -2.7, 1.02), (0.0, 0.0, 0.92), 21.0)


def dish_profile() -> list[tuple[float, float]]:
    """Radius and height of a dish on a foot; its hollow has a radius of 1.6 m.

    A lamp comes to a focus a little below the ceiling, on the other side of the axis.
    """
    foot = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.015)]
    stem = common.arc((0.2, 0.115), 0.1, 270.0, 180.0, 8)
    bottom = common.arc((0.0, 1.74), 1.63, -86.0, -71.5, 8)
    hollow = common.arc((0.0, 1.77), 1.6, -71.0, -90.0, 16)
    return foot + stem[1:] + bottom + hollow


if __name__ == "__main__":
    common.run(build)
