"""Gather rays that end near their start: no light from behind what they cannot see past."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.camera_pass import chunk
from photon_map.core.scene.builder import SceneBuilder, diffuse, mirror
from photon_map.core.scene.scene import Scene
from photon_map.tests import scenes

FEW = Settings(
    passes=8, photons_global=4096, photons_caustic=4096, gather_rays=1, pixel_filter="BOX",
    filter_width=1.0,
)  # fmt: skip
#: Student's t at 7 degrees of freedom, two-sided, 0.1 %.
T = 5.41


def indirect(scene: Scene, settings: Settings) -> np.ndarray:
    *_, last = render(scene, settings)
    return np.asarray(last.film.resolve("indirect"), float)


def slit(gap: float) -> Scene:
    """A black body hovers over a lit floor; a camera in the slit looks along it.

    Its underside is a mirror, so gather rays from the floor end on the floor, close by.
    """
    b = SceneBuilder("slit")
    b.add_mesh("floor", *scenes.plane(3.0), b.add_material("floor", [diffuse(0.8)]))
    silver = b.add_material("silver", [mirror(1.0)])
    under = scenes.quad((-1, -1, gap), (-1, 1, gap), (1, 1, gap), (1, -1, gap))
    b.add_mesh("underside", *under, silver)
    b.add_sun_light("sun", scenes.look_at((0, 0.2, 1), (0, 0, 0)), 3.0, 0.01)
    b.set_camera(scenes.camera((0, 0, 0.9 * gap), (0.5 * gap, 0, 0), 4, 4, fov=0.3))
    return b.build()


@pytest.mark.parametrize("gap", [1e-2, 1e-3])
def test_a_slit_under_a_lit_floor_stays_dark(gap: float):
    """Far in it, light comes in by many bounces or at grazing angles alone."""
    found = indirect(slit(gap), replace(FEW, photons_global=256)).mean()
    lit = 0.8 / np.pi * 3.0
    assert found < 2.0 * gap * lit
    # Discs of the photons around would bring a lot: this is what the test can see.
    chunk_near, chunk.NEAR = chunk.NEAR, 0.0
    try:
        discs = indirect(slit(gap), replace(FEW, photons_global=256)).mean()
    finally:
        chunk.NEAR = chunk_near
    assert discs > 0.02 * lit


def test_the_mean_in_a_corner_is_that_of_discs():
    """t-test of the mean inside of a ball, with half of the gather rays taken for short."""
    scene = scenes.closed_sphere()
    runs = [indirect(scene, replace(FEW, seed=seed)).mean() for seed in range(8)]
    old, chunk.NEAR = chunk.NEAR, 3.0
    try:
        near = [indirect(scene, replace(FEW, seed=seed)).mean() for seed in range(8)]
    finally:
        chunk.NEAR = old
    difference = np.subtract(near, runs)
    error = difference.std(ddof=1) / np.sqrt(8)
    assert error < 0.01 * np.mean(runs)
    assert abs(difference.mean()) < T * error + 0.005 * np.mean(runs)


def test_chunks_and_threads_change_nothing():
    scene = scenes.cornell_glass(16)
    settings = replace(FEW, passes=2, photons_global=500, photons_caustic=500)
    one = indirect(scene, replace(settings, chunk_size=37, threads=1))
    assert (one == indirect(scene, replace(settings, threads=2))).all()
