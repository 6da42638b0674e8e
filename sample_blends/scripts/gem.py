"""A cut stone of index 2.42 on black cloth and white paper, in the light of two small lamps.

Run: python sample_blends/scripts/gem.py OUT.blend
"""

from __future__ import annotations

import common


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(480, 360)
    paper = common.diffuse("Paper", (0.72, 0.72, 0.70))
    common.add_room((-3.0, -3.0, 0.0), (3.0, 3.0, 2.0), {"floor": paper}, name="Paper")
    stone = common.glass("Stone", (1.0, 1.0, 1.0), 2.42)
    outline = [(0.0, 0.0), (0.5, 0.43), (0.5, 0.46), (0.42, 0.54), (0.28, 0.62), (0.0, 0.62)]
    gem = common.lathe("Stone", outline, stone, segments=12, smooth_below=0.0)
    # It rests on its side: on the facet from the point to the girdle.
    gem.rotation_euler = (0.0, 0.86, 0.4)
    gem.location = (-0.15, 0.1, 0.02)
    tint = common.glass("Red stone", (1.0, 0.25, 0.3), 1.77)
    small = [(0.6 * r, 0.6 * z) for r, z in outline]
    other = common.lathe("Red stone", small, tint, segments=8, smooth_below=0.0)
    other.location = (0.75, -0.25, 0.38)
    other.rotation_euler = (3.14159, 0.0, 0.2)
    common.add_point_light("Lamp", (-1.6, 1.3, 2.2), 70.0, 0.03)
    common.add_point_light("Second lamp", (1.8, 0.8, 1.8), 30.0, 0.03)
    common.add_camera((0.3, -2.6, 1.9), (0.15, 0.0, 0.2), 50.0)


if __name__ == "__main__":
    common.run(build, passes=64)
