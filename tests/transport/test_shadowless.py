"""Lamps without shadows shine on all that lies on their rays, for photons too."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings
from photon_map.core.photon_pass import Batch, trace_batch
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import SceneBuilder, diffuse, mirror
from photon_map.tests import scenes
from photon_map.tests.stability.support import family, standard_error


def nested(shadow, *inner, albedo=0.5):
    """A closed ball of radius 1 around a lamp of pi W/sr; small balls of ``inner`` in it."""
    b = SceneBuilder("nested")
    b.add_mesh("shell", *scenes.sphere((0, 0, 0), 1.0, 3),
               b.add_material("shell", [diffuse(albedo)]))  # fmt: skip
    for k, lobes in enumerate(inner):
        ball = scenes.sphere((0, 0, 0), 0.03 + 0.01 * k, 2)
        b.add_mesh(f"ball {k}", *ball, b.add_material(f"m{k}", lobes))
    b.add_point_light("lamp", (0, 0, 0), np.pi, shadow=int(shadow))
    b.set_camera(scenes.camera((0.7, 0.1, 0), (1, 0.3, 0.2), 4, 4, fov=np.radians(60)))
    return b.build()


@pytest.mark.parametrize("inner", [[[]], [[diffuse(0.0)], [mirror(1.0)], [diffuse(0.0)]]])
def test_what_surrounds_a_lamp_without_shadows_takes_no_light(inner):
    """Direct a I / pi, indirect a^2 I / (pi (1 - a)), but for what the small balls absorb."""
    runs = family(nested(False, *inner))
    for name in ("direct", "indirect"):
        means = runs[name].mean(axis=(1, 2, 3))
        # The facets lie up to 1 % nearer to the lamp; black balls of 0.3 % of the area.
        assert abs(means.mean() - 0.5) < 5.4 * standard_error(means) + 0.017 * 0.5, name


def test_with_shadows_all_is_dark():
    runs = family(nested(True, [diffuse(0.0)]), runs=1)
    assert (runs["total"] == 0).all()


@pytest.mark.parametrize(
    ("inner", "wide"),
    [
        ([diffuse(0.0)], False),
        ([diffuse(0.7)], True),
        ([mirror(1.0)], False),
        ([mirror(0.5), diffuse(0.1)], True),
    ],
)
def test_each_surface_on_the_ray_gets_all_of_the_flux(inner, wide):
    prepared = prepare(nested(False, inner, inner), settings := Settings(photon_depth=1))
    walk = trace_batch(prepared, settings, 0, Batch(False, 0, 16384, 16384))
    flux = walk.photons["flux"][:, 0].astype(float)
    radius = np.linalg.norm(walk.photons["position"], axis=1)
    for low, high, lit in ((0.0, 0.035, wide), (0.035, 0.1, wide), (0.9, 1.1, True)):
        found = flux[(radius > low) & (radius < high)]
        expected = 4 * np.pi**2 * lit
        # Each surface doubles the flux of half of the photons: 5 standard deviations.
        assert found.sum() == pytest.approx(expected, abs=expected * 5 * 2 / 128)
