"""A point light over a plane, through photons and through light sampling: E = I cos / r^2."""

from __future__ import annotations

import numpy as np

from photon_map.core import Settings, render
from photon_map.core.bsdf.dispatch import DIFFUSE
from photon_map.core.photon_pass import Batch, trace_batch
from photon_map.core.photons.gather import gather_radiance
from photon_map.core.photons.photon_map import build_photon_map
from photon_map.core.photons.sight import SIGHT
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import SceneBuilder, diffuse
from photon_map.tests import scenes

INTENSITY, HEIGHT, ALBEDO = 5.0, 2.0, 0.8


def scene(radius=0.0, size=8):
    b = SceneBuilder("plane")
    # The light is within the scene's bounds: photons of a sphere fly everywhere.
    b.add_mesh("floor", *scenes.plane(4.0), b.add_material("floor", [diffuse(ALBEDO)]))
    b.add_point_light("lamp", (0.3, -0.2, HEIGHT), INTENSITY, radius)
    b.set_camera(scenes.camera((0, 0, 3), (0, 0, 0), size, size, up=(0, 1, 0)))
    return b.build()


def radiance(x, y):
    r2 = (x - 0.3) ** 2 + (y + 0.2) ** 2 + HEIGHT**2
    return ALBEDO / np.pi * INTENSITY * HEIGHT / r2**1.5


def test_photons_have_the_closed_form_density():
    points = [(0.0, 0.0), (1.0, 1.0), (-1.5, 0.5), (2.0, -2.0)]
    for radius in (0.0, 0.2):
        s = scene(radius)
        settings = Settings()
        prepared = prepare(s, settings)
        up = (0.0, 0.0, 1.0)
        runs = []
        for i in range(24):
            walk = trace_batch(prepared, settings, i, Batch(False, 0, 60000, 60000))
            photon_map = build_photon_map([walk], 0.4)
            z = -float(prepared.centre.origin[2])
            row = [
                gather_radiance(
                    photon_map, (x, y, z), up, up, up, 0.2, prepared.materials[0],
                    prepared.lobes, np.zeros(SIGHT),
                )[0][0]
                for x, y in points
            ]  # fmt: skip
            runs.append(row)
        found = np.array(runs)
        assert prepared.lobes["model"][0] == DIFFUSE
        expected = np.array([radiance(x, y) for x, y in points])
        error = found.std(axis=0, ddof=1) / np.sqrt(len(found))
        # 3.6 sigma: 0.0026 for 8 values. The disc of 0.2 m bends the density by 0.3 %.
        assert (np.abs(found.mean(axis=0) - expected) < 3.6 * error + 0.003 * expected).all()
        assert (error < 0.05 * expected).all(), "the test would see nothing"


def test_direct_light_has_the_closed_form():
    s = scene()
    # What is left is the mean over a pixel of 64 Sobol points, so each shall have them all.
    settings = Settings(passes=64, pixel_filter="BOX", filter_width=1.0, adaptive=False)
    film = list(render(s, settings))[-1].film
    found = film.resolve("direct")[..., 0]
    expected = scenes.floor_mean(s, radiance)
    np.testing.assert_allclose(found, expected, rtol=2e-3)
