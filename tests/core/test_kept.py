"""What a render leaves to the next one: less to do, the same picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import Kept, Settings, photon_pass, render
from photon_map.core import kept as module
from photon_map.tests import scenes

SETTINGS = Settings(passes=3, threads=1, photons_global=3000, photons_caustic=3000)


def film_of(scene, kept=None):
    return list(render(scene, SETTINGS, kept))[-1].film


def moved(scene):
    matrix = np.array(scene.camera.matrix)
    matrix[:3, 3] += 0.05 * matrix[:3, 0]
    return replace(scene, camera=replace(scene.camera, matrix=matrix))


def test_another_camera_sees_what_it_would_alone(monkeypatch: pytest.MonkeyPatch):
    scene = scenes.cornell_glass(12, smooth=True)
    kept = Kept()
    film_of(scene, kept)
    monkeypatch.delattr(module, "prepare")
    traced = []
    trace = photon_pass.trace_batch

    def trace_batch(prepared, settings, i, batch):
        traced.append(i)
        return trace(prepared, settings, i, batch)

    monkeypatch.setattr(photon_pass, "trace_batch", trace_batch)
    again = film_of(moved(scene), kept)
    monkeypatch.undo()
    # The pilot, and the few photons that compile the kernels.
    assert set(traced) <= {photon_pass.PILOT_PASS, 0}
    alone = film_of(moved(scene))
    for layer in ("combined", "caustics", "indirect", "error"):
        assert np.array_equal(again.resolve(layer), alone.resolve(layer)), layer
    assert (again.resolve("combined") != film_of(scene).resolve("combined")).any()


def test_another_scene_starts_anew():
    scene = scenes.cornell_glass(12, smooth=True)
    kept = Kept()
    film_of(scene, kept)
    darker = replace(scene, world=scene.world + 1.0)
    got, expected = film_of(darker, kept), film_of(darker)
    assert np.array_equal(got.resolve("combined"), expected.resolve("combined"))


def test_memory_is_bounded():
    kept = Kept(most_bytes=400_000)
    film_of(scenes.cornell_glass(12, smooth=True), kept)
    assert 0 < kept.nbytes <= 400_000
    assert Kept(0).nbytes == 0
