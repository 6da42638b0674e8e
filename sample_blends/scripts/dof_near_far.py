"""A row of spheres in depth through a wide lens: frame 1 focuses near, frame 2 far.

The focus distance is keyframed without interpolation: frame 1 puts the sharp plane on the
nearest sphere, frame 2 on the farthest (`photonmap render ... --frame 2`).

Run: python sample_blends/scripts/dof_near_far.py OUT.blend
"""

from __future__ import annotations

import bpy
import common

CAMERA = (0.0, -2.9, 1.0)
TARGET = (-0.02, 1.0, 0.33)
#: Colours of the spheres from near to far.
COLOURS: tuple[common.Colour, ...] = (
    (0.75, 0.12, 0.08),
    (0.80, 0.42, 0.08),
    (0.78, 0.70, 0.15),
    (0.15, 0.50, 0.18),
    (0.10, 0.28, 0.65),
    (0.42, 0.14, 0.55),
)
RADIUS = 0.3


def build() -> None:
    """Make the scene in the running session."""
    scene = common.new_scene(640, 400)
    floor = common.diffuse("Floor", (0.5, 0.5, 0.5))
    white = common.diffuse("White", common.WHITE)
    wall = common.diffuse("Wall", (0.55, 0.58, 0.60))
    walls = dict.fromkeys(("front", "back", "left", "right"), wall)
    common.add_room(
        (-2.2, -3.2, 0.0), (2.2, 4.4, 2.6), {**walls, "floor": floor, "ceiling": white}
    )
    centres = [
        (-0.6 + 0.42 * i, -0.9 + 0.82 * i, RADIUS + common.GAP) for i in range(len(COLOURS))
    ]
    for number, (centre, colour) in enumerate(zip(centres, COLOURS, strict=True), 1):
        material = common.diffuse(f"Colour {number}", colour)
        common.add_sphere(f"Sphere {number}", centre, RADIUS, material, detail=4)

    common.add_area_light("Lamp", (-0.6, 0.6, 2.55), 55.0, 1.0)
    camera = common.add_camera(CAMERA, TARGET, 35.0, f_stop=0.45, focus=centres[0])
    scene.frame_start, scene.frame_end = 1, 2
    lens = camera.data.dof
    for frame, centre in ((1, centres[0]), (2, centres[-1])):
        front = (centre[0], centre[1] - 0.7 * RADIUS, centre[2])
        lens.focus_distance = common.axis_distance(CAMERA, TARGET, front)
        lens.keyframe_insert("focus_distance", frame=frame)
    hold(camera.data)
    scene.frame_set(1)


def hold(data: bpy.types.Camera) -> None:
    """Let every key of ``data`` hold its value until the next one."""
    for curve in data.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "CONSTANT"


if __name__ == "__main__":
    common.run(build)
