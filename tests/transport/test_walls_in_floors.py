"""Walls that stand in a floor which goes on below them: no light leaks, no dark border.

Two rooms share one shell and a wall parts them, or they are two boxes side by side. In the
one is a lamp, the other is dark.
"""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.scene.builder import SceneBuilder, diffuse, mirror
from photon_map.tests import scenes

SETTINGS = {"pixel_filter": "BOX", "filter_width": 1.0, "photons_global": 16384}


def two_rooms(x, thickness, boxes):
    """A camera at ``x`` in 4 x 2 x 2 m with a wall at x = 0, or between two ``boxes``."""
    b = SceneBuilder("two rooms")
    grey = b.add_material("grey", [diffuse(0.5)])
    half = thickness / 2
    if boxes:
        b.add_mesh("left", *scenes.box((-2, -1, -1), (-half, 1, 1)), grey)
        b.add_mesh("right", *scenes.box((half, -1, -1), (2, 1, 1)), grey)
    else:
        b.add_mesh("shell", *scenes.box((-2, -1, -1), (2, 1, 1)), grey)
        b.add_mesh("wall", *scenes.box((-half, -1.1, -1.1), (half, 1.1, 1.1)), grey)
    b.add_point_light("lamp", (1, 0, 0), 100.0)
    eye, target = (x, -0.6, 0.3), (0, 0.3, -0.4)
    b.set_camera(scenes.camera(eye, target, 16, 16, fov=np.radians(80)))
    return b.build()


@pytest.mark.parametrize("thickness", [0.1, 1e-3, 1e-5])
@pytest.mark.parametrize("boxes", [False, True])
def test_no_light_comes_into_the_dark_room(thickness, boxes):
    pictures = []
    for x in (-1.5, 1.5):
        scene = two_rooms(x, thickness, boxes)
        film = list(render(scene, Settings(passes=4, **SETTINGS)))[-1].film
        pictures.append(film.resolve("combined")[..., :3])
    assert pictures[0].max() <= 1e-6 * pictures[1].mean()


def ring(sides, inner, outer, low, high):
    """A ring about the z axis: (vertices, faces)."""
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    profile = ((outer, low), (outer, high), (inner, high), (inner, low))
    points = [np.column_stack([r * np.cos(angle), r * np.sin(angle), np.full(sides, z)])
              for r, z in profile]  # fmt: skip
    k = np.arange(sides)
    n = (k + 1) % sides
    faces = []
    for a in range(4):
        b = (a + 1) % 4
        first, second = a * sides, b * sides
        faces.append(np.column_stack([first + k, first + n, second + n]))
        faces.append(np.column_stack([first + k, second + n, second + k]))
    return np.concatenate(points), np.concatenate(faces)


def test_no_light_comes_below_a_ring_that_stands_a_millimetre_above_the_floor():
    """It meets the floor in 1024 lines of 6 mm; discs of a decimetre lie across all of it.

    They end at its walls. What is left is the sunlit 0.6 mm below its outer wall, spread over
    the 50 mm of the slit: 1.2 % of the floor's light, of which a place beside the inner wall
    sees some percent. With discs that pass through the picture had 0.4 % of the floor's light.
    """
    b = SceneBuilder("ring")
    b.add_mesh("floor", *scenes.plane(3.0), b.add_material("floor", [diffuse(0.8)]))
    polished = b.add_material("mirror", [mirror((0.9, 0.9, 0.9))])
    b.add_mesh("ring", *ring(512, 0.5, 0.55, 0.001, 0.3), polished)
    b.add_sun_light("sun", scenes.look_at((-0.7, 0, 1.2), (0, 0, 0)), 1.0)
    eye, target = (-0.4, 0, 1), (-0.46, 0, 0)
    b.set_camera(scenes.camera(eye, target, 16, 16, up=(0, 1, 0), fov=0.1))
    film = list(render(b.build(), Settings(passes=32, **SETTINGS)))[-1].film
    lit = 0.8 / np.pi * 1.2 / np.hypot(0.7, 1.2)
    assert film.resolve("combined")[..., :3].mean() < 1.5e-3 * lit


@pytest.mark.parametrize("low", [-1.0, -1.1])
def test_white_bodies_in_a_room_of_equal_light_vanish(low):
    """Radiance is the room's emission / (1 - albedo) everywhere; inside of bodies is none."""
    b = SceneBuilder("furnished room")
    wall = b.add_material("wall", [diffuse(0.5)], emission=1.0)
    white = b.add_material("white", [diffuse(1.0)])
    b.add_mesh("room", *scenes.box((-1, -1, -1), (1, 1, 1)), wall)
    b.add_mesh("box", *scenes.box((-0.3, -0.2, low), (0.3, 0.3, -0.2)), white)
    b.add_mesh("pillar", *scenes.box((0.4, 0.3, -1.2), (0.6, 0.6, 1.2)), white)
    b.add_mesh("ball", *scenes.sphere((-0.5, 0.5, -0.9), 0.3, 3), white)
    eye, target = (0.1, -0.95, 0.5), (0, 0.3, -0.6)
    b.set_camera(scenes.camera(eye, target, 16, 16, fov=np.radians(80)))
    scene = b.build()
    runs = []
    for seed in range(8):
        film = list(render(scene, Settings(passes=16, seed=seed, **SETTINGS)))[-1].film
        runs.append(film.resolve("combined")[..., 0])
    mean = np.mean(runs, axis=0)
    error = np.std([run.mean() for run in runs], ddof=1) / np.sqrt(8)
    # 5.4 sigma at 7 degrees of freedom: 0.001. Grazing rims of 45 degrees are left: 0.1 %.
    assert abs(mean.mean() / 2 - 1) < 0.001 + 5.4 * error / 2
    assert error < 0.001 * 2
