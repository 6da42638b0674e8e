"""The report's figure 3: a glass sphere under a small lamp, for the two normalisations.

Bright at the sphere's focus on the floor, dim on the walls, where few photons come.

Run: python sample_blends/scripts/caustic_sphere.py OUT.blend
"""

from __future__ import annotations

import common


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(480, 360)
    white = common.diffuse("White", common.WHITE)
    walls = {
        "floor": white,
        "ceiling": white,
        "back": white,
        "left": common.diffuse("Red", common.RED),
        "right": common.diffuse("Green", common.GREEN),
    }
    common.add_room((-1.2, -2.4, 0.0), (1.2, 1.2, 2.0), walls)
    common.add_sphere("Glass sphere", (0.0, 0.1, 0.62), 0.4, common.glass("Glass"))
    common.add_point_light("Lamp", (0.0, 0.0, 1.8), 30.0, 0.02)
    common.add_camera((0.0, -2.3, 1.2), (0.0, 0.1, 0.75), 28.0)


if __name__ == "__main__":
    common.run(build, passes=64)
