"""Transparent objects that refract the light of one small lamp into caustics on the floor.

The lamp stands behind the group, so that the caustics fall towards the camera. The ring is
of amber and the lens of pale blue glass: their caustics carry the colour.

Run: python sample_blends/scripts/glass_caustics.py OUT.blend
"""

from __future__ import annotations

import common


def build() -> None:
    """Make the scene in the running session."""
    common.new_scene(640, 480)
    plaster = common.diffuse("Plaster", (0.68, 0.66, 0.62))
    wall = common.diffuse("Wall", (0.33, 0.40, 0.47))
    walls = dict.fromkeys(("front", "back", "left", "right"), wall)
    common.add_room(
        (-2.0, -3.0, 0.0), (2.0, 2.0, 2.6), {**walls, "floor": plaster, "ceiling": plaster}
    )
    clear = common.glass("Glass")
    amber = common.glass("Amber glass", (1.0, 0.72, 0.28))
    blue = common.glass("Blue glass", (0.62, 0.85, 1.0))

    common.add_sphere("Sphere", (-0.52, -0.1, 0.3 + common.GAP), 0.3, clear)
    common.add_box("Cuboid", (0.62, 0.12, 0.35 + common.GAP), (0.3, 0.3, 0.7), clear, 35.0)
    ring = common.lathe(
        "Ring", common.arc((0.26, 0.0), 0.085, 0.0, 350.0, 35), amber, segments=72, closed=True
    )
    ring.location = (0.14, -0.62, 0.085 + common.GAP)
    lens = common.lathe("Lens", lens_profile(), blue, segments=64, smooth_below=60.0)
    lens.location = (0.02, 0.38, 0.3 + common.GAP)
    lens.rotation_euler = (1.5708, 0.0, -0.3)
    cone = common.lathe("Cone", [(0.0, 0.0), (0.17, 0.0), (0.0, 0.42)], clear, segments=64)
    cone.location = (-0.78, -0.72, common.GAP)

    common.add_point_light("Lamp", (-0.25, 1.5, 1.75), 60.0, 0.03)
    common.add_camera((0.0, -2.75, 1.35), (0.0, -0.2, 0.2), 37.0)


def lens_profile() -> list[tuple[float, float]]:
    """Radius and height of a biconvex lens, 0.6 m across, its axis along Z."""
    centre = 0.5
    radius = (0.3**2 + centre**2) ** 0.5
    under = common.arc((0.0, centre), radius, -90.0, -59.04, 16)
    over = common.arc((0.0, -centre), radius, 59.04, 90.0, 16)
    return under[:-1] + over


if __name__ == "__main__":
    common.run(build)
