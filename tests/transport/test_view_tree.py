"""View rays that split at glass: exact without chance, of the same mean, not there when off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.bsdf.dispatch import smooth_glass
from photon_map.core.camera_pass import chunk, light_image
from photon_map.core.camera_pass.chunk import trace_chunk
from photon_map.core.camera_pass.pixels import Pixels, Region
from photon_map.core.film.layers import KIND_COLORS
from photon_map.core.photon_pass import photon_maps
from photon_map.core.pilot import no_radii
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.closures import rough_glass
from photon_map.core.scene.lobes import Lobe, dielectric, diffuse, mirror
from photon_map.core.scene.scene import Scene
from photon_map.core.scene.tables import LOBE, MATERIAL
from photon_map.tests.scenes import camera, cornell_glass, glass_slab, plane

IOR = 1.5
GLASS = dielectric(IOR)
ALONE = Settings(
    passes=1,
    photons_global=0,
    photons_caustic=0,
    pixel_filter="BOX",
    filter_width=1.0,
    split_depth=0,
)


def slab_over(ground: list, world: float, body: Lobe = GLASS) -> Scene:
    """A slab of ``body`` between the camera, which looks down, and a glowing or dark ground."""
    b = SceneBuilder("slab")
    b.add_mesh("slab", *glass_slab(IOR), b.add_material("body", [body]))
    glow = b.add_material("ground", ground, emission=(1 - world,) * 3)
    b.add_mesh("ground", *plane(40.0), glow)
    b.set_world((world,) * 3)
    b.set_camera(camera((0, 0, 2), (0, 0, 0), 8, 8, fov=0.1))
    return b.build()


@pytest.mark.parametrize("world", [0.0, 1.0])
def test_the_whole_tree_leaves_nothing_to_chance(world: float):
    """A slab lets 2 n / (n^2 + 1) through and mirrors the rest, in one pass of one path."""
    scene = slab_over([mirror(0.0)], world)
    whole = replace(ALONE, split_depth=16, split_least=1e-6, min_throughput=1e-9)
    through = 2 * IOR / (IOR * IOR + 1)
    expected = through if world == 0.0 else 1.0 - through
    image = final(scene, whole)
    np.testing.assert_allclose(image, expected, rtol=2e-3)
    assert final(scene, ALONE).std() > 0.05, "by chance a pixel sees one of the two"


@pytest.mark.parametrize("least", [0.3, 0.02, 1e-4])
def test_the_mean_is_that_of_chance(least: float):
    """Cornell box with a glass ball, each seed with the same photons; t-test at 0.1 %."""
    scene = cornell_glass(16, smooth=True, subdivisions=3)
    settings = Settings(passes=4, photons_global=2000, photons_caustic=2000, split_depth=0)
    split = replace(settings, split_depth=4, split_least=least)
    means = [
        [final(scene, replace(chosen, seed=seed)).mean() for seed in range(8)]
        for chosen in (settings, split)
    ]
    difference = np.subtract(*means)
    deviation = difference.std(ddof=1) / np.sqrt(8)
    assert abs(difference.mean()) < 5.41 * deviation
    assert deviation < 0.005 * np.mean(means)


def test_off_nothing_of_it_is_called(monkeypatch: pytest.MonkeyPatch):
    def fail(*_: object) -> None:
        raise AssertionError("called")

    monkeypatch.setattr(chunk, "split", fail)
    glass = slab_over([diffuse(0.5)], 1.0)
    assert np.isfinite(final(glass, ALONE)).all()
    no_glass = slab_over([diffuse(0.5)], 1.0, mirror(0.5))
    assert np.isfinite(final(no_glass, replace(ALONE, split_depth=2))).all()
    with pytest.raises(AssertionError, match="called"):
        final(glass, replace(ALONE, split_depth=2))


def test_only_smooth_glass_that_is_the_same_everywhere_splits():
    b = SceneBuilder("materials")
    rows = {
        b.add_material("glass", [dielectric(IOR)]): True,
        b.add_material("tinted", [dielectric(IOR, (0.9, 0.2, 0.1))]): True,
        b.add_material("mixture", [dielectric(IOR, 0.5), diffuse(0.5)]): False,
        b.add_material("mirror", [mirror(0.9)]): False,
        b.add_material("frosted", closures=[rough_glass(IOR, 0.3)]): False,
        b.add_material("bumpy", [dielectric(IOR)], bump_texture=0): False,
        b.add_material("nothing"): False,
    }
    rows[b.add_material("veil", [dielectric(IOR)], passes=True)] = False
    found = smooth_glass(np.array(b._materials, MATERIAL), np.array(b._lobes, LOBE))
    assert found.tolist() == list(rows.values())


def test_costs_that_the_balance_counts_are_those_of_more_gather_rays():
    """Branches share their path's gather rays: their number goes with ``gather_rays``.

    Eight passes know the number of rays with one gather ray to 0.4 % (1 standard deviation).
    """
    scene = cornell_glass(48)
    settings = Settings(photons_global=2000, photons_caustic=2000)
    prepared = prepare(scene, settings)
    region, pixels = Region(0, 0, 48, 48, 48), 48 * 48
    maps = photon_maps(settings, no_radii(), 0, [], [])
    gathered, others = {}, {}
    for depth in (0, 4):
        for rays in (1, 4):
            chosen = replace(settings, split_depth=depth, gather_rays=rays)
            chunks = [
                trace_chunk(prepared, chosen, region, Pixels.spread(i, pixels), maps)
                for i in range(8)
            ]
            gathered[depth, rays] = sum(chunk.gathered for chunk in chunks)
            others[depth, rays] = sum(chunk.rays - chunk.gathered for chunk in chunks)
        assert gathered[depth, 4] == pytest.approx(4 * gathered[depth, 1], rel=0.02)
        assert others[depth, 4] == others[depth, 1]
    assert gathered[4, 4] == pytest.approx(gathered[0, 4], rel=0.02)
    assert others[4, 4] > others[0, 4]


def test_chunks_and_threads_change_nothing():
    scene = cornell_glass(16)
    settings = Settings(passes=2, split_depth=3, photons_global=500, photons_caustic=500)
    one = final(scene, replace(settings, chunk_size=37, threads=1))
    assert (one == final(scene, replace(settings, threads=2))).all()


def test_light_by_kind_is_that_of_the_same_picture(monkeypatch):
    """Each branch has a row of its own, so kinds are known behind splits as well."""
    # Caustics by kind have discs alone, so the plain picture gets them too.
    monkeypatch.setattr(light_image, "connected_share", np.zeros_like)
    scene = cornell_glass(16)
    settings = Settings(passes=2, photons_global=500, photons_caustic=500)
    kinds = replace(settings, light_kinds=True, first_hit=tuple(KIND_COLORS))
    np.testing.assert_allclose(final(scene, kinds), final(scene, settings), rtol=1e-6)


def final(scene: Scene, settings: Settings) -> np.ndarray:
    """The picture."""
    *_, last = render(scene, settings)
    return last.film.resolve("combined")[..., :3]
