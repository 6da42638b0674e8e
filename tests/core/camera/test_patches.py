"""Patches that gather rays share: what they keep apart, and that they only save work."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from photon_map.core.camera_pass.indirect import gather_indirect
from photon_map.core.camera_pass.patches import (
    APART,
    EDGE,
    HALVES,
    PATCH,
    SMALL_EDGE,
    WAYS,
    WHOLE,
    known,
    middle_of_half,
    place_of,
    remember,
    row_of,
)
from photon_map.core.camera_pass.records import VERTEX
from photon_map.core.film.film import SAMPLE
from photon_map.core.geometry.borders import joined as all_of
from photon_map.core.geometry.borders import short
from photon_map.core.geometry.crossings import crossings
from photon_map.core.geometry.intersector import Intersector
from photon_map.core.photons.coverage import border_grid
from photon_map.core.photons.photon_map import build_photon_map
from photon_map.core.photons.sight import SIGHT
from photon_map.core.photons.trace import PHOTON, Walk
from photon_map.core.scene.builder import SceneBuilder, diffuse, phong
from photon_map.tests import scenes
from photon_map.tests.meshes import all_borders, joined, surfaces_of
from photon_map.tests.statistics import same_means

RADIUS = 0.1
UP = (0.0, 0.0, 1.0)


def borders(*parts):
    mesh = joined(*parts)
    surfaces = surfaces_of(mesh, [len(faces) for _, faces in parts])
    holds = np.ones(len(mesh.faces), bool)
    met = short(crossings(surfaces, holds, Intersector(mesh), RADIUS), RADIUS, 10**6)
    return border_grid(all_of(all_borders(mesh, RADIUS), met), RADIUS)


def photons(rng, count, low, high):
    """Even light of 1 W/m^2 straight down on z = 0, x from ``low`` to ``high``, y +- 1."""
    table = np.zeros(count, PHOTON)
    table["position"][:, 0] = rng.uniform(low, high, count)
    table["position"][:, 1] = rng.uniform(-1, 1, count)
    table["normal"] = table["direction"] = UP
    table["flux"] = 2 * (high - low) / count
    return build_photon_map([Walk(table, np.arange(count), 0)], RADIUS)


def ends(rng, count, x):
    """Where gather rays ended on z = 0, at ``x``; a pixel each."""
    vertices = np.zeros(count, VERTEX)
    vertices["p"][:, 0] = x
    vertices["p"][:, 1] = rng.uniform(-0.8, 0.8, count)
    vertices["ng"] = vertices["ns"] = vertices["wo"] = UP
    vertices["beta"] = np.pi
    vertices["slot"] = np.arange(count)
    vertices["lobe_count"] = 1
    vertices["entering"] = 1
    return vertices


def light(photon_map, grid, vertices, patches=None, order=None, lobe=None):
    """The indirect layer (N,) of ``vertices`` with an albedo of 1: the irradiance."""
    b = SceneBuilder("ends")
    b.add_material("tested", [lobe or diffuse(1.0)])
    patches = np.zeros(1 << 12, PATCH) if patches is None else patches
    order = np.arange(len(vertices)) if order is None else order
    samples = np.zeros(len(vertices), SAMPLE)
    gather_indirect(
        b.build().lobes, photon_map, grid, RADIUS, vertices, order, samples, np.zeros(SIGHT),
        patches,
    )  # fmt: skip
    return samples["indirect"][:, 0]


@pytest.fixture
def rng():
    return np.random.default_rng(5)


@pytest.fixture
def floor():
    return borders(scenes.plane())


def test_rays_that_end_in_a_patch_share_an_estimate_and_keep_the_mean(rng, floor):
    vertices = ends(rng, 4000, rng.uniform(-0.8, 0.8, 4000))
    shared = [light(photons(rng, 4000, -1, 1), floor, vertices).mean() for _ in range(40)]
    found = light(photons(rng, 4000, -1, 1), floor, vertices)
    most = (1.6 / (EDGE * RADIUS) + 1) ** 2
    assert len(np.unique(found)) < most < len(vertices)
    same_means(np.mean(shared), np.var(shared, ddof=1) / 40, 1.0)


def test_who_asks_first_changes_no_bit(rng, floor):
    vertices = ends(rng, 3000, rng.uniform(-1, 1, 3000))
    vertices["p"][:, 2] = rng.normal(0, 1e-7, 3000)
    lit = photons(rng, 20000, -1, 1)
    first = light(lit, floor, vertices)
    tiny = np.zeros(1, PATCH)  # forgets every patch at once
    for order, room in ((np.arange(3000)[::-1].copy(), None), (rng.permutation(3000), tiny)):
        np.testing.assert_array_equal(light(lit, floor, vertices, room, order), first)


def test_threads_share_a_table_without_a_changed_bit(rng, floor):
    """In 8 rows the threads overwrite each other all the time."""
    vertices = ends(rng, 20000, rng.uniform(-1, 1, 20000))
    lit = photons(rng, 20000, -1, 1)
    alone = light(lit, floor, vertices)
    patches = np.zeros(8, PATCH)
    orders = [rng.permutation(20000) for _ in range(12)]
    with ThreadPoolExecutor(6) as pool:
        for found in pool.map(lambda o: light(lit, floor, vertices, patches, o), orders):
            np.testing.assert_array_equal(found, alone)


def test_places_that_meet_in_a_row_are_all_remembered():
    """As many as there are ways; one more puts one of them out."""
    patches = np.zeros(64, PATCH)
    places = [np.uint64((k << 58) + 9) for k in range(WAYS + 1)]
    for place in places[:WAYS]:
        remember(patches[row_of(patches, place)], place, WHOLE, UP, UP)
    assert [known(patches[row_of(patches, p)])[0] for p in places[:WAYS]] == places[:WAYS]
    row = row_of(patches, places[WAYS])
    assert known(patches[row])[0] in places[:WAYS]


@pytest.mark.parametrize("turn", [0.1, 0.6, 1.2, 2.5, 4.0])
def test_the_middle_of_a_part_lies_in_it(turn):
    """A line moves through a patch: until the corner where it leaves, both parts have one."""
    normal = (np.cos(turn), np.sin(turn), 0.0)
    corner = 0.5 * (abs(normal[0]) + abs(normal[1]))
    had = set()
    for away in np.linspace(-0.999, 0.999, 101) * corner:
        for beyond in (False, True):
            there, q = middle_of_half((0.0, 0.0, 0.0), UP, normal, away, beyond, 1.0)
            small = (away > 0.0) == beyond
            had.add((there, small))
            if there:
                assert max(abs(np.array(q))) <= 0.5
                assert (np.dot(q, normal) > away) == beyond
    assert had == {(True, False), (True, True), (False, True)}


def test_parts_of_two_answers_fit_neither_key(rng):
    """What a thread may read while another writes: each of the eight words old or new."""
    rows = np.zeros(2, PATCH)
    whole = (0.5, 0.5, 0.0)
    remember(rows[0], np.uint64(7), WHOLE, whole, whole)
    remember(rows[1], np.uint64(8), HALVES, (0.25, 0.25, 0.0), (0.25, 0.0, 0.0))
    for row, key, cut in ((rows[0], 7, WHOLE), (rows[1], 8, HALVES)):
        assert known(row)[:2] == (key, cut)
    words = rows.view(np.uint64).reshape(2, 8)
    torn = np.zeros(1, PATCH)
    for k in range(2**8):
        torn.view(np.uint64)[:] = np.where(k >> np.arange(8) & 1, words[1], words[0])
        key, *found = known(torn[0])
        for row, of in ((rows[0], 7), (rows[1], 8)):
            assert key != of or found == list(known(row)[1:])


@pytest.mark.parametrize("apart", ["crossing", "beside"])
def test_no_patch_reaches_through_a_wall(rng, apart):
    """Half of the patches that the wall runs through have their middle in the light."""
    wall = scenes.quad((0.003, -1, -1), (0.003, 1, -1), (0.003, 1, 1), (0.003, -1, 1))
    if apart == "crossing":
        grid = borders(scenes.plane(), wall)
    else:
        left = scenes.quad((-1, -1, 0), (0.003, -1, 0), (0.003, 1, 0), (-1, 1, 0))
        right = scenes.quad((0.003, -1, 0), (1, -1, 0), (1, 1, 0), (0.003, 1, 0))
        grid = borders(left, right, wall)
    lit = photons(rng, 40000, 0.003, 1)
    dark = ends(rng, 2000, rng.uniform(-0.05, 0.0029, 2000))
    middles = np.array([place_of(p, UP, RADIUS, True, EDGE)[1] for p in dark["p"]])
    assert (middles[:, 0] > 0.003).any(), "the test would see nothing"
    assert light(lit, grid, dark).max() == 0.0
    bright = ends(rng, 2000, rng.uniform(0.0031, 0.05, 2000))
    assert light(lit, grid, bright).mean() == pytest.approx(1.0, abs=0.1)


def test_both_sides_of_a_sheet_have_patches_of_their_own(rng, floor):
    vertices = ends(rng, 500, 0.0)
    below = vertices.copy()
    below["ng"] = below["ns"] = below["wo"] = (0.0, 0.0, -1.0)
    below["entering"] = 0
    patches = np.zeros(1 << 12, PATCH)
    lit = photons(rng, 20000, -1, 1)
    assert light(lit, floor, vertices, patches).min() > 0.5
    assert light(lit, floor, below, patches).max() == 0.0


def test_glossy_places_are_estimated_one_by_one(rng, floor):
    vertices = ends(rng, 300, rng.uniform(-0.5, 0.5, 300))
    vertices["wo"] = rng.normal(0, 0.3, (300, 3)) + UP
    vertices["wo"] /= np.linalg.norm(vertices["wo"], axis=1)[:, None]
    lobe = phong(0.5, 2)
    assert len(np.unique(light(photons(rng, 20000, -1, 1), floor, vertices, lobe=lobe))) > 290


def kept_by(grid, vertices, lit):
    """Light of ``vertices``, and which sorts of patches were made for them."""
    patches = np.zeros(1 << 14, PATCH)
    return light(lit, grid, vertices, patches), patches["cut"][patches["seal"] != 0]


def test_a_border_makes_two_halves_that_are_shared(rng):
    """A table's edge runs through patches at a slant: their light is even up to it."""
    s = np.sqrt(0.5)
    corners = [(-0.9, 0, 0), (0, -0.9, 0), (0.9, 0, 0), (0, 0.9, 0)]
    grid = borders(scenes.quad(*corners))
    lit = photons(rng, 40000, -1, 1)
    on = np.abs(lit.places[:, 0]) + np.abs(lit.places[:, 1]) < 0.9
    lit.photons["flux"][~on] = 0.0
    along, inside = rng.uniform(-0.4, 0.4, 4000), rng.uniform(0.004, 0.03, 4000)
    vertices = ends(rng, 4000, 0.0)
    edge = np.array([0.45, 0.45, 0.0])
    vertices["p"] = edge + along[:, None] * [s, -s, 0] - inside[:, None] * [s, s, 0]
    found, cut = kept_by(grid, vertices, lit)
    assert {WHOLE, HALVES} <= set(cut)
    assert len(np.unique(found)) < len(vertices) / 10
    assert found.mean() == pytest.approx(1.0, abs=0.03)


