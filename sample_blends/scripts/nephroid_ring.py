"""A ring of polished brass in the sun: the nephroid on the table.

Run: python sample_blends/scripts/nephroid_ring.py OUT.blend
"""

from __future__ import annotations

import common


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(480, 360)
    table = common.diffuse("Table", (0.62, 0.58, 0.52))
    common.add_room((-3.0, -3.0, 0.0), (3.0, 3.0, 2.0), {"floor": table}, name="Table")
    brass = common.mirror("Brass", (0.92, 0.74, 0.40))
    low = common.GAP
    profile = [(0.55, low), (0.55, 0.3), (0.5, 0.3), (0.5, low)]
    common.lathe("Ring", profile, brass, segments=192, closed=True)
    common.add_aimed_light("Sun", "SUN", (-2.0, 0.6, 1.3), (0.0, 0.0, 0.0), 3.0, 0.5)
    common.add_camera((0.0, -1.6, 1.9), (0.05, 0.0, 0.05), 48.0)


if __name__ == "__main__":
    common.run(build, passes=64)
