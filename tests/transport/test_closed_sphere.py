"""A closed sphere with a point light in its middle: every layer has a closed form."""

from __future__ import annotations

import numpy as np

from photon_map.core import Settings, render
from photon_map.tests import scenes


def test_a_lamp_in_a_sphere_gives_equal_direct_and_indirect_light():
    # I = pi in a unit sphere: E = pi, direct L = albedo, indirect L = albedo^2 / (1 - albedo).
    runs = []
    for seed in range(8):
        settings = Settings(passes=16, seed=seed, pixel_filter="BOX", filter_width=1.0)
        film = list(render(scenes.closed_sphere(0.5, np.pi), settings))[-1].film
        runs.append([film.resolve(k).mean() for k in ("direct", "indirect", "caustics")])
    mean, error = np.mean(runs, axis=0), np.std(runs, axis=0, ddof=1) / np.sqrt(8)
    # 5.4 sigma at 7 degrees of freedom: 0.001. The facets of the sphere lie up to 1 %
    # nearer to the lamp than the sphere.
    assert abs(mean[0] - 0.5) < 5.4 * error[0] + 0.01
    assert abs(mean[1] - 0.5) < 5.4 * error[1] + 0.01
    assert mean[2] == 0
    assert error.max() < 0.01
