"""Small bright places: photons bring their light with the same mean and less noise."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.camera_pass import chunk
from photon_map.core.film.layers import KIND_COLORS, KIND_LAYERS
from photon_map.core.focus_pass import focus_of
from photon_map.core.photons.focus import FOCUSED
from photon_map.core.photons.trace import trace_photons
from photon_map.core.prepared import prepare
from photon_map.core.sampling.rng import PHOTON_GLOBAL
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.closures import glossy
from photon_map.core.scene.lobes import Lobe, dielectric, diffuse, mirror
from photon_map.core.scene.scene import Scene
from photon_map.core.scene.tables import Visibility
from photon_map.core.steps import run
from photon_map.tests import scenes

FEW = Settings(
    passes=8, photons_global=4096, photons_caustic=4096, gather_rays=1, pixel_filter="BOX",
    filter_width=1.0,
)  # fmt: skip
SEEDS = 8
#: Student's t at 7 degrees of freedom, two-sided, 0.1 %.
T = 5.41


def lens_room(
    plate: list[Lobe] | None = None, rough: float = 0.0, visibility: Visibility = Visibility.ALL
) -> Scene:
    """A lamp, a ball of glass below it and its focus on the floor; a wall is looked at.

    A ``plate`` beside the focus, or one of metal that is ``rough``, mirrors it onto the wall.
    """
    b = SceneBuilder("lens room")
    paint = b.add_material("paint", [diffuse(0.7)])
    b.add_mesh("room", *scenes.box((-2, -2, 0), (2, 2, 2)), paint)
    b.add_mesh("lens", *scenes.sphere((0.9, 0, 0.62), 0.3, 4),
               b.add_material("glass", [dielectric(1.5)]), visibility=visibility)  # fmt: skip
    if plate or rough:
        closures = [glossy(0.9, rough)] if rough else []
        metal = b.add_material("metal", plate or [], closures=closures)
        b.add_mesh("plate", *scenes.quad((0.5, -0.6, 0), (0.5, 0.6, 0), (0.5, 0.6, 0.3),
                                         (0.5, -0.6, 0.3)), metal)  # fmt: skip
    b.add_point_light("lamp", (0.9, 0, 1.9), 5.0, 0.0)
    b.set_camera(scenes.camera((-1.5, 0, 1.0), (2, 0, 0.9), 8, 8, fov=0.5))
    return b.build()


def lamp_at_a_wall() -> Scene:
    """Light of a lamp 4 cm off the wall: what is bright has met no caster."""
    b = SceneBuilder("lamp at a wall")
    b.add_mesh("room", *scenes.box((-2, -2, 0), (2, 2, 2)),
               b.add_material("paint", [diffuse(0.7)]))  # fmt: skip
    b.add_mesh("pane", *scenes.box((0.4, -1, 0.2), (0.45, 1, 1.6)),
               b.add_material("glass", [dielectric(1.5)]))  # fmt: skip
    b.add_point_light("lamp", (-1.96, 0.0, 1.0), 3.0, 0.0)
    b.set_camera(scenes.camera((-1.0, 0, 1.0), (2, 0, 0.9), 8, 8, fov=0.5))
    return b.build()


SCENES = {
    "lens": lens_room(),
    "mirror": lens_room([mirror(0.9)]),
    "rough metal": lens_room(rough=0.3),
    "rougher metal": lens_room(rough=0.5),
    "paint and mirror": lens_room([diffuse(0.4), mirror(0.5)]),
    "lens casts none": lens_room(visibility=Visibility.ALL | Visibility.CASTS_NONE),
    "lamp": lamp_at_a_wall(),
}


def pictures(scene: Scene, settings: Settings) -> np.ndarray:
    """Indirect light (SEEDS, h, w, 3)."""
    found = []
    for seed in range(SEEDS):
        *_, last = render(scene, replace(settings, seed=seed))
        found.append(last.film.resolve("indirect").astype(float))
    return np.array(found)


@pytest.mark.parametrize("name", SCENES)
def test_the_mean_is_that_of_gather_rays(name: str):
    """t-test of the mean difference, at 0.1 %, beside 1 % for the discs' own blur."""
    scene = SCENES[name]
    assert run(focus_of(prepare(scene, FEW), FEW, True)).focus.found > 0
    many = replace(FEW, passes=16, gather_rays=16)
    on, off = (pictures(scene, replace(many, focus=focus)) for focus in (True, False))
    means = on.mean(axis=(1, 2, 3)) - off.mean(axis=(1, 2, 3))
    error = means.std(ddof=1) / np.sqrt(SEEDS)
    assert error < 0.02 * off.mean(), "too noisy to tell"
    assert abs(means.mean()) < T * error + 0.01 * off.mean()


