"""Rough surfaces of the reference against the kernels of the engine, sharing no code."""

from __future__ import annotations

import math

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.bsdf.dispatch import NARROW, WIDE
from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene import closures as c
from photon_map.core.scene import lobes as m
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.scene import SceneError
from photon_map.core.scene.tables import ClosureKind, Fresnel
from photon_map.tests import scenes
from tests.statistics import same_means
from tests.surfaces import Resolver, albedo, of_lobes, samples

LOBES = {
    "satin": [m.ggx((0.9, 0.6, 0.3), 0.5)],
    "metal": [m.ggx(1.0, 0.6, Fresnel.F82, f0=(0.9, 0.6, 0.2), f90=0.7)],
    "varnish": [m.ggx(1.0, 0.3, Fresnel.DIELECTRIC, ior=1.5), m.diffuse((0.5, 0.1, 0.2))],
    "tinted varnish": [m.ggx(1.0, 0.4, Fresnel.SCHLICK, ior=1.5, f0=(0.1, 0.05, 0.02))],
    "polished": [m.ggx(0.8, 0.005, Fresnel.DIELECTRIC, ior=1.5)],
    "clay": [m.oren_nayar((0.8, 0.5, 0.1), 0.9)],
    "leaf": [m.translucent((0.2, 0.4, 0.1)), m.diffuse((0.1, 0.3, 0.1)), m.transparent(0.2)],
}
CLOSURES = {
    "frost": c.rough_glass(1.5, 0.5, multiscatter=False),
    "refraction": c.closure(ClosureKind.REFRACTION, color=0.9, roughness=0.6, ior=1.4),
    "satin": c.glossy((0.9, 0.5, 0.2), 0.6, multiscatter=False),
}


def plane_seen_at(degrees, lobes=(), closures=()):
    """A plane in a white world, seen under one angle by a far and narrow camera."""
    b = SceneBuilder("plane")
    row = b.add_material("tested", lobes, closures=closures)
    corners = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
    b.add_mesh("plane", corners, [(0, 1, 2), (0, 2, 3)], row)
    b.set_world(1.0)
    t = math.radians(degrees)
    eye = (20 * math.sin(t), 0.0, 20 * math.cos(t))
    b.set_camera(scenes.camera(eye, (0, 0, 0), 8, 8, fov=0.002))
    return b.build()


def mean_of(scene, samples):
    found = trace(scene, samples, seed=11)
    return (
        found["combined"].mean(axis=(0, 1)),
        found.variance["combined"].sum(axis=(0, 1)) / 64**2,
    )


@pytest.mark.parametrize("degrees", [10.0, 65.0])
@pytest.mark.parametrize("name", LOBES)
def test_lobes_return_the_same_light(name, degrees, rng):
    found, variance = mean_of(plane_seen_at(degrees, LOBES[name]), 2000)
    other, spread = albedo(of_lobes(LOBES[name], degrees), 200_000, rng)
    # The camera is no eye at infinity: its angles differ by 1e-3.
    same_means(found, variance, other, spread, floor=1e-5)


@pytest.mark.parametrize("degrees", [10.0, 65.0])
@pytest.mark.parametrize("name", CLOSURES)
def test_closures_return_the_same_light(name, degrees, rng):
    closure = CLOSURES[name]
    found, variance = mean_of(plane_seen_at(degrees, closures=[closure]), 2000)
    surface = Resolver(closure)(degrees)
    other, spread = np.zeros(3), np.zeros(3)
    for part in (WIDE, NARROW):
        rows = samples(surface, part, 200_000, rng)
        # Radiance of the lower world is seen through the index squared.
        scale = np.where(rows[:, 8] > 0, surface.eta**-2, 1.0)[:, None]
        other += (rows[:, 4:7] * scale).mean(axis=0)
        spread += (rows[:, 4:7] * scale).var(axis=0) / len(rows)
    same_means(found, variance, other, spread, floor=1e-9)


def test_layers_textures_and_bounces_between_facets_are_refused():
    for closure in (
        c.principled(color=0.8), c.glossy(0.8, 0.5), c.rough_glass(1.5, 0.3),
    ):  # fmt: skip
        with pytest.raises(SceneError):
            trace(plane_seen_at(10.0, closures=[closure]), 2)


@pytest.mark.slow
@pytest.mark.parametrize("roughness", [0.2, 0.4, 0.8])
def test_the_engine_sees_a_ball_of_frost_in_a_white_sky_as_the_reference_does(roughness):
    # Its lobes are narrow, both, and wide: each path counts once.
    b = SceneBuilder("ball")
    frost = c.rough_glass(1.5, roughness, multiscatter=False)
    b.add_mesh(
        "ball", *scenes.sphere((0, 0, 0), 0.8, 2), b.add_material("frost", closures=[frost])
    )
    b.set_world(1.0)
    b.set_camera(scenes.camera((0, -4.5, 1), (0, 0, 0), 16, 16, fov=0.35))
    scene = b.build()
    reference = trace(scene, 800, seed=1)
    settings = Settings(passes=32, pixel_filter="BOX", filter_width=1.0)
    film = list(render(scene, settings))[-1].film
    layers = ("emission", "direct", "caustics", "indirect")
    found = sum(film.resolve(name).astype(float).mean() for name in layers)
    assert found == pytest.approx(reference["combined"].mean(), rel=0.02)
