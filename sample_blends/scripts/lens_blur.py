"""The report's figure 4: a small glowing square before a wide lens, a frame for each distance.

The lens of radius 0.12 m is focused at 2 m; the square stands at ``DISTANCES`` and grows with
them, so that it always fills the same part of the picture. What is seen of it is its blur.

Run: python sample_blends/scripts/lens_blur.py OUT.blend
"""

from __future__ import annotations

import math

import common

#: Of frames 1, 2, ... [m].
DISTANCES = (1.0, 1.4, 2.0, 2.6, 3.4, 4.2, 5.0)
FOCUS, RADIUS = 2.0, 0.12
#: Half an edge of the square over its distance.
HALF = 0.01
#: Focal length [mm] of a view of 30 degrees.
LENS = 36.0 / (2.0 * math.tan(math.radians(15.0)))


def build() -> None:
    """Make the scene in the running session."""
    scene = common.new_scene(65, 65)
    corners = [(-HALF, 0.0, -HALF), (HALF, 0.0, -HALF), (HALF, 0.0, HALF), (-HALF, 0.0, HALF)]
    glow = common.shader("Glow", "ShaderNodeEmission", Strength=1.0)
    spot = common.add_mesh("Spot", corners, [(0, 1, 2, 3)], [glow])
    scene.frame_start, scene.frame_end = 1, len(DISTANCES)
    for frame, distance in enumerate(DISTANCES, start=1):
        spot.location = (0.0, distance, 0.0)
        spot.scale = (distance, 1.0, distance)
        spot.keyframe_insert("location", frame=frame)
        spot.keyframe_insert("scale", frame=frame)
    f_stop = LENS / 1000.0 / (2.0 * RADIUS)
    middle = (0.0, FOCUS, 0.0)
    common.add_camera((0.0, 0.0, 0.0), middle, LENS, f_stop=f_stop, focus=middle)
    scene.frame_set(1)


if __name__ == "__main__":
    common.run(build, passes=128)