def test_where_lines_cross_patches_are_smaller(rng):
    """Walls that cross in the middle of patches: each quarter keeps its own light."""
    walls = [
        scenes.quad((0.003, -1, -1), (0.003, 1, -1), (0.003, 1, 1), (0.003, -1, 1)),
        scenes.quad((-1, 0.004, -1), (1, 0.004, -1), (1, 0.004, 1), (-1, 0.004, 1)),
    ]
    grid = borders(scenes.plane(), *walls)
    lit = photons(rng, 1_000_000, -1, 1)
    bright = (lit.places[:, 0] > 0.003) == (lit.places[:, 1] > 0.004)
    lit.photons["flux"][~bright] = 0.0
    vertices = ends(rng, 4000, rng.uniform(-0.03, 0.03, 4000))
    vertices["p"][:, 1] = rng.uniform(-0.03, 0.03, 4000)
    x, y = vertices["p"][:, 0] - 0.003, vertices["p"][:, 1] - 0.004
    seen = (x > 0) == (y > 0)
    clear = np.minimum(abs(x), abs(y)) > 1e-4
    found, cut = kept_by(grid, vertices, lit)
    assert {WHOLE, HALVES, APART} <= set(cut)
    assert found[clear & ~seen].max() == 0.0
    assert found[clear & seen].mean() == pytest.approx(1.0, abs=0.04)
    assert len(np.unique(found)) < len(vertices) / 2


def test_patches_of_both_sizes_have_keys_of_their_own():
    places = np.random.default_rng(2).uniform(-1, 1, (200, 3)) * [1, 1, 0]
    keys = [
        {place_of(tuple(p), UP, RADIUS, True, edge)[0] for p in places}
        for edge in (EDGE, SMALL_EDGE)
    ]
    assert not keys[0] & keys[1]
