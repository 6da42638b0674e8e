"""Caustic photons connected with the camera: right for every lens, filter and veil."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import Settings, bake, path_density, render
from photon_map.core.camera_pass import light_image
from photon_map.core.camera_pass.connections import SEEN, Connected
from photon_map.core.camera_pass.light_image import (
    COUNTED,
    FEW,
    WINDOWS,
    Expected,
    bytes_of_connected,
    bytes_of_image,
    connected_share,
    density,
    expected_from,
    photons_around,
    why_not,
)
from photon_map.core.camera_pass.pixels import Region
from photon_map.core.film.filters import covered_pixels, filter_table
from photon_map.core.film.layers import KIND_COLORS
from photon_map.core.photon_memory import Budget, Stored
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse
from photon_map.core.scene.lobes import mirror as silver
from photon_map.core.scene.lobes import transparent
from photon_map.core.scene.tables import Visibility
from photon_map.tests import scenes
from photon_map.tests.statistics import same_means


@pytest.mark.parametrize("kind", ["BOX", "GAUSSIAN", "BLACKMAN_HARRIS"])
def test_the_filters_density_is_that_of_its_offsets(kind, rng):
    table = filter_table(kind, 1.5)
    reach = table[0, -1]
    middle = (np.arange(6000) + 0.5) / 6000 * 2.2 * reach - 1.1 * reach
    values = np.array([density(table, t) for t in middle])
    assert values.mean() * 2.2 * reach == pytest.approx(1.0, rel=1e-3)
    low, high = -0.3 * reach, 0.1 * reach
    share = np.interp([low, high], table[0], table[1])
    inside = (middle > low) & (middle < high)
    found = values[inside].sum() * 2.2 * reach / 6000
    assert found == pytest.approx(share[1] - share[0], rel=2e-3)
    assert density(table, 1.01 * reach) == density(table, -1.01 * reach) == 0.0


def test_a_filter_covers_as_many_pixels_as_its_square_has():
    for width in (0.01, 1.0, 2.5):
        assert covered_pixels(filter_table("BOX", width)) == pytest.approx(width**2)
    # The window's equivalent noise bandwidth is 2.0044 (Harris 1978, table 1); 3 pixels here.
    found = covered_pixels(filter_table("BLACKMAN_HARRIS", 1.5))
    assert found == pytest.approx((3.0 / 2.0044) ** 2, rel=1e-3)


def test_few_photons_of_a_narrow_filter_give_way_to_discs(monkeypatch: pytest.MonkeyPatch):
    """Scatter of pixels over 8 seeds, with what the filter covers and with whole pixels."""
    scene, settings = pane(), replace(ALONE, passes=8, pixel_filter="BOX", filter_width=0.51)

    def scatter() -> float:
        seeds = [replace(settings, seed=k) for k in range(8)]
        films = [last_of(scene, one).film.resolve("caustics")[..., :3] for one in seeds]
        return float(np.std(films, axis=0).mean() / np.mean(films))

    mixed = scatter()
    with monkeypatch.context() as patched:
        patched.setattr(light_image, "covered_pixels", lambda table: 1.0)
        assert scatter() > 1.2 * mixed, "a whole pixel's photons would make the same noise"
    none = last_of(scene, replace(settings, filter_width=0.4)).plan
    (stage,) = [stage for stage in none.stages if stage.name == "connections"]
    assert not stage.on and "half a pixel" in stage.reason


def test_discs_give_way_as_photons_come():
    so_far = np.array([0.0, 0.1, FEW, 100.0])
    share = connected_share(so_far)
    assert share[0] == 0.0
    assert (np.diff(share) > 0).all() and share[-1] < 1.0
    assert share[2] == pytest.approx(0.5)


def seen_at(places):
    rows = np.zeros(len(places), SEEN)
    rows["x"], rows["y"] = np.array(places, float).T
    return rows


def places(rows):
    return np.stack([rows["x"], rows["y"]], axis=1)


def test_photons_are_counted_in_squares_that_hold_some():
    dense = seen_at([(40.2 + 0.2 * k, 30.5) for k in range(9)])
    region = Region(0, 0, 160, 120, 160)
    found = photons_around(dense, places(dense), region).reshape(120, 160)
    # Nine photons in 40 and 41.
    assert found[30, 40] == pytest.approx(9.5 / WINDOWS[0] ** 2)
    # Nine pixels aside only the third square holds enough; far off there is none at all.
    assert found[30, 50] == pytest.approx(9.5 / WINDOWS[2] ** 2)
    assert found[110, 150] == pytest.approx(0.5 / WINDOWS[-1] ** 2)
    assert COUNTED < 9


def test_discs_are_left_alone_where_few_rays_arrive():
    seen = seen_at([(40.5, 30.5)] * 8 + [(100.5, 30.5)] * 4)
    sent = np.concatenate([places(seen), np.tile((100.5, 30.5), (60, 1))])
    region = Region(0, 0, 160, 120, 160)
    expected = expected_from(Connected(seen, sent, 0), region, filter_table("BOX", 3.0))
    counts = expected.counts.reshape(120, 160)
    assert counts[30, 40] > 0.0 and counts[30, 100] == 0.0
    assert connected_share(counts[30, 100]) == 0.0
    # Photons beside a pixel fall into it by the filter, one to either side.
    off = np.flatnonzero(counts[30] == 0.0)
    assert (np.flatnonzero(expected.wanted[30] == 0) == off[1:-1]).all()
    few = Connected(seen[:1], np.concatenate([sent] * 2), 0)
    assert expected_from(few, region, filter_table("BOX", 3.0)).counts is None


def test_a_border_expects_what_the_whole_picture_does(rng):
    seen = seen_at(rng.uniform((-20, -20), (84, 68), (800, 2)))
    sent = np.concatenate([places(seen), rng.uniform((-20, -20), (84, 68), (400, 2))])
    whole = photons_around(seen, sent, Region(0, 0, 64, 48, 64)).reshape(48, 64)
    part = photons_around(seen, sent, Region(10, 5, 20, 30, 64)).reshape(30, 20)
    assert (part == whole[5:35, 10:30]).all()


def pane(veil=False, mirror=False, visibility=Visibility.ALL, **options):
    """Light of a lamp that has come through a pane, on a floor that ``options`` look at."""
    b = SceneBuilder("pane")
    lobes = [diffuse((0.8, 0.5, 0.3))]
    floor = scenes.quad((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0))
    b.add_mesh("floor", *floor, b.add_material("floor", lobes), visibility=visibility)
    glass = b.add_material("glass", [dielectric(1.5)])
    b.add_mesh("pane", *scenes.glass_slab(1.5, 1.0, 1.1, 4.0), glass)
    b.add_point_light("lamp", (0.2, 0.1, 1.8), 6.0)
    if veil:
        half = b.add_material("veil", [transparent(0.5)])
        corners = ((-2, -2, 0.9), (0, -2, 0.9), (0, 2, 0.9), (-2, 2, 0.9))
        b.add_mesh("veil", *scenes.quad(*corners), half)
    if mirror:
        # Behind what is looked at: it shows the same floor again.
        wall = scenes.quad((-2, 0.1, 0), (2, 0.1, 0), (2, 0.1, 0.9), (-2, 0.1, 0.9))
        b.add_mesh("mirror", *wall, b.add_material("mirror", [silver(0.8)]))
    camera = scenes.camera((0.3, -0.6, 0.95), (0, 0, 0), 12, 12, fov=np.radians(60))
    b.set_camera(replace(camera, **options))
    return b.build()


SCENES = {
    "pinhole": {},
    "lens": {"lens_radius": 0.1, "focus_distance": 0.7},
    "parallel lens": {
        "kind": "ORTHOGRAPHIC", "ortho_scale": 1.0, "lens_radius": 0.1, "focus_distance": 0.7,
    },
    "veil": {"veil": True},
    "mirror": {"mirror": True},
}  # fmt: skip


#: Caustics alone.
ALONE = Settings(photons_caustic=4096, photons_global=0, gather_rays=1, adaptive=False)


def connect_all(monkeypatch, share):
    """Connections bring the part ``share`` of all that they can."""
    monkeypatch.setattr(light_image, "connected_share", lambda n: np.full_like(n, share))


def last_of(scene, settings):
    return list(render(scene, settings))[-1]


def thirds(scene, settings, first_seed):
    """Caustics of eight seeds (8, 3, 3), each third of a picture from below, by colour."""
    rows = []
    for seed in range(first_seed, first_seed + 8):
        image = last_of(scene, replace(settings, seed=seed)).film.resolve("caustics")
        rows.append(image.astype(np.float64).reshape(3, -1, 3).mean(axis=1))
    return np.array(rows)


def same_light(a, b, most=0.01):
    """Means of (8, 3, 3) are equal, level 1 % over all; each is known to ``most``."""
    # The colours of a third are one sum of photons: only one of them is compared.
    a, b = a.mean(axis=2), b.mean(axis=2)
    assert (b.mean(axis=0) > 0).all()
    variance = (a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / 8
    assert (np.sqrt(variance) < most * a.mean(axis=0)).all(), "the test would see nothing"
    same_means(b.mean(axis=0), variance, a.mean(axis=0), freedom=14)


@pytest.mark.parametrize("name", SCENES)
def test_connections_bring_what_discs_bring(name, monkeypatch):
    """Smooth light, so discs are right."""
    scene, settings = pane(**SCENES[name]), replace(ALONE, passes=32)
    connect_all(monkeypatch, 0.0)
    discs = thirds(scene, settings, 0)
    connect_all(monkeypatch, 1.0)
    same_light(discs, thirds(scene, settings, 20))


@pytest.mark.parametrize("kind", ["BOX", "BLACKMAN_HARRIS"])
def test_pixels_with_other_numbers_of_paths_get_no_other_light(kind, monkeypatch):
    """Shares of 0.5 to 4 paths a pass, side by side, and a share of all that is usual."""
    scene = pane()
    settings = replace(ALONE, passes=32, pixel_filter=kind, filter_width=2.0)
    monkeypatch.setattr(light_image, "connected_share", lambda n: n / (n + 30.0))
    even = thirds(scene, settings, 0)
    shares = np.tile([0.5, 1.0, 4.0, 0.7], 36)
    monkeypatch.setattr(path_density, "shares_of", lambda film, caustics: shares)
    uneven = thirds(scene, replace(settings, adaptive=True), 40)
    same_light(even, uneven)


def test_a_border_shows_what_the_whole_picture_does(monkeypatch):
    connect_all(monkeypatch, 1.0)
    scene = pane(lens_radius=0.05, focus_distance=0.7)
    settings = replace(ALONE, passes=3, pixel_filter="GAUSSIAN", filter_width=3.0)
    whole = last_of(scene, settings).film.resolve("caustics")
    part = last_of(scene, replace(settings, region=(3, 2, 9, 7))).film.resolve("caustics")
    assert (part == whole[2:7, 3:9]).all() and part.max() > 0


def test_neither_threads_nor_chunks_nor_bakes_change_a_bit(tmp_path):
    scene = pane(lens_radius=0.05, focus_distance=0.7)
    settings = replace(ALONE, passes=4, adaptive=True, threads=1)
    image = last_of(scene, settings).film.resolve("caustics")
    cut = last_of(scene, replace(settings, threads=3, chunk_size=37)).film
    assert (cut.resolve("caustics") == image).all()
    bake(scene, settings, tmp_path / "pane.pmap")
    baked = replace(settings, photon_maps=str(tmp_path / "pane.pmap"), stale_maps="REFUSE")
    assert (last_of(scene, baked).film.resolve("caustics") == image).all()


def stage_of(update):
    return next(stage for stage in update.plan.stages if stage.name == "connections")


def test_they_are_off_where_nothing_is_seen_at_once_or_nothing_could_be_told():
    on = stage_of(last_of(pane(), replace(ALONE, passes=1)))
    assert on.on and "need no disc" in on.reason
    off = {
        "by kind": replace(ALONE, passes=1, light_kinds=True, first_hit=KIND_COLORS),
        "a draft": replace(ALONE, passes=1, draft=True),
    }
    for text, settings in off.items():
        stage = stage_of(last_of(pane(), settings))
        assert not stage.on and text in stage.reason
    behind = replace(
        pane().camera, matrix=scenes.camera((0.3, -0.6, 1.6), (0, 0, 0), 8, 8).matrix
    )
    stage = stage_of(last_of(replace(pane(), camera=behind), replace(ALONE, passes=1)))
    assert not stage.on and "the camera sees 0 without" in stage.reason
    wide = replace(pane().camera, width=1200, height=1000)
    small = replace(ALONE, passes=1, photon_memory=16)
    assert "memory" in why_not(small, wide.width * wide.height, 1)
    assert why_not(small, 12 * 12, 1) == ""


def test_what_is_held_out_has_no_caustic(monkeypatch):
    connect_all(monkeypatch, 1.0)
    scene = pane(visibility=Visibility.ALL | Visibility.HOLDOUT)
    film = last_of(scene, replace(ALONE, passes=2)).film
    assert film.resolve("caustics").max() == 0.0


def test_images_take_the_memory_that_is_said(rng):
    region = Region(0, 0, 300, 200, 300)
    rows = [seen_at(rng.uniform((0, 0), (300, 200), (10_000, 2))) for _ in range(5)]
    for k, part in enumerate(rows):
        part["order"] = np.arange(10_000) * 5 + k
    counts = np.ones(region.width * region.height, np.float32)
    wanted = np.ones((200, 300), np.uint8)
    expected = Expected(region, counts, "", filter_table("BOX", 1.0), wanted)
    light_image.light_image(expected, rows, 0, 1.0)  # compiles
    tracemalloc.start()
    image = light_image.light_image(expected, rows, 0, 1.0)
    peak = tracemalloc.get_traced_memory()[1] + sum(part.nbytes for part in rows)
    tracemalloc.stop()
    assert image.light.nbytes == bytes_of_image(region.width * region.height)
    said = bytes_of_image(region.width * region.height) + bytes_of_connected(50_000)
    assert 0.7 * said < peak <= said + 20_000
    plain, budget = (Budget.of(Settings(), 0, pixels) for pixels in (0, 60_000))
    more = budget.bytes_of(Stored(50_000, 0), 1) - plain.bytes_of(Stored(50_000, 0), 1)
    assert more == 2 * bytes_of_image(60_000) + bytes_of_connected(50_000)


def edge(scale):
    """A pane over a floor, lit from above where x > 0, ``scale`` metres across."""
    b = SceneBuilder("edge")
    floor = scenes.quad((-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0))
    b.add_mesh("floor", *floor, b.add_material("floor", [diffuse(0.8)]))
    glass = b.add_material("glass", [dielectric(1.5)])
    b.add_mesh("pane", *scenes.glass_slab(1.5, 1.0, 1.1, 4.0), glass)
    shade = scenes.quad((-2, -2, 1.2), (0, -2, 1.2), (0, 2, 1.2), (-2, 2, 1.2))
    b.add_mesh("shade", *shade, b.add_material("black", [diffuse(0.0)]))
    b.add_sun_light("sun", scenes.look_at((0, 0, 5), (0, 0, 0)), 1.0, 0.0)
    camera = scenes.camera((0, 0, 0.9), (0, 0, 0), 16, 16, up=(0, 1, 0))
    b.set_camera(replace(camera, kind="ORTHOGRAPHIC", ortho_scale=scale))
    return b.build()


def test_edges_of_light_stay_sharp():
    """Nothing of the light beside it, where discs would blur it."""
    settings = replace(
        ALONE, passes=16, photons_caustic=65536, pixel_filter="BOX", filter_width=1.0
    )
    image = last_of(edge(0.1), settings).film.resolve("caustics").mean(axis=2)
    lit, dark = image[:, 9:].mean(), image[:, :7]
    assert lit > 0
    # The first passes have discs yet; alone they reach 1.4 pixels.
    assert dark[:, -1].mean() < 0.02 * lit


@pytest.mark.parametrize("kind", ["GAUSSIAN", "BLACKMAN_HARRIS"])
def test_an_edge_is_as_wide_as_the_filter(kind, monkeypatch):
    """Columns are the filter's integral; six seeds, level 1 % over all columns."""
    connect_all(monkeypatch, 1.0)
    table = filter_table(kind, 6.0)
    settings = replace(
        ALONE, passes=4, photons_caustic=65536, pixel_filter=kind, filter_width=6.0
    )
    rows = []
    for seed in range(6):
        film = last_of(edge(0.4), replace(settings, seed=seed)).film
        rows.append(film.resolve("caustics")[..., 0].astype(np.float64).mean(axis=0))
    rows = np.array(rows) / np.mean(rows, axis=0)[12:].mean()
    expected = 1.0 - np.interp(8.0 - (np.arange(16) + 0.5), table[0], table[1])
    mixed = (expected > 0.01) & (np.arange(16) < 12)
    assert mixed.sum() >= 5 and (rows[:, expected == 0.0] == 0.0).all()
    variance = rows.var(axis=0, ddof=1) / 6
    assert (np.sqrt(variance[mixed]) < 0.02).all(), "the test would see nothing"
    same_means(rows.mean(axis=0)[mixed], variance[mixed], expected[mixed], freedom=5)
