"""Which light is asked, and which face of the emissive ones (chi-square, level 0.01)."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.lights.selection import select_light, selection_probability
from photon_map.core.scene.builder import SceneBuilder
from photon_map.tests import scenes
from photon_map.tests.core.lights.support import draw, prepared
from photon_map.tests.statistics import chi_square

COUNT = 20_000
POINT = (0.4, -0.3, 0.2)


def many():
    b = SceneBuilder("many")
    glow = b.add_material("glow", emission=(1.0, 2.0, 3.0))
    b.add_mesh("panel", *scenes.plane(0.5, 2.0), glow)
    b.add_mesh("big panel", *scenes.plane(1.0, 3.0), b.add_material("weak", emission=0.5))
    b.add_point_light("near", (0.5, 0, 0.5), 1.0)
    b.add_point_light("far", (9, 0, 0.5), 1.0)
    b.add_point_light("off", (0, 0, 0.5), 0.0)
    b.add_sun_light("sun", np.eye(4), 1.0)
    b.set_world(0.2)
    return b


def test_lights_are_selected_as_often_as_their_probability_says(rng):
    lights = prepared(many())[0]
    entries = [select_light(lights, POINT, u) for u in rng.random(COUNT)]
    prob = np.array([selection_probability(lights, POINT, k) for k in range(6)])
    assert prob.sum() == pytest.approx(1) and prob[2] == 0 and (np.delete(prob, 2) > 0).all()
    chi_square(np.bincount([k for k, _ in entries], minlength=6), prob * COUNT)
    assert all(p == pytest.approx(prob[k], rel=1e-12) for k, p in entries)


def test_emissive_faces_are_sampled_by_power(rng):
    lights, mesh, materials, centre = prepared(many())
    p = tuple(np.array(POINT) - centre.origin)
    wi, distance, _, pdf_w, _ = draw(lights, mesh, materials, 4, p, rng.random((COUNT, 3)))
    at = p + wi * distance[:, None] + centre.origin
    small = at[:, 2] < 2.5
    counts = np.concatenate(
        [
            np.histogram2d(at[part, 0], at[part, 1], 4, ((-h, h), (-h, h)))[0].ravel()
            for part, h in ((small, 0.5), (~small, 1.0))
        ]
    )
    # Power is area times mean radiance: 1 x 2 against 4 x 0.5.
    chi_square(counts, np.full(32, COUNT / 32))
    cosine = np.abs(wi[:, 2])
    area_density = np.where(small, 0.5, 0.5 / 4)
    np.testing.assert_allclose(pdf_w, area_density * distance**2 / cosine, rtol=1e-6)
