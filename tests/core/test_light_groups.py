"""The light of groups of lights, beside the whole picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import LightGroup, Settings, group_layer, render
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.lobes import dielectric, diffuse, ggx
from photon_map.tests import scenes

BASE = Settings(passes=4, threads=1, photons_global=2000, photons_caustic=2000)
GROUPS = (
    LightGroup("key", ("lamp",)),
    LightGroup("fill", ("second",), ("red",), True),
    LightGroup("rest", (), ("blue",)),
)


def two_glows():
    """Two lamps, a sky, and two bodies of one glowing material."""
    b = SceneBuilder("groups")
    b.add_mesh("floor", *scenes.plane(2.0), b.add_material("floor", [diffuse(0.6)]))
    b.add_mesh(
        "ball", *scenes.sphere((0, 0, 0.6), 0.4, 2), b.add_material("ice", [dielectric(1.5)])
    )
    b.add_mesh(
        "wall", *scenes.box((-2, 1.5, 0), (2, 1.6, 2)), b.add_material("wall", [ggx(0.7, 0.5)])
    )
    glow = b.add_material("glow", [], emission=(2.0, 1.0, 0.5))
    b.add_mesh("red", *scenes.box((-1.2, -0.3, 0.2), (-0.9, 0.3, 0.6)), glow)
    b.add_mesh("blue", *scenes.box((0.9, -0.3, 0.2), (1.2, 0.3, 0.6)), glow)
    b.add_point_light("lamp", (1.0, -1.5, 2.5), 5.0)
    b.add_point_light("second", (-1.0, -1.0, 2.0), 2.0, radius=0.1)
    b.set_world((0.1, 0.15, 0.2))
    b.set_camera(scenes.camera((0, -2.5, 2.0), (0, 0, 0.4), 16, 12))
    return b


def film_of(scene, settings):
    return list(render(scene, settings))[-1].film


def test_the_groups_make_the_picture():
    scene = two_glows().build()
    film = film_of(scene, replace(BASE, light_groups=GROUPS))
    for caustics in (False, True):
        parts = [film.resolve(group_layer(g.name, caustics)) for g in GROUPS]
        assert all(part.max() > 0 for part in parts)
        whole = film.resolve("caustics" if caustics else "combined")[..., :3]
        np.testing.assert_allclose(sum(parts), whole, rtol=1e-5, atol=1e-7)


def test_the_picture_is_the_same_with_and_without_groups():
    scene = two_glows().build()
    with_groups = film_of(scene, replace(BASE, light_groups=GROUPS, threads=2))
    plain = film_of(scene, BASE)
    assert (with_groups.resolve("combined") == plain.resolve("combined")).all()


def test_a_group_is_what_its_lights_do_alone():
    """Against a scene that has no other lights; their noise is not the same."""
    b = two_glows()
    group = film_of(b.build(), replace(BASE, passes=96, light_groups=GROUPS[:1]))
    scene = b.build()
    only = scene.lights.copy()
    only["emission"][1] = 0.0
    dark = scene.materials.copy()
    dark["emission"] = 0.0
    single = replace(scene, lights=only, materials=dark, world=np.zeros(3))
    expected = film_of(single, replace(BASE, passes=96)).resolve("combined")[..., :3]
    found = group.resolve(group_layer("key"))
    assert found.mean() == pytest.approx(expected.mean(), rel=0.02)


def test_two_groups_of_one_name_are_refused():
    with pytest.raises(ValueError, match="two of one name"):
        Settings(light_groups=(LightGroup("a"), LightGroup("a")))
