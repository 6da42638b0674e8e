"""The picture apart by what its light did at the first surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import KIND_COLORS, KIND_LAYERS, Settings, render
from photon_map.core.camera_pass import light_image
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.closures import principled, rough_glass
from photon_map.core.scene.lobes import (
    dielectric,
    diffuse,
    ggx,
    mirror,
    translucent,
    transparent,
)
from photon_map.tests import scenes

BASE = Settings(passes=6, threads=1, photons_global=2000, photons_caustic=2000)
ASKED = replace(
    BASE, light_kinds=True, first_hit=(*KIND_COLORS, "seen_emission", "environment")
)

SURFACES = {
    "diffuse": [diffuse(0.6)],
    "glossy": [ggx(0.8, 0.6)],
    "sharp glossy": [ggx(0.8, 0.3)],
    "glass": [dielectric(1.5)],
    "mirror": [mirror(0.9)],
    "mixture": [mirror(0.3), dielectric(1.5, 0.3), diffuse(0.3)],
    "plastic": [diffuse((0.5, 0.3, 0.0)), ggx(0.2, 0.6), translucent(0.2)],
}
CLOSURES = {
    "rough glass": [rough_glass(1.5, 0.6, (0.9, 0.8, 0.7))],
    "frosted": [rough_glass(1.4, 0.3, 0.9)],
    "principled": [
        principled(color=(0.7, 0.4, 0.2), roughness=0.4, transmission=0.4, coat=0.5)
    ],
}


def film_of(scene, settings):
    return list(render(scene, settings))[-1].film


def still_life(name, veil=False):
    """A ball on a floor in a dim sky, a lamp, a glowing face, glass beside it."""
    b = SceneBuilder("still life")
    tested = b.add_material("tested", SURFACES.get(name, ()), closures=CLOSURES.get(name, ()))
    b.add_mesh("ball", *scenes.sphere((0, 0, 0.5), 0.5, 2), tested)
    b.add_mesh("floor", *scenes.plane(2.0), b.add_material("floor", [diffuse(0.5)]))
    glass = b.add_material("ice", [dielectric(1.5)])
    b.add_mesh("ice", *scenes.box((0.7, -0.3, 0.2), (1.0, 0.3, 0.8)), glass)
    glow = b.add_material("glow", [], emission=(2.0, 1.0, 0.5))
    b.add_mesh("glow", *scenes.box((-1.2, -0.3, 0.2), (-0.9, 0.3, 0.6)), glow)
    if veil:
        material = b.add_material("veil", [transparent(0.6), diffuse(0.3)])
        b.add_mesh("veil", *scenes.plane(0.6, 1.4), material)
    b.add_point_light("lamp", (1.0, -1.5, 2.5), 5.0)
    b.set_world((0.1, 0.15, 0.2))
    b.set_camera(scenes.camera((0, -2.5, 2.0), (0, 0, 0.4), 16, 12))
    return b.build()


def summed(film):
    """(direct + indirect) x colour over all kinds, emission and environment: (h, w, 3)."""
    total = film.resolve("seen_emission") + film.resolve("environment")
    for name in KIND_LAYERS:
        total = total + film.resolve(name) * film.resolve(f"{name.split('_')[0]}_color")
    return total


@pytest.mark.parametrize("name", [*SURFACES, *CLOSURES])
def test_the_kinds_make_the_picture(name, monkeypatch):
    scene = still_life(name)
    film = film_of(scene, ASKED)
    combined = film.resolve("combined")[..., :3]
    np.testing.assert_allclose(summed(film), combined, rtol=2e-4, atol=2e-6)
    # Caustics by kind have discs alone, so the plain picture gets them too.
    monkeypatch.setattr(light_image, "connected_share", np.zeros_like)
    plain = film_of(scene, BASE)
    np.testing.assert_allclose(plain.resolve("combined")[..., :3], combined, rtol=1e-6)


def test_behind_a_veil_the_kinds_make_the_picture_on_average():
    """What shows through it is chosen at random for light, and seen by its share for data."""
    film = film_of(still_life("plastic", veil=True), replace(ASKED, passes=96))
    combined = film.resolve("combined")[..., :3]
    assert summed(film).mean() == pytest.approx(combined.mean(), rel=0.02)


def test_threads_and_chunks_change_no_bit():
    scene = still_life("mixture")
    one = film_of(scene, ASKED)
    other = film_of(scene, replace(ASKED, threads=3, chunk_size=37))
    for name in KIND_LAYERS:
        assert (one.resolve(name) == other.resolve(name)).all(), name


def test_a_lamp_in_a_mirror_is_direct_and_through_two_faces_of_glass_is_not():
    for lobes, kind, direct in (
        ([mirror(1.0)], "glossy", True),
        ([dielectric(1.5)], "transmission", False),
    ):
        b = SceneBuilder("one kind")
        b.add_mesh("slab", *scenes.box((-4, -4, -0.2), (4, 4, 0)), b.add_material("m", lobes))
        b.set_world((1.0, 1.0, 1.0))
        b.set_camera(scenes.camera((0, -1, 4), (0, 0, 0), 6, 6))
        film = film_of(b.build(), replace(ASKED, passes=32))
        ways = {way: film.resolve(f"{kind}_{way}").mean() for way in ("direct", "indirect")}
        assert ways["direct" if direct else "indirect"] == pytest.approx(1.0, rel=0.02)
        assert ways["indirect" if direct else "direct"] == 0.0
        assert film.resolve("diffuse_direct").max() == 0.0


def test_the_kinds_need_their_colours_and_are_kept_only_when_asked_for():
    with pytest.raises(ValueError, match="diffuse_color"):
        Settings(light_kinds=True)
    with pytest.raises(ValueError, match="ask for it"):
        film_of(still_life("diffuse"), replace(BASE, passes=1)).resolve("glossy_direct")
