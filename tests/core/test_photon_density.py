"""The layer that tells how many photons lie around what the camera sees."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import Settings, ViewedPass, render
from photon_map.core.camera_pass.density import DensityMaps
from photon_map.core.prepared import prepare
from photon_map.core.scene.lobes import diffuse, mirror
from photon_map.tests import scenes

LAYER = "photon_density"
COUNT = 40_000
BASE = Settings(
    passes=4, threads=1, photons_global=COUNT, photons_caustic=0, gather_rays=1,
    pixel_filter="BOX", filter_width=1.0, first_hit=(LAYER,),
)  # fmt: skip


def film_of(scene, settings):
    return list(render(scene, settings))[-1].film


def density_of(scene, settings):
    return film_of(scene, settings).resolve(LAYER)[..., 0]


def sunlit_floor(angle=0.0):
    b = scenes.floor_scene([diffuse(0.5)])
    b.add_sun_light("sun", turned(angle), 3.0)
    return b.build()


def turned(angle):
    """About the x axis."""
    matrix = np.eye(4)
    matrix[1:3, 1:3] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return matrix


@pytest.mark.parametrize("angle", [0.0, 1.0])
def test_a_sunlit_plane_has_the_emitted_photons_over_their_area(angle):
    """A sun sends its photons through a disc as wide as the scene, at right angles to them."""
    scene = sunlit_floor(angle)
    radius = prepare(scene, BASE).centre.radius
    expected = COUNT * np.cos(angle) / (np.pi * radius**2)
    found = density_of(scene, BASE)
    # A sequence, not independent photons: discs of 20 in 4 passes scatter by less than a tenth.
    assert found.mean() == pytest.approx(expected, rel=0.01)
    assert found.std() < 0.1 * expected


def test_photons_that_are_scattered_count_again():
    """1 / (1 - albedo) photons of each one emitted end on the walls of a closed sphere."""
    for albedo, depth, factor in ((0.5, 1, 1.0), (0.5, 32, 2.0), (0.8, 32, 5.0)):
        scene = scenes.closed_sphere(albedo, size=8)
        corners = scene.vertices[scene.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(normals, axis=1).sum() / 2
        found = density_of(scene, replace(BASE, photon_depth=depth)).mean()
        # 64 pixels, each with discs of 20 photons or more in 4 passes: a deviation of 1.4 %.
        assert found == pytest.approx(factor * COUNT / area, rel=0.05)


def test_it_is_of_what_mirrors_show_and_nothing_is_none():
    b = scenes.floor_scene([diffuse(0.5)])
    b.add_sun_light("sun", np.eye(4), 3.0)
    wall = scenes.quad((0, -1, 1), (0, 1, 1), (0, 1, 3), (0, -1, 3))
    b.add_mesh("mirror", *wall, b.add_material("mirror", [mirror(1.0)]))
    b.set_camera(scenes.camera((1, 0, 2), (0, 0, 1.5), 2, 2, fov=0.05))
    direct = density_of(sunlit_floor(), BASE).mean()
    ratio = (prepare(sunlit_floor(), BASE).centre.radius
             / prepare(b.build(), BASE).centre.radius) ** 2  # fmt: skip
    assert density_of(b.build(), BASE) == pytest.approx(direct * ratio, rel=0.2)
    b.set_camera(scenes.camera((1, 0, 2), (2, 0, 3), 2, 2, fov=0.05))
    assert (density_of(b.build(), BASE) == 0).all()


def test_it_is_what_the_discs_of_a_place_hold():
    """Of both maps, with their borders; ``ViewedPass`` sums the photons in NumPy."""
    camera = scenes.camera((0, -4.9, 0), (0.48, -0.6, -1), 1, 1, fov=3e-5)
    scene = replace(scenes.cornell_glass(), camera=camera)
    settings = replace(BASE, passes=1, photons_caustic=COUNT, caustic_radius=1000)
    viewed = ViewedPass(scene, settings)
    place = viewed.place_at(*viewed.ray_of(0.5, 0.5))
    assert place.object == "floor"
    sums = [disc.weight.sum() for disc in viewed.discs(place)]
    assert len(sums) == 2
    assert min(sums) > 0
    assert density_of(scene, settings)[0, 0] == pytest.approx(sum(sums), rel=1e-3)


def test_it_costs_nothing_when_off(monkeypatch):
    scene = sunlit_floor()
    bare = replace(BASE, first_hit=())
    with_it = film_of(scene, BASE)
    monkeypatch.setattr(DensityMaps, "of", staticmethod(lambda *maps: 1 / 0))
    without = film_of(scene, bare)
    with pytest.raises(ZeroDivisionError):
        film_of(scene, BASE)
    with pytest.raises(ValueError, match="not rendered"):
        without.resolve(LAYER)
    assert (with_it.resolve("combined") == without.resolve("combined")).all()
    assert with_it.statistics == without.statistics
