"""The pilot asks for nothing that no stage needs."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from photon_map.core import pilot
from photon_map.core.camera_pass.pixels import Region
from photon_map.core.focus_pass import focus_of
from photon_map.core.photon_pass import TracedPhotons, photon_batches, trace_batch
from photon_map.core.pilot import PILOT_PASS
from photon_map.core.pilot_pass import pilot_radii
from photon_map.core.plan import Plan
from photon_map.core.prepared import prepare
from photon_map.core.renderer import render
from photon_map.core.settings import Settings
from photon_map.core.steps import run
from tests.scenes import cornell_glass, mirror_caustic


def refuse(*_: Any) -> Any:
    raise AssertionError("a ray was traced")


@pytest.mark.parametrize("photons", [0, 64])
def test_without_photons_the_pilot_traces_no_ray(photons: int) -> None:
    scene = cornell_glass(8)
    settings = Settings(photons_global=photons, photons_caustic=photons, passes=1)
    prepared = prepare(scene, settings)
    blind = prepared._replace(intersector=SimpleNamespace(nearest=refuse, is_free=refuse))
    batches = photon_batches(Plan.of(scene, settings), settings, 64)
    assert scene.camera is not None
    region = Region.of(scene.camera, settings)
    if photons:
        with pytest.raises(AssertionError, match="a ray was traced"):
            pilot_radii(blind, settings, region, TracedPhotons(blind, settings, batches))
        seen = TracedPhotons(prepared, settings, batches)
        assert pilot_radii(prepared, settings, region, seen).global_ > 0.0
    else:
        none = TracedPhotons(blind, settings, batches)
        assert pilot_radii(blind, settings, region, none).global_ == 0.0


def test_a_draft_leaves_out_what_takes_long(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where surfaces run into others, and most of the pilot; its discs are much the same."""
    scene = cornell_glass(8)
    settings = Settings(passes=1, draft=True)
    prepared = prepare(scene, settings)
    batches = photon_batches(Plan.of(scene, settings), settings, 64)
    assert scene.camera is not None
    region = Region.of(scene.camera, settings)
    source = TracedPhotons(prepared, settings, batches)
    whole = pilot_radii(prepared, replace(settings, draft=False), region, source)
    monkeypatch.setattr(pilot, "crossings", refuse)
    draft = pilot_radii(prepared, settings, region, source)
    assert draft.crowd_photons < whole.crowd_photons
    assert draft.crowd is not None and len(draft.crowd.photons) > 0
    assert draft.caustic == pytest.approx(whole.caustic, rel=0.1)
    assert draft.global_ == pytest.approx(whole.global_, rel=0.1)


def test_a_draft_renders_caustics() -> None:
    """With the discs and photons of its small pilot."""
    scene = cornell_glass(16)
    films = [
        list(render(scene, Settings(passes=4, gather_rays=1, draft=draft)))[-1].film
        for draft in (True, False)
    ]
    draft, whole = (film.resolve("caustics").mean() for film in films)
    assert draft == pytest.approx(whole, rel=0.1)
    assert draft > 0


def test_photons_that_looked_for_crowds_are_those_of_the_pilot() -> None:
    """Bit for bit, so that they need not be traced again; not where they will be shared out."""
    settings = Settings(photons_caustic=2000, photons_global=2000)
    glass = run(focus_of(prepare(cornell_glass(16), settings), settings, True))
    assert glass.focus.found > 0 and not glass.walks
    prepared = prepare(mirror_caustic(), settings)
    crowds = run(focus_of(prepared, settings, True))
    assert crowds.focus.found == 0
    assert {batch.caustic for batch in crowds.walks} == {True, False}
    alike = prepared._replace(focus=crowds.focus)
    for batch, walk in crowds.walks.items():
        again = trace_batch(alike, settings, PILOT_PASS, batch)
        assert again.photons.tobytes() == walk.photons.tobytes()
        assert np.array_equal(again.order, walk.order)
        source = TracedPhotons(alike, settings, [batch])
        traced = source.pilot()
        source.piloted = crowds.walks
        assert source.walk(PILOT_PASS, batch) is walk
        assert np.array_equal(source.pilot(), traced)
        assert source.walk(0, batch) is not walk
