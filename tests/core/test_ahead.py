"""Kernels compiled ahead of their first call are the very ones that a render calls."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from numba.core import event

from photon_map.core import Settings, ahead, render
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


def compile_ahead(scene: Any, settings: Settings) -> None:
    region = Region.of(scene.camera, settings)
    ahead.compile_ahead(prepare(scene, settings), settings, Plan.of(scene, settings), region)


@pytest.mark.parametrize("settings", [FEW, KINDS], ids=["usual", "kinds"])
def test_a_render_needs_all_that_was_compiled_ahead(
    monkeypatch: pytest.MonkeyPatch, settings: Settings
) -> None:
    scene = scenes.cornell_glass(8)
    list(render(scene, settings))
    known = {name: set(getattr(chunk, name)._wholes) for name in KERNELS}
    trace, traced = ahead.trace_chunk, []

    def watched(*arguments: Any) -> Any:
        traced.append(trace(*arguments))
        return traced[-1]

    monkeypatch.setattr(ahead, "trace_chunk", watched)
    monkeypatch.setattr(ahead, "has_compiled", lambda: False)
    with event.install_recorder("numba:compile") as recorder:
        compile_ahead(scene, settings)
    assert not recorder.buffer
    assert known == {name: set(getattr(chunk, name)._wholes) for name in KERNELS}
    # All of it was called: paths, and gather rays from where they end.
    assert traced[0].rays > traced[0].gathered > 0


def test_nothing_is_done_ahead_once_there_are_kernels(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise AssertionError("called")

    monkeypatch.setattr(ahead, "trace_chunk", fail)
    scene = scenes.cornell_glass(8)
    monkeypatch.setattr(ahead, "has_compiled", lambda: True)
    compile_ahead(scene, FEW)
    monkeypatch.setattr(ahead, "has_compiled", lambda: False)
    with pytest.raises(AssertionError, match="called"):
        compile_ahead(scene, FEW)
