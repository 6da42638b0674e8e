"""The medium stack: nesting, leaving, open and flipped meshes."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings
from photon_map.core.camera_pass.records import PATH
from photon_map.core.geometry.media import STACK, cross_surface, ior_around, is_hidden
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import SceneBuilder, dielectric
from photon_map.tests import scenes

WATER, GLASS = 0, 1


def nested(camera_at):
    """A ball of glass in a ball of water, and a camera."""
    b = SceneBuilder("nested")
    b.add_material("water", [dielectric(1.33)])
    b.add_material("glass", [dielectric(1.5)])
    b.add_mesh("water", *scenes.sphere((0, 0, 0), 2.0, 2), WATER)
    b.add_mesh("glass", *scenes.sphere((0.2, 0, 0), 1.0, 2), GLASS)
    b.set_camera(scenes.camera(camera_at, (9, 1, 0), 2, 2))
    b.add_point_light("lamp", camera_at, 1.0)
    return b.build()


@pytest.mark.parametrize(
    ("place", "media"),
    [((5, 0, 0), []), ((-1.5, 0.1, 0), [WATER]), ((0.3, 0.1, 0), [WATER, GLASS])],
)
def test_camera_and_lamp_know_what_they_are_inside_of(place, media):
    prepared = prepare(nested(place), Settings())
    for row in (prepared.camera_media, prepared.light_media[0]):
        assert row[0] == len(media) and row[1 : 1 + len(media)].tolist() == media


def test_the_stack_gives_the_index_on_the_far_side():
    materials = nested((5, 0, 0)).materials
    path = np.zeros(1, PATH)[0]
    assert ior_around(materials, path, WATER, True) == 1.0
    cross_surface(path, WATER, True)
    assert ior_around(materials, path, GLASS, True) == 1.33
    cross_surface(path, GLASS, True)
    assert ior_around(materials, path, GLASS, False) == 1.33
    # Water's surface lies inside the glass: behind it there is still glass.
    assert ior_around(materials, path, WATER, False) == 1.5
    cross_surface(path, GLASS, False)
    assert ior_around(materials, path, WATER, False) == 1.0
    cross_surface(path, WATER, False)
    assert path["media_count"] == 0


def test_of_overlapping_equals_the_one_entered_last_has_the_surfaces():
    materials = nested((5, 0, 0)).materials
    path = np.zeros(1, PATH)[0]
    cross_surface(path, GLASS, True)
    assert not is_hidden(materials, path, WATER, True), "into the water, out of the glass"
    cross_surface(path, WATER, True)
    assert is_hidden(materials, path, GLASS, False), "water before and after"
    assert not is_hidden(materials, path, WATER, False)
    cross_surface(path, GLASS, False)
    assert not is_hidden(materials, path, WATER, False)
    assert not is_hidden(materials, path, GLASS, False), "was never entered"


def test_the_higher_priority_hides_the_other_s_surfaces():
    materials = nested((5, 0, 0)).materials.copy()
    materials["priority"][GLASS] = 1
    path = np.zeros(1, PATH)[0]
    cross_surface(path, GLASS, True)
    for entering in (True, False):
        assert is_hidden(materials, path, WATER, entering)
    cross_surface(path, WATER, True)
    assert not is_hidden(materials, path, GLASS, False)


def test_leaving_what_was_never_entered_changes_nothing():
    materials = nested((5, 0, 0)).materials
    path = np.zeros(1, PATH)[0]
    cross_surface(path, WATER, True)
    assert ior_around(materials, path, GLASS, False) == 1.33
    cross_surface(path, GLASS, False)
    assert path["media_count"] == 1


def test_nesting_deeper_than_the_stack_is_ignored():
    path = np.zeros(1, PATH)[0]
    for _ in range(STACK + 3):
        cross_surface(path, WATER, True)
    assert path["media_count"] == STACK


def test_a_pane_above_is_no_medium_but_open_water_is():
    b = SceneBuilder("sheets")
    glass = b.add_material("glass", [dielectric(1.5)])
    water = b.add_material("water", [dielectric(1.33)])
    b.add_mesh("pane", *scenes.plane(0.5, z=1.0), glass)
    pane = prepare(_seen_from(b, (0, 0, 0)), Settings())
    assert pane.camera_media[0] == 0
    b.add_mesh("sea", *scenes.plane(1e3, z=2.0), water)
    sea = prepare(_seen_from(b, (0, 0, 0)), Settings())
    assert sea.camera_media[:2].tolist() == [1, water]


def _seen_from(b, place):
    b.set_camera(scenes.camera(place, (1, 0, 0), 2, 2))
    return b.build()
