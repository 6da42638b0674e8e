"""Baked maps: the same picture as traced photons, and what else they must not be taken for."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from photon_map.core import Settings, bake, render, render_state
from photon_map.core.baking import bake as baking
from photon_map.core.baking.fingerprint import changes, fingerprint
from photon_map.core.baking.maps_file import BakeError, MapsFile
from photon_map.core.film.film import Film
from photon_map.core.path_density import PathDensity
from photon_map.core.photon_pass import trace_batch
from photon_map.core.pilot import PILOT_PASS
from photon_map.core.sampling.rng import REPLICATES
from photon_map.core.scene.scene import Scene
from tests.scenes import cornell_glass, look_at

SETTINGS = Settings(
    passes=4, photons_global=2000, photons_caustic=2000, threads=2, gather_rays=4
)


@pytest.fixture(scope="module")
def scene() -> Scene:
    return cornell_glass(12, smooth=True)


@pytest.fixture(scope="module")
def maps(scene: Scene, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("maps") / "box.pmap"
    done: list[int] = []
    header = bake(scene, SETTINGS, path, 3, done.append)
    assert (header.passes, done) == (4, [1, 2, 3, 4])
    return path


def last_of(scene: Scene, settings: Settings):
    return list(render(scene, settings))[-1]


def stage_of(update) -> tuple[bool, str]:
    return next((s.on, s.reason) for s in update.plan.stages if s.name == "photon maps")


def test_a_baked_render_has_the_bits_of_a_traced_one(scene: Scene, maps: Path):
    traced = last_of(scene, SETTINGS)
    baked = last_of(scene, replace(SETTINGS, photon_maps=str(maps), stale_maps="REFUSE"))
    for layer in Film.LAYERS:
        assert (traced.film.resolve(layer) == baked.film.resolve(layer)).all(), layer
    assert traced.film.resolve("caustics").max() > 0
    assert baked.film.statistics.rays < traced.film.statistics.rays
    assert stage_of(baked) == (True, "4 passes from 'box.pmap'")


def test_pixels_have_a_path_a_pass_each_with_a_bake(
    scene: Scene, maps: Path, monkeypatch: pytest.MonkeyPatch
):
    # Paths where the noise of a frame is would weigh other passes' photons in each frame.
    asked: list[bool] = []

    class Listening(PathDensity):
        def __init__(self, width: int, height: int, adaptive: bool) -> None:
            asked.append(adaptive)
            super().__init__(width, height, adaptive)

    monkeypatch.setattr(render_state, "PathDensity", Listening)
    for path in ("", str(maps)):
        last_of(scene, replace(SETTINGS, photon_maps=path))
    assert asked == [True, False]


def test_no_photon_of_a_pass_is_traced_with_a_bake(
    scene: Scene, maps: Path, monkeypatch: pytest.MonkeyPatch
):
    passes: list[int] = []

    def listen(prepared: Any, settings: Any, i: int, *rest: Any) -> Any:
        passes.append(i)
        return trace_batch(prepared, settings, i, *rest)

    for module in ("photon_pass", "pilot_pass"):
        monkeypatch.setattr(f"photon_map.core.{module}.trace_batch", listen)
    camera = replace(scene.camera, matrix=look_at((0.3, -2.4, 0.9), (0, 0, 1)))  # type: ignore[type-var]
    moved = replace(scene, camera=camera)
    settings = replace(SETTINGS, photon_maps=str(maps), stale_maps="REFUSE")
    assert last_of(moved, settings).film.resolve("caustics").max() > 0
    # The pilot's tell where light is focused.
    assert passes == [PILOT_PASS]
    last_of(moved, SETTINGS)
    assert set(passes) == {PILOT_PASS, 0, 1, 2, 3}


def test_the_caustic_of_a_place_is_the_same_from_another_camera(scene: Scene, maps: Path):
    # Both cameras have the same place in the middle of a pixel, and other random numbers.
    half, size = 0.6, 24
    step = 2 * half / size
    narrow = replace(SETTINGS, filter_width=0.01, pixel_filter="BOX")
    baked = replace(narrow, photon_maps=str(maps), stale_maps="REFUSE")
    deviations = []
    for settings in (narrow, baked):
        seen = []
        for frame in range(2):
            x = frame * step
            camera = replace(
                scene.camera, kind="ORTHOGRAPHIC", ortho_scale=2 * half, width=size,
                height=size, matrix=look_at((x, 0, 0.9), (x, 0, -1), up=(0, 1, 0)),
            )  # type: ignore[type-var]  # fmt: skip
            update = last_of(replace(scene, camera=camera), replace(settings, seed=frame))
            shared = slice(1, size) if frame == 0 else slice(0, size - 1)
            floor = abs(update.film.resolve("depth")[:, shared, 0] - 1.9) < 1e-3
            seen.append(np.where(floor, update.film.resolve("caustics")[:, shared, 0], 0.0))
        both = (seen[0] > 0) | (seen[1] > 0)
        assert both.sum() > 30
        deviations.append(
            np.sqrt(((seen[0] - seen[1])[both] ** 2).mean()) / seen[0][both].mean()
        )
    assert deviations[0] > 0.5, deviations
    assert deviations[1] < 0.03, deviations


def test_passes_beyond_the_baked_ones_meet_their_own_replicate(scene: Scene, maps: Path):
    source = baking.BakedPhotons(MapsFile(maps), baking.Plan.of(scene, SETTINGS))
    again = [source.pass_of(i) for i in range(11)]
    assert again == [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2]
    assert all(k % REPLICATES == i % REPLICATES for i, k in enumerate(again))
    assert [baking.whole_passes(n) for n in (0, 1, 4, 5, 64)] == [4, 4, 4, 8, 64]


def _more(table: np.ndarray, name: str) -> np.ndarray:
    other = table.copy()
    other[name] *= 0.5
    return other


def _moved(scene: Scene) -> np.ndarray:
    vertices = scene.vertices.copy()
    vertices[scene.faces[-1, 0], 2] += 1e-3
    return vertices


def test_what_has_changed_is_named(scene: Scene):
    before = fingerprint(scene, SETTINGS)
    assert changes(before, fingerprint(scene, replace(SETTINGS, seed=5, passes=9))) == []
    other = replace(scene.camera, lens=80.0)  # type: ignore[type-var]
    assert changes(before, fingerprint(replace(scene, camera=other), SETTINGS)) == []
    white = list(scene.material_names)[0]
    found = changes(
        before, fingerprint(replace(scene, lobes=_more(scene.lobes, "weight")), SETTINGS)
    )
    assert f"material '{white}' has changed" in found
    last = scene.object_names[scene.face_object[-1]]
    found = changes(before, fingerprint(replace(scene, vertices=_moved(scene)), SETTINGS))
    assert found == [f"object '{last}' has changed"]
    dimmed = replace(scene, lights=_more(scene.lights, "emission"))
    found = changes(before, fingerprint(dimmed, SETTINGS))
    assert found == [f"lamp '{name}' has changed" for name in scene.light_names]
    assert found or not len(scene.lights)
    found = changes(before, fingerprint(replace(scene, world=scene.world + 0.1), SETTINGS))
    assert found == ["the world has changed"]
    found = changes(before, fingerprint(scene, replace(SETTINGS, photon_depth=3)))
    assert found == ["the photons' depth has changed"]
    renamed = replace(scene, material_names=("paint", *scene.material_names[1:]))
    found = changes(before, fingerprint(renamed, SETTINGS))
    assert found == ["material 'paint' is new", f"material '{white}' is gone"]


def test_stale_maps_are_refused_traced_or_baked_again(scene: Scene, maps: Path, tmp_path: Path):
    path = tmp_path / "mine.pmap"
    path.write_bytes(maps.read_bytes())
    other = replace(scene, world=scene.world + 0.25)
    settings = replace(SETTINGS, photon_maps=str(path))
    with pytest.raises(BakeError, match="the world has changed; bake them again"):
        last_of(other, replace(settings, stale_maps="REFUSE"))
    update = last_of(other, settings)
    on, reason = stage_of(update)
    assert not on and "the world has changed" in reason
    assert any("traced instead" in warning for warning in update.plan.warnings)
    traced = last_of(other, SETTINGS).film.resolve("combined")
    assert (update.film.resolve("combined") == traced).all()
    assert path.read_bytes() == maps.read_bytes()
    update = last_of(other, replace(settings, stale_maps="REBUILD"))
    assert stage_of(update)[0]
    assert any("baked again" in warning for warning in update.plan.warnings)
    assert (update.film.resolve("combined") == traced).all()
    assert not [w for w in last_of(other, settings).plan.warnings if "baked" in w]


def test_other_photon_counts_do_not_fit(scene: Scene, maps: Path):
    settings = replace(SETTINGS, photon_maps=str(maps), stale_maps="REFUSE")
    with pytest.raises(BakeError, match="photons_global was 2000"):
        last_of(scene, replace(settings, photons_global=2001))
    automatic = replace(settings, photons_global=-1, photons_caustic=-1)
    assert last_of(scene, automatic).film.statistics.photons_emitted == 4 * 4000


def test_missing_maps_are_baked_when_they_may_be(scene: Scene, tmp_path: Path):
    settings = replace(SETTINGS, photon_maps=str(tmp_path / "new.pmap"))
    with pytest.raises(BakeError, match="there are no photon maps"):
        last_of(scene, replace(settings, stale_maps="REFUSE"))
    assert not stage_of(last_of(scene, settings))[0]
    assert stage_of(last_of(scene, replace(settings, stale_maps="REBUILD")))[0]
    assert MapsFile(tmp_path / "new.pmap").header.passes == 4


def test_maps_above_the_memory_limit_are_told_and_taken(scene: Scene, tmp_path: Path):
    many = replace(SETTINGS, photons_global=60_000, photons_caustic=1000, photon_memory=16)
    bake(scene, many, tmp_path / "many.pmap", 4)
    update = last_of(scene, replace(many, photon_maps=str(tmp_path / "many.pmap")))
    told = [w for w in update.plan.warnings if "take more than 16 MB" in w]
    assert len(told) == 1 and "many.pmap" in told[0]
    assert update.photon_bytes > 16 << 20


def test_maps_that_a_render_bakes_stay_below_the_limit(scene: Scene, tmp_path: Path):
    path = tmp_path / "less.pmap"
    many = replace(
        SETTINGS, photons_global=60_000, photons_caustic=1000, photon_memory=16,
        photon_maps=str(path), stale_maps="REBUILD",
    )  # fmt: skip
    update = last_of(scene, many)
    assert stage_of(update)[0]
    assert update.photon_bytes < 16 << 20
    assert sum(MapsFile(path).header.emitted) < 61_000
