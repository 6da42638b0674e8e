"""A tumbler of whisky with ice: glass, liquid and ice inside each other, lit by one small lamp.

Run: python sample_blends/scripts/whisky_glass.py OUT.blend
"""

from __future__ import annotations

import common


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(480, 360)
    table = common.diffuse("Table", (0.55, 0.42, 0.32))
    wall = common.diffuse("Wall", (0.45, 0.47, 0.50))
    common.add_room((-3.0, -3.0, 0.0), (3.0, 2.0, 3.0), {"floor": table, "back": wall})
    tumbler = common.lathe("Tumbler", tumbler_profile(), common.glass("Glass"), segments=72)
    tumbler.location = (0.0, 0.0, common.GAP)
    # A hair wider than the hollow, so that nothing lies between glass and whisky.
    whisky = common.glass("Whisky", (0.95, 0.55, 0.16), 1.36)
    drink = [(0.0, 0.11), (0.292, 0.11), (0.308, 0.34), (0.0, 0.34)]
    common.lathe("Drink", drink, whisky, segments=72).location = (0.0, 0.0, common.GAP)
    ice = common.glass("Ice", (1.0, 1.0, 1.0), 1.31)
    common.add_box("Ice 1", (-0.09, 0.04, 0.27), (0.2, 0.2, 0.2), ice, 20.0)
    cube = common.add_box("Ice 2", (0.14, -0.03, 0.3), (0.18, 0.18, 0.18), ice, 50.0)
    cube.rotation_euler[0] = 0.4
    common.add_point_light("Lamp", (-1.2, 1.1, 1.8), 60.0, 0.03)
    common.add_camera((0.35, -2.0, 1.1), (0.12, -0.1, 0.2), 50.0)


def tumbler_profile() -> list[tuple[float, float]]:
    """Radius and height, up the outside and down the hollow."""
    outside = [(0.0, 0.0), (0.31, 0.0), (0.33, 0.02), (0.36, 0.6)]
    rim = [(0.35, 0.61), (0.335, 0.6)]
    return outside + rim + [(0.29, 0.12), (0.27, 0.1), (0.0, 0.1)]


if __name__ == "__main__":
    common.run(build, passes=64)
