"""The smallest inputs: one photon, none, one pixel, one face, nothing at all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse, mirror
from photon_map.tests import scenes
from photon_map.tests.stability.support import film_of, note, shot


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_few_photons(count):
    layers = shot(scenes.cornell_glass(8), photons_global=count, photons_caustic=count)
    assert layers["direct"].mean() > 0
    if count == 0:
        assert (layers["caustics"] == 0).all() and (layers["indirect"] == 0).all()


def test_one_photon_a_pass_is_right_in_the_mean():
    """Few photons make noise, not bias: the mirror's virtual lamp over many passes."""
    scene = scenes.mirror_caustic(8, radius=0.0)
    found = shot(scene, photons_caustic=1, photons_global=0, passes=8000, alpha=0.99)

    def radiance(x, y):
        return 0.8 / np.pi * 4.0 * 1.5 / ((x - 3.5) ** 2 + (y - 0.2) ** 2 + 2.25) ** 1.5

    expected = scenes.floor_mean(scene, radiance).mean()
    note(found["caustics"], expected)
    # The first discs are as wide as 1.4 pixels: bias below 1 %. One photon in 40 counts.
    assert found["caustics"].mean() == pytest.approx(expected, rel=0.2)


@pytest.mark.parametrize(("width", "height"), [(1, 1), (1, 7), (7, 1)])
def test_one_pixel(width, height):
    scene = scenes.cornell_glass(8)
    camera = replace(scene.camera, width=width, height=height)
    film = film_of(replace(scene, camera=camera))
    assert film.resolve("combined").shape == (height, width, 4)
    assert film.resolve("combined").mean() > 0


@pytest.mark.parametrize("lobes", [[], [diffuse(0.5)], [mirror(1.0)], [dielectric(1.5)]])
@pytest.mark.parametrize("emission", [0.0, 1.0])
def test_one_face(lobes, emission):
    b = SceneBuilder("one face")
    material = b.add_material("m", lobes, emission=emission)
    b.add_mesh("face", [(-1, -1, 0), (1, -1, 0), (0, 1, 0)], [[0, 1, 2]], material)
    b.add_point_light("lamp", (0, 0, 1), 1.0, 0.1)
    b.set_world(0.5)
    b.set_camera(scenes.camera((0, -1, 2), (0, 0, 0), 6, 6))
    found = shot(b.build())
    if emission:
        assert found["emission"][3, 3] == pytest.approx(emission, abs=0.6)


@pytest.mark.parametrize("world", [0.0, 1.0])
def test_no_face_at_all(world):
    b = SceneBuilder("nothing")
    b.add_point_light("lamp", (0, 0, 1), 1.0)
    b.set_world(world)
    b.set_camera(scenes.camera((0, -1, 2), (0, 0, 0), 4, 4))
    assert (shot(b.build())["total"] == world).all()


def test_only_dropped_faces():
    b = SceneBuilder("dropped")
    b.add_mesh("bad", [(0, 0, 0), (1, 1, 1), (2, 2, 2)], [[0, 1, 2]], b.add_material("m"))
    b.set_world(1.0)
    b.set_camera(scenes.camera((0, -1, 2), (0, 0, 0), 4, 4))
    assert b.dropped_faces == 1
    assert (shot(b.build())["total"] == 1).all()


def test_all_in_one_plane_and_the_camera_in_it():
    b = SceneBuilder("flat")
    b.add_mesh("a", *scenes.plane(1.0), b.add_material("a", [diffuse(0.5)], emission=1.0))
    b.add_point_light("lamp", (2.0, 0, 0), 1.0)
    b.set_camera(scenes.camera((0, -3, 0), (0, 0, 0), 5, 5))
    shot(b.build())


@pytest.mark.parametrize("power", [1e-12, 1e12])
def test_albedos_at_the_ends(power):
    b = scenes.floor_scene([diffuse((0.0, 1.0, 1e-12)), mirror((1.0, 0.0, 0.0))], size=6)
    b.add_mesh("wall", *scenes.quad((2, -4, 0), (2, -4, 4), (2, 4, 4), (2, 4, 0)),
               b.add_material("w", [diffuse((1, 0, 0)), mirror((0, 1, 1))]))  # fmt: skip
    b.add_point_light("lamp", (0, 0, 1), (0.0, power, power * 1e-6), 0.1)
    assert shot(b.build())["total"].max() > 0
