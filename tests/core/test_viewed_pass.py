"""Discs that are looked at are those of renders, and each photon came the way it is told."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from photon_map.core import (
    Settings,
    ViewedPass,
    bake,
    photon_colours,
    photon_legend,
    power_scale,
)
from photon_map.core.baking.maps_file import BakeError, MapsFile
from photon_map.core.photons.gather import gather_irradiance
from photon_map.core.photons.sight import SIGHT
from photon_map.core.scene.builder import dielectric, diffuse, mirror, transparent
from photon_map.core.scene.scene import Scene
from photon_map.tests.scenes import cornell_glass, floor_scene, quad, sphere

SETTINGS = Settings(photons_global=4000, photons_caustic=4000, chunk_size=900)
DOWN = np.array([0.0, 0.0, -1.0])
LAMPS = {"left": (-2, 0, 2), "right": (2, 0, 3)}


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A floor, a mirror at its left, a glass ball at its right, a veil over its middle."""
    b = floor_scene([diffuse(0.5)], half=4.0, size=32, height=9.0)
    wall = quad((-4, -4, 0), (-4, -4, 4), (-4, 4, 4), (-4, 4, 0))
    b.add_mesh("mirror", *wall, b.add_material("red", [mirror((0.9, 0, 0))]))
    b.add_mesh("ball", *sphere((2, 0, 1), 0.5, 2), b.add_material("glass", [dielectric(1.5)]))
    veil = b.add_material("veil", [transparent(1.0)])
    b.add_mesh("veil", *quad((-1, -1, 0.5), (1, -1, 0.5), (1, 1, 0.5), (-1, 1, 0.5)), veil)
    for name, place in LAMPS.items():
        b.add_point_light(name, place, (5, 5, 5))
    return b.build()


@pytest.fixture(scope="module")
def viewed(scene: Scene) -> ViewedPass:
    return ViewedPass(scene, SETTINGS)


@pytest.mark.parametrize("x", [2.0, 0.5, -3.9])
def test_a_disc_is_that_of_a_gather(viewed: ViewedPass, x: float):
    place = viewed.place_at(np.array([x, 0.0, 0.2]), DOWN)
    assert place is not None and place.object == "floor" and place.outside
    np.testing.assert_allclose(place.position, (x, 0, 0), atol=1e-6)
    np.testing.assert_allclose(place.normal, (0, 0, 1), atol=1e-6)
    caustic, global_ = viewed.discs(place)
    assert caustic.caustic and not global_.caustic
    centre = place.position - viewed._prepared.centre.origin
    for disc, photon_map in (
        (caustic, viewed._maps.caustic),
        (global_, viewed._maps.global_),
    ):
        sight = np.zeros(SIGHT)
        e, _, found = gather_irradiance(
            photon_map, tuple(centre), tuple(place.normal), disc.radius, sight
        )
        assert found == len(disc.rows) == len(disc.weight)
        np.testing.assert_allclose(disc.irradiance * disc.share, e, rtol=1e-6, atol=1e-12)
        assert (viewed.view.caustic[disc.rows] == disc.caustic).all()
        away = viewed.view.position[disc.rows] - place.position
        assert np.linalg.norm(away, axis=1).max(initial=0) < disc.radius
    assert len(global_.rows) > 0
    # At the edge of the floor a part of the disc hangs in the air.
    assert (global_.share < 0.9) == (x < -3.5)
    legend = photon_legend(viewed.view.only(global_.rows), "light", global_.weight)
    assert sum(entry.number for entry in legend) == len(global_.rows)
    assert sum(entry.share for entry in legend) == pytest.approx(1.0)


def test_a_place_has_the_side_that_is_looked_at(viewed: ViewedPass):
    below = viewed.place_at(np.array([2.0, 0.3, -1.0]), -DOWN)
    assert below is not None and not below.outside
    np.testing.assert_allclose(below.normal, DOWN, atol=1e-6)
    assert all(len(disc.rows) == 0 for disc in viewed.discs(below))
    assert viewed.place_at(np.array([20.0, 0.0, 1.0]), DOWN) is None


