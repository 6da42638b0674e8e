"""Guided gather rays: densities, zones and what is learnt (fixed seeds)."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings
from photon_map.core.bsdf.dispatch import WIDE, cosine_share, pdf_part
from photon_map.core.camera_pass.chunk import trace_camera
from photon_map.core.camera_pass.guide import (
    BINS,
    copy_places,
    guided_ratio,
    guided_share,
    no_guide,
    side_of,
    warp_square,
    zone_of,
)
from photon_map.core.camera_pass.indirect import start_gather
from photon_map.core.camera_pass.pixels import Pixels, Region
from photon_map.core.camera_pass.rays import Rays
from photon_map.core.camera_pass.records import PATH, VERTEX
from photon_map.core.film.film import SAMPLE
from photon_map.core.guide_zones import FLOOR, PLACES, Learnt, find_zones
from photon_map.core.prepared import prepare
from photon_map.core.sampling.warps import sample_disk, square_of_disk
from photon_map.core.scene.lobes import Lobe, ggx, oren_nayar
from photon_map.tests.guides import MIXED, random_guide
from photon_map.tests.scenes import floor_scene
from photon_map.tests.statistics import chi_square


def test_the_square_is_found_back_from_the_disc():
    for u, v in np.random.default_rng(1).random((2000, 2)):
        assert square_of_disk(*sample_disk(u, v)) == pytest.approx((u, v), abs=1e-12)
    assert square_of_disk(0.0, 0.0) == (0.5, 0.5)


def test_a_warped_square_has_the_density_of_its_bins():
    guide = random_guide(np.zeros((1, 3)), np.array([4], np.int32))
    uv = np.random.default_rng(2).random((60_000, 2))
    warped, density = np.split(np.array([warp_square(guide, 0, u, v) for u, v in uv]), [2], 1)
    row, column = (warped * BINS).astype(int).T
    assert (density[:, 0] == guide.density[0, row, column]).all()
    assert warped.min() >= 0.0 and warped.max() < 1.0
    fine = np.histogram2d(*warped.T, 2 * BINS, ((0, 1), (0, 1)))[0]
    expected = np.kron(guide.density[0], np.ones((2, 2))) * len(uv) / (2 * BINS) ** 2
    chi_square(fine, expected)


def test_a_stratified_square_stays_stratified():
    """Along the rows each stratum holds one point, as the share of its row says."""
    guide = random_guide(np.zeros((1, 3)), np.array([4], np.int32))
    u = (np.arange(1000) + 0.5) / 1000
    rows = np.array([warp_square(guide, 0, a, 0.5)[0] for a in u])
    assert (np.diff(rows) > 0).all()
    counts = np.histogram(rows, BINS, (0, 1))[0]
    assert np.abs(counts - 1000 * guide.density[0].mean(axis=1) / BINS).max() < 1.0


@pytest.mark.parametrize("lobes", [MIXED, [oren_nayar(0.6, 0.9)]], ids=["mixed", "diffuse"])
def test_gather_rays_have_the_density_that_they_tell(lobes: list[Lobe]):
    """Chi-square over the halves of all bins, and the sides, against the integrated density."""
    count = 60_000
    scene = floor_scene(lobes, size=1).build()
    settings = Settings()
    prepared = prepare(scene, settings)
    region, one = Region(0, 0, 1, 1, 1), Pixels.spread(0, 1)
    rays, samples = Rays(prepared, 1), np.zeros(1, SAMPLE)
    seen = trace_camera(prepared, settings, region, one, rays, samples)
    place = seen.vertices[:1].copy()
    # Looked at from the side, so that the glossy lobe leans.
    place["wo"][0] = (0.6, 0.0, 0.8)
    n, wo = (tuple(place[name][0]) for name in ("ns", "wo"))
    guide = random_guide(place["p"], np.array([side_of(n)], np.int32))
    many = np.empty(count, VERTEX)
    copy_places(place, count, 0, many)
    origins, directions = np.zeros((2, count, 3), np.float32)
    paths = np.zeros(count, PATH)
    sent = start_gather(
        1, 1, guide, prepared.materials, seen.lobes, many, count, origins, directions, paths
    )
    wi = paths["direction"][:sent]

    def density(d: np.ndarray) -> float:
        bsdf = pdf_part(place[0], seen.lobes, n, wo, tuple(d), WIDE)
        share = guided_share(0, place[0], seen.lobes)
        return bsdf * guided_ratio(guide, 0, share, n, tuple(d), bsdf)

    told = [density(d) for d in wi[:500]]
    np.testing.assert_allclose(paths["pdf_w"][:500], told, rtol=1e-9)
    above = wi @ n > 0
    square = np.array([square_of_disk(x, y) for x, y, _ in wi[above]])
    observed = np.histogram2d(*square.T, 2 * BINS, ((0, 1), (0, 1)))[0]
    nodes, weights = np.polynomial.legendre.leggauss(6)
    at = (np.arange(2 * BINS)[:, None] + 0.5 + 0.5 * nodes) / (2 * BINS)
    expected = np.zeros_like(observed)
    for row in range(2 * BINS):
        for column in range(2 * BINS):
            for a, u in zip(weights, at[row], strict=True):
                for b, v in zip(weights, at[column], strict=True):
                    x, y = sample_disk(u, v)
                    z = np.sqrt(1 - x * x - y * y)
                    relative = density(np.array((x, y, z))) * np.pi / z
                    expected[row, column] += a * b / 4 * relative
    expected *= count / (2 * BINS) ** 2
    shares = seen.lobes["share"][place["lobe_start"][0] :][: len(lobes)]
    below = count * shares[2] / shares.sum() if lobes is MIXED else 0.0
    rest = count - expected.sum() - below
    assert -1e-3 * count < rest < 0.1 * count, "what the facets send into the ground"
    table = np.array([*observed.ravel(), (~above).sum(), count - sent])
    chi_square(table, np.array([*expected.ravel(), below, max(rest, 0.0)]), tests=2)


def test_each_place_lies_in_a_zone_of_its_side():
    random = np.random.default_rng(3)
    places = random.normal(0, 1, (1000, 3))
    normals = random.normal(0, 1, (1000, 3))
    side = np.array([side_of(tuple(n)) for n in normals], np.int32)
    assert set(side) == set(range(6))
    guide = find_zones(places, side).guide
    found = np.array(
        [zone_of(guide, tuple(p), tuple(n)) for p, n in zip(places, normals, strict=True)]
    )
    assert found.min() == 0 and found.max() == guide.zones - 1
    for k in range(guide.zones):
        assert len(set(side[found == k])) == 1
        assert PLACES // 2 <= (found == k).sum() <= PLACES
    assert zone_of(guide, (50.0, 0.0, 0.0), (0.0, 0.0, 1.0)) == -1
    assert zone_of(no_guide(), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)) == -1


def test_a_side_without_places_guides_nothing():
    assert find_zones(np.zeros((500, 3)), np.full(500, 2, np.int32)).guide.zones == 1
    guide = find_zones(np.zeros((5, 3)), np.full(5, -1, np.int32)).guide
    assert guide.zones == 0
    guide = find_zones(np.zeros((5, 3)), np.full(5, 3, np.int32)).guide
    assert zone_of(guide, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)) == -1
    assert zone_of(guide, (0.0, 0.0, 0.0), (0.0, -1.0, 0.0)) == 0


def test_densities_go_with_the_root_of_the_mean_square():
    random = np.random.default_rng(4)
    truth = random.lognormal(0.0, 1.0, BINS * BINS)
    learnt = Learnt(find_zones(np.zeros((1, 3)), np.array([4], np.int32)))
    bins = np.repeat(np.arange(BINS * BINS, dtype=np.int32), 4000)
    # Bins that got more rays than others teach the same.
    bins = np.concatenate([bins, np.zeros(100_000, np.int32)])
    learnt.add(np.zeros(len(bins), np.int32), bins, truth[bins])
    root = np.sqrt(truth)
    expected = FLOOR + (1 - FLOOR) * root / root.mean()
    found = learnt.guide().density.ravel()
    np.testing.assert_allclose(found, expected, rtol=0.02)
    assert found.mean() == pytest.approx(1.0)


def test_nothing_learnt_is_the_bsdf_itself():
    learnt = Learnt(find_zones(np.zeros((1, 3)), np.array([4], np.int32)))
    np.testing.assert_allclose(learnt.guide().density, 1.0)
    nothing, bins = np.zeros(9, np.int32), np.arange(9, dtype=np.int32)
    learnt.add(nothing, bins, np.zeros(9))
    np.testing.assert_allclose(learnt.guide().density, 1.0)


def test_a_zone_of_few_rays_leans_on_what_lies_around():
    """Two halves of one side; one was met by a single ray, the other by many."""
    places = np.zeros((2 * PLACES, 3))
    places[:, 0] = np.arange(2 * PLACES)
    zones = find_zones(places, np.full(2 * PLACES, 4, np.int32))
    assert zones.guide.zones == 2
    learnt = Learnt(zones)
    bins = np.repeat(np.arange(BINS * BINS, dtype=np.int32), 1000)
    square = np.where(bins == 7, 100.0, 1.0)
    learnt.add(np.zeros(len(bins), np.int32), bins, square)
    learnt.add(np.ones(1, np.int32), np.array([3], np.int32), np.array([5.0]))
    known, guessed = learnt.guide().density.reshape(2, -1)
    assert guessed.argmax() == known.argmax() == 7
    np.testing.assert_allclose(guessed[7], known[7], rtol=0.05)


def test_only_cosine_lobes_are_guided():
    scene = floor_scene([ggx(0.5, 0.7)], size=1).build()
    prepared = prepare(scene, Settings())
    surface = np.zeros(1, VERTEX)
    surface["lobe_start"] = prepared.materials["lobe_start"][-1]
    surface["lobe_count"] = 1
    assert cosine_share(surface[0], prepared.lobes, WIDE) == 0.0
