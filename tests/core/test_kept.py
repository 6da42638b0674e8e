"""What a render leaves to the next one: less to do, the same picture."""

from __future__ import annotations

from concurrent.futures import CancelledError
from dataclasses import fields, replace
from threading import Event

import numpy as np
import pytest

from photon_map.core import Kept, Settings, photon_pass, prepared, render
from photon_map.core import kept as module
from photon_map.core.scene.scene import Scene
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


def copied(scene):
    """As an export that was made anew gives it."""
    values = {field.name: getattr(scene, field.name) for field in fields(Scene)}
    arrays = {k: v.copy() for k, v in values.items() if isinstance(v, np.ndarray)}
    return Scene(**(values | arrays))


def test_an_export_made_anew_is_known_by_its_content(monkeypatch: pytest.MonkeyPatch):
    scene = scenes.cornell_glass(12, smooth=True)
    kept = Kept()
    film_of(scene, kept)
    expected = film_of(moved(scene))
    monkeypatch.delattr(module, "prepare")
    got = film_of(moved(copied(scene)), kept)
    assert np.array_equal(got.resolve("combined"), expected.resolve("combined"))


def test_faces_stay_in_embree_while_lights_and_colours_change(monkeypatch: pytest.MonkeyPatch):
    scene = scenes.cornell_glass(12, smooth=True)
    lobes, vertices = scene.lobes.copy(), scene.vertices.copy()
    lobes["weight"] *= 0.5
    vertices[0, 0] += 0.01
    thinner = scene.materials.copy()
    thinner["ior"] = 0.0
    changes = ({"world": scene.world + 1.0}, {"lobes": lobes}, {"vertices": vertices})
    changes = (*changes, {"materials": thinner})
    expected = [film_of(replace(scene, **change)) for change in changes]
    built = []
    build = prepared.Intersector

    def counted(*arguments):
        built.append(len(arguments))
        return build(*arguments)

    monkeypatch.setattr(prepared, "Intersector", counted)
    kept = Kept()
    film_of(scene, kept)
    for change, alone, count in zip(changes, expected, (1, 1, 2, 3), strict=True):
        got = film_of(replace(scene, **change), kept)
        for layer in ("combined", "caustics", "indirect"):
            assert np.array_equal(got.resolve(layer), alone.resolve(layer)), (change, layer)
        assert len(built) == count, change


def test_a_cancel_from_outside_ends_a_render_between_updates():
    kept = Kept()
    updates = render(
        scenes.cornell_glass(12, smooth=True), replace(SETTINGS, passes=10**6), kept
    )
    while next(updates).passes == 0:
        pass
    kept.cancel()
    with pytest.raises(CancelledError):
        for _ in range(100):
            next(updates)
    # The next one is another render.
    assert film_of(scenes.cornell_glass(12, smooth=True), kept).passes == SETTINGS.passes


def test_what_a_cancelled_render_finds_late_is_not_taken_for_another_ones():
    scene = scenes.cornell_glass(12, smooth=True)
    kept = Kept()
    late = Event()
    source = kept.prepare(scene, SETTINGS, late)
    batches = [photon_pass.Batch(False, 0, 100, 100)]
    traced = photon_pass.TracedPhotons(source, SETTINGS, batches)
    photons = kept.photons(traced, SETTINGS)
    kept.cancel()
    assert late.is_set()
    other = replace(scene, world=scene.world + 1.0)
    expected = film_of(other)
    kept.prepare(other, SETTINGS, Event())
    with pytest.raises(CancelledError):
        photons.walk(0, batches[0])
    stale = traced.__class__(source._replace(intersector=source.intersector.stopped_by(None)),
                             SETTINGS, batches)  # fmt: skip
    photons._source = stale
    assert len(photons.walk(0, batches[0]).photons)
    assert kept.nbytes == 0, "it is kept for the scene that is shown"
    got = film_of(other, kept)
    assert np.array_equal(got.resolve("combined"), expected.resolve("combined"))