def test_a_focus_makes_less_noise():
    on, off = (pictures(SCENES["lens"], replace(FEW, focus=focus)) for focus in (True, False))
    assert on.var(axis=0, ddof=1).mean() < 0.5 * off.var(axis=0, ddof=1).mean()


def test_nothing_of_it_is_called_where_no_place_is_bright(monkeypatch: pytest.MonkeyPatch):
    gather = chunk.gather_caustics

    def watched(*arguments: Any) -> None:
        assert not arguments[6], "called"
        gather(*arguments)

    monkeypatch.setattr(chunk, "gather_caustics", watched)
    *_, last = render(scenes.cornell_glass(8), replace(FEW, passes=1, focus=False))
    assert not any(stage.name == "focus" for stage in last.plan.stages)
    with pytest.raises(AssertionError, match="called"):
        list(render(SCENES["lens"], replace(FEW, passes=1)))


def test_flux_is_shared_out_and_none_is_lost():
    """What gather rays are left, and what the same photon leaves behind, are its flux."""
    scene = SCENES["lamp"]
    plain = prepare(scene, FEW)
    found = plain._replace(focus=run(focus_of(plain, FEW, False)).focus)

    def walk(prepared):  # type: ignore[no-untyped-def]
        return trace_photons(
            prepared, prepared.aim.spheres, prepared.lights.photon_cdf, False, FEW,
            PHOTON_GLOBAL, 0, 0, 4096, 4096,
        )  # fmt: skip

    def by_path(photons, order):  # type: ignore[no-untyped-def]
        sort = np.argsort(order, kind="stable")
        return photons[sort], order[sort]

    photons, order = by_path(*walk(plain)[:2])
    shared, places = by_path(*walk(found)[:2])
    apart = shared["part"] == FOCUSED
    assert not (photons["part"] == FOCUSED).any() and apart.any()
    # The paths are the same, so the rows of gather rays lie in the same places.
    rest = shared[~apart]
    assert (rest["position"] == photons["position"]).all()
    kept = rest["flux"][:, 0] / photons["flux"][:, 0]
    assert kept.min() < 0.3 and kept.max() == 1.0
    # A path's next photon brings what was not kept at the one before.
    behind = dict(zip(places[apart].tolist(), shared["flux"][apart], strict=True))
    checked = 0
    for k in np.flatnonzero((order[1:] == order[:-1] + 1) & (kept[:-1] < 1.0)):
        if order[k + 1] % FEW.photon_depth:
            wanted = photons["flux"][k + 1] * (1.0 - kept[k])
            np.testing.assert_allclose(behind[order[k + 1]], wanted, rtol=1e-5)
            checked += 1
    assert checked > 100


def test_chunks_and_threads_change_nothing():
    settings = replace(FEW, passes=2, photons_global=1000, photons_caustic=1000)
    one, two = (
        list(render(SCENES["mirror"], replace(settings, chunk_size=size, threads=threads)))[-1]
        for size, threads in ((37, 1), (8192, 2))
    )
    assert (one.film.resolve("indirect") == two.film.resolve("indirect")).all()


def test_the_kinds_of_light_make_the_picture():
    asked = (*KIND_COLORS, "seen_emission", "environment")
    settings = replace(FEW, passes=2, first_hit=asked, light_kinds=True)
    *_, last = render(SCENES["paint and mirror"], settings)
    film = last.film
    total = film.resolve("seen_emission") + film.resolve("environment")
    for name in KIND_LAYERS:
        total = total + film.resolve(name) * film.resolve(f"{name.split('_')[0]}_color")
    combined = film.resolve("combined")[..., :3]
    np.testing.assert_allclose(total, combined, rtol=2e-4, atol=2e-6)
