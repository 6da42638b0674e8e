"""Kernels compiled ahead of their first call are the very ones that a render calls."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from numba.core import event

from photon_map.core import Settings, ahead, render, renderer
from photon_map.core.camera_pass import chunk
from photon_map.core.camera_pass.pixels import Region
from photon_map.core.film.layers import KIND_COLORS
from photon_map.core.plan import Plan
from photon_map.core.prepared import prepare
from photon_map.tests import scenes

FEW = Settings(passes=1, photons_caustic=64, photons_global=64, threads=1)
KINDS = replace(FEW, light_kinds=True, first_hit=KIND_COLORS)
KERNELS = (
    "start_paths", "step_paths", "start_gather", "gather_caustics", "gather_indirect"
)  # fmt: skip


def get_ready(scene: Any, settings: Settings) -> bool:
    region = Region.of(scene.camera, settings)
    return ahead.get_ready(prepare(scene, settings), settings, Plan.of(scene, settings), region)


def loaded() -> dict[str, set[Any]]:
    return {name: set(getattr(chunk, name)._wholes) for name in KERNELS}


@pytest.mark.parametrize("settings", [FEW, KINDS], ids=["usual", "kinds"])
def test_a_render_needs_all_that_was_compiled_ahead(
    monkeypatch: pytest.MonkeyPatch, settings: Settings
) -> None:
    scene = scenes.cornell_glass(8)
    list(render(scene, settings))
    known = loaded()
    trace, traced = ahead.trace_chunk, []

    def watched(*arguments: Any) -> Any:
        traced.append(trace(*arguments))
        return traced[-1]

    monkeypatch.setattr(ahead, "trace_chunk", watched)
    monkeypatch.setattr(ahead, "has_compiled", lambda: False)
    with event.install_recorder("numba:compile") as recorder:
        assert not get_ready(scene, settings)
    assert not recorder.buffer
    assert known == loaded()
    # All of it was called: paths, and gather rays from where they end.
    assert traced[0].rays > traced[0].gathered > 0


def test_once_there_are_kernels_all_is_loaded_ahead(monkeypatch: pytest.MonkeyPatch) -> None:
    """No pixels go through the kernels a second time, with the photons of the pilot."""
    scene = scenes.cornell_glass(8)
    list(render(scene, FEW))
    before = loaded()
    monkeypatch.setattr(ahead, "has_compiled", lambda: True)
    assert get_ready(scene, FEW)
    warmed: list[object] = []
    monkeypatch.setattr(renderer, "warm_up", lambda *asked: warmed.append(asked))
    list(render(scene, FEW))
    assert not warmed and loaded() == before
    # Shadow photons change what the kernels are called with.
    list(render(scene, replace(FEW, shadow_photons=16)))
    assert warmed