def test_the_ray_of_a_pixel_is_the_cameras(viewed: ViewedPass):
    """The camera looks down from 9 m; its picture is as wide as the floor, or the other way."""
    corner = viewed.place_at(*viewed.ray_of(16.0, 16.0))
    aside = viewed.place_at(*viewed.ray_of(20.0, 13.0))
    assert corner is not None and aside is not None
    np.testing.assert_allclose(corner.position[:2], 0, atol=1e-5)
    assert aside.position[0] > 0 > aside.position[1]


def test_paths_lead_from_the_light_to_the_photon(viewed: ViewedPass):
    view = viewed.view
    rows = np.flatnonzero(view.bounce > 0)
    rows = np.concatenate([rows[::7], np.flatnonzero(view.bounce == 0)[::40]])
    seen = set()
    for row, way in zip(rows, viewed.paths(rows), strict=True):
        lamp = LAMPS[view.lights[view.light[row]]]
        np.testing.assert_allclose(way[0], lamp, atol=1e-5)
        np.testing.assert_allclose(way[-1], view.position[row], atol=1e-6)
        back = way[-2] - way[-1]
        back /= np.linalg.norm(back)
        np.testing.assert_allclose(back, view.direction[row], atol=2e-3)
        through = (abs(way[1:-1, 2] - 0.5) < 1e-6) & (abs(way[1:-1, :2]).max(axis=1) < 1)
        assert len(way) == 2 + view.bounce[row] + through.sum()
        first = way[1:-1][~through]
        caster = view.objects[view.caster[row]] if view.bounce[row] else ""
        if caster == "mirror":
            assert abs(first[0, 0] + 4) < 1e-5
        elif caster == "ball":
            away = np.linalg.norm(first[:2] - (2, 0, 1), axis=1)
            assert (abs(away - 0.5) < 0.02).all()
        seen |= {caster} | ({"veil"} if through.any() else set())
    assert seen >= {"mirror", "ball", "veil", ""}


def test_baked_maps_are_shown_as_they_are(scene: Scene, tmp_path: Path):
    path = tmp_path / "scene.pmap"
    bake(scene, replace(SETTINGS, seed=5, focus=False), path, 4)
    shown = ViewedPass(scene, Settings(photon_maps=str(path), seed=9), 6)
    assert shown.number == 2
    for kind, photons in zip((True, False), MapsFile(path).photons(2), strict=True):
        own = shown.view.only(shown.view.caustic == kind)
        centred = (own.position - shown._prepared.centre.origin).astype(np.float32)
        order = np.lexsort(centred.T)
        stored = np.lexsort(photons["position"].T)
        assert (centred[order] == photons["position"][stored]).all()
        assert (np.sort(own.flux, axis=0) == np.sort(photons["flux"], axis=0)).all()
    lamps = scene.lights.copy()
    lamps["emission"] *= 0.5
    with pytest.raises(BakeError, match="another scene: lamp 'left' has changed"):
        ViewedPass(replace(scene, lights=lamps), Settings(photon_maps=str(path)))


def test_without_photons_there_are_no_discs():
    off = Settings(photons_global=0, photons_caustic=0)
    viewed = ViewedPass(cornell_glass(8), off)
    assert len(viewed.view.position) == 0
    place = viewed.place_at(*viewed.ray_of(4.0, 4.0))
    assert place is not None and viewed.discs(place) == ()
    assert photon_colours(viewed.view, "power").shape == (0, 3)
    assert photon_legend(viewed.view, "bounce") == []


@pytest.mark.parametrize("by", ["power", "bounce", "caster", "light"])
def test_colours_tell_photons_apart(viewed: ViewedPass, by: str):
    colours = photon_colours(viewed.view, by)
    assert colours.shape == viewed.view.position.shape
    assert 0 <= colours.min() and colours.max() <= 1
    assert len(np.unique(colours, axis=0)) > 1
    entries = photon_legend(viewed.view, by)
    counts = [entry.number for entry in entries]
    assert sum(counts) == len(colours) and counts == sorted(counts, reverse=True)
    if by == "power":
        scale = power_scale(viewed.view)
        assert [watt for watt, _ in scale] == sorted(watt for watt, _ in scale)
        assert scale[0][0] < np.median(viewed.view.flux.mean(axis=1)) < scale[-1][0]
    else:
        for entry in entries:
            own = (colours == entry.colour).all(axis=1).sum()
            assert own >= entry.number
