"""The photons that are shown: that each is told the way it really came."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings
from photon_map.core.photon_view import PhotonView, picture_places, view_photons
from photon_map.core.scene.builder import dielectric, diffuse, mirror
from photon_map.core.scene.scene import Scene
from photon_map.tests.scenes import cornell_glass, floor_scene, quad, sphere

SETTINGS = Settings(photons_global=4000, photons_caustic=4000, chunk_size=900)


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A floor, a red mirror at its left and a glass ball at its right, two lamps."""
    b = floor_scene([diffuse(0.5)], half=4.0, size=32, height=9.0)
    wall = quad((-4, -4, 0), (-4, -4, 4), (-4, 4, 4), (-4, 4, 0))
    b.add_mesh("mirror", *wall, b.add_material("red", [mirror((0.9, 0, 0))]))
    b.add_mesh("ball", *sphere((2, 0, 1), 0.5, 2), b.add_material("glass", [dielectric(1.5)]))
    b.add_point_light("left", (-2, 0, 2), (5, 5, 5))
    b.add_point_light("right", (2, 0, 3), (0, 0, 5))
    return b.build()


@pytest.fixture(scope="module")
def view(scene: Scene) -> PhotonView:
    return view_photons(scene, SETTINGS)


def test_photons_are_named_after_their_light_and_their_caster(scene: Scene, view: PhotonView):
    lights, objects = view.lights, view.objects
    assert len(view.position) > 500 and view.caustic.any() and not view.caustic.all()
    assert (view.position[:, 2] < 0.01).all(), "photons lie on the floor alone"
    # The right lamp is blue, and what the mirror returns is red: of it nothing is left.
    blue = view.flux[:, 0] == 0
    right = np.array([lights[k] == "right" for k in view.light])
    mirrored = np.array([k >= 0 and objects[k] == "mirror" for k in view.caster])
    assert right.any() and mirrored.any()
    assert not (right & mirrored).any()
    assert (blue == right)[~mirrored].all()
    assert (view.flux[mirrored, 2] == 0).all()
    assert (view.bounce[view.caustic] >= 1).all() and (view.caster[view.caustic] >= 0).all()
    first = view.bounce == 0
    assert (view.caster[first] == -1).all()
    # What came straight from a lamp points back to it.
    way = np.array([(-2, 0, 2), (2, 0, 3)])[view.light[first]] - view.position[first]
    way /= np.linalg.norm(way, axis=1)[:, None]
    np.testing.assert_allclose((way * view.direction[first]).sum(axis=1), 1.0, atol=1e-4)


def test_batches_change_nothing(scene: Scene, view: PhotonView):
    from dataclasses import replace

    whole = view_photons(scene, replace(SETTINGS, chunk_size=10_000))
    for name in ("position", "flux", "bounce", "light", "caster"):
        one = np.sort(getattr(view, name), axis=0)
        assert (one == np.sort(getattr(whole, name), axis=0)).all(), name


def test_a_pixel_shows_what_lies_there(scene: Scene, view: PhotonView):
    rows, pixels = picture_places(scene, SETTINGS, view)
    assert 0 < len(rows) < len(view.position)
    assert pixels.min() >= 0 and pixels.max() < 32
    # Seen from above the floor lies straight; what is under the ball is hidden or at its rim.
    places = view.position[rows, :2]
    line = np.polyfit(places[:, 0], pixels[:, 0], 1)
    assert line[0] > 0
    assert abs(np.polyval(line, places[:, 0]) - pixels[:, 0]).max() < 1.0
    hidden = np.hypot(*(view.position[:, :2] - (2, 0)).T) < 0.3
    assert hidden.any() and not np.isin(np.flatnonzero(hidden), rows).any()


def test_photons_of_a_box_lie_in_it():
    view = view_photons(cornell_glass(8), SETTINGS)
    assert abs(view.position).max() < 1.0 + 1e-5
    chosen = view.only(view.caustic)
    assert chosen.caustic.all() and len(chosen.flux) == view.caustic.sum()
