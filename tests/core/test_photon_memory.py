"""Photon maps stay below the user's limit, and a render goes on with fewer photons."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import LightGroup, Settings, SettingsError, render
from photon_map.core.photon_memory import AHEAD, LEAST_AHEAD, Budget, PhotonMemory, Stored
from photon_map.core.photons.photon_map import (
    build_photon_map,
    bytes_of_map,
    bytes_while_building,
)
from photon_map.core.photons.trace import PHOTON, Walk
from photon_map.core.pilot import no_radii
from photon_map.tests import scenes

MEGABYTE = 1 << 20
#: So many photons that they take far more than anything else in so small a picture.
MANY = Settings(
    passes=4, threads=2, photons_global=100_000, photons_caustic=50_000, gather_rays=1,
    chunk_size=4096,
)  # fmt: skip
SCENE = scenes.cornell_glass(12, smooth=True)


def walks_of(count, parts):
    rng = np.random.default_rng(count)
    photons = np.zeros(count, PHOTON)
    photons["position"] = rng.random((count, 3))
    order = np.arange(count)
    return [
        Walk(a.copy(), b.copy(), 0)
        for a, b in zip(
            np.array_split(photons, parts), np.array_split(order, parts), strict=True
        )
    ]


def peak_of(work):
    """Most memory that ``work`` takes beyond what there was before."""
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    result = work()
    peak = tracemalloc.get_traced_memory()[1] - before
    tracemalloc.stop()
    return peak, result


@pytest.mark.parametrize("count", [0, 1, 100, 65_536, 65_537, 150_000])
def test_a_map_takes_what_is_said(count):
    build_photon_map(walks_of(10, 1), 0.05)  # compiles
    peak, built = peak_of(lambda: build_photon_map(walks_of(count, 7), 0.05))
    size = sum(a.nbytes for a in (built.photons, built.places, built.keys, built.start))
    assert size <= bytes_of_map(count)
    # Python's own objects beside the arrays.
    assert peak <= bytes_while_building(count) + 40_000
    if count > 60_000:
        assert size > 0.7 * bytes_of_map(count)
        assert peak > 0.6 * bytes_while_building(count)


def render_all(settings, scene=SCENE):
    return list(render(scene, settings))[-1]


@pytest.fixture(scope="module")
def bare():
    """Memory of a render with hardly any photons, but as many in a batch."""
    few = replace(MANY, photons_global=4096, photons_caustic=4096)
    render_all(few)
    return peak_of(lambda: render_all(few))[0]


@pytest.mark.parametrize("limit", [16, 32, 64])
def test_the_maps_stay_below_the_limit(limit, bare):
    peak, update = peak_of(lambda: render_all(replace(MANY, photon_memory=limit)))
    emitted = update.film.statistics.photons_emitted / MANY.passes
    assert update.photon_bytes <= limit * MEGABYTE
    # What Python says that there was, beyond the rest of a render.
    assert peak - bare < limit * MEGABYTE
    # It is made use of: the tables' sizes go in steps of two.
    assert update.photon_bytes > 0.35 * limit * MEGABYTE
    warnings = [text for text in update.plan.warnings if "MB" in text]
    assert len(warnings) == 1
    assert f"more than {limit} MB: there are {emitted:.0f}" in warnings[0]
    assert update.film.passes == MANY.passes


def test_a_wide_limit_changes_nothing_and_a_narrow_one_keeps_the_light():
    whole, narrow = render_all(MANY), render_all(replace(MANY, photon_memory=16))
    assert whole.plan.warnings == ()
    assert whole.film.statistics.photons_emitted == MANY.passes * 150_000
    assert narrow.film.statistics.photons_emitted < 0.3 * MANY.passes * 150_000
    means = [update.film.resolve("combined")[..., :3].mean() for update in (whole, narrow)]
    assert means[1] == pytest.approx(means[0], rel=0.03)


def test_neither_threads_nor_chunks_choose_how_many():
    settings = replace(MANY, photon_memory=24)
    films = [
        render_all(replace(settings, **other)).film
        for other in ({}, {"threads": 1}, {"threads": 3, "chunk_size": 777})
    ]
    for film in films[1:]:
        assert film.statistics == films[0].statistics
        assert (film.resolve("combined") == films[0].resolve("combined")).all()


def test_what_is_chosen_automatically_stays_below_it_too():
    """Most of the noise is in the caustic: it asks for several times the photons."""
    size = 340
    scene = scenes.mirror_caustic(size, radius=0.02)
    free = replace(MANY, passes=1, photons_global=-1, photons_caustic=-1, gather_rays=-1)
    wide, narrow = (
        render_all(replace(free, photon_memory=limit), scene) for limit in (1024, 16)
    )
    assert wide.photon_bytes > 16 * MEGABYTE
    assert narrow.photon_bytes <= 16 * MEGABYTE
    # The usual number fits: nothing was asked for that is not there.
    assert narrow.plan.warnings == ()
    emitted = [u.film.statistics.photons_emitted for u in (wide, narrow)]
    assert size * size <= emitted[1] < emitted[0]


def test_groups_and_the_layer_of_densities_share_the_limit():
    group = LightGroup("all", lights=("lamp",))
    settings = replace(
        MANY, photon_memory=32, light_groups=(group,), first_hit=("photon_density",)
    )
    update = render_all(settings)
    assert update.photon_bytes <= 32 * MEGABYTE
    plain = render_all(replace(MANY, photon_memory=32))
    ratio = plain.film.statistics.photons_stored / update.film.statistics.photons_stored
    # Twice the maps in all, and each has copies: both films count all sides' photons.
    assert 1.0 < ratio < 2.0


def test_passes_wait_for_each_other_before_there_are_fewer_photons():
    settings = replace(MANY, photon_memory=100)
    memory = PhotonMemory(settings)
    budget = Budget.of(settings)
    stored = Stored(50_000.0, 100_000.0)
    assert budget.bytes_of(stored, AHEAD) <= budget.limit
    memory.expect(stored, no_radii())
    assert memory.ahead == AHEAD
    memory.expect(stored.times(1.5), no_radii())
    assert memory.ahead == LEAST_AHEAD
    assert budget.part(stored.times(1.5)) == 1.0
    part = budget.part(stored.times(20.0))
    assert part < 0.2
    assert budget.bytes_of(stored.times(20.0 * part), LEAST_AHEAD) <= budget.limit


def test_less_than_16_megabytes_are_refused():
    with pytest.raises(SettingsError, match="photon_memory is 15, it must be from 16"):
        Settings(photon_memory=15)
