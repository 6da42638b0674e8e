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
from photon_map.tests.stability.support import family, standard_error
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
BETWEEN_FACETS = {
    "frost": c.rough_glass(1.5, 0.6),
    "tinted frost": c.rough_glass(1.3, 0.8, color=(0.9, 0.6, 0.3)),
    "satin": c.glossy((0.9, 0.5, 0.2), 0.8),
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
    same_light(CLOSURES[name], degrees, rng, floor=1e-9)


@pytest.mark.parametrize("degrees", [10.0, 65.0])
@pytest.mark.parametrize("name", BETWEEN_FACETS)
def test_closures_with_light_between_facets_return_the_same_light(name, degrees, rng):
    # The engine's tables are off by 0.003 at most between their nodes.
    same_light(BETWEEN_FACETS[name], degrees, rng, floor=3e-3)


def same_light(closure, degrees, rng, floor):
    found, variance = mean_of(plane_seen_at(degrees, closures=[closure]), 2000)
    surface = Resolver(closure)(degrees)
    other, spread = np.zeros(3), np.zeros(3)
    for part in (WIDE, NARROW):
        rows = samples(surface, part, 200_000, rng)
        # Radiance of the lower world is seen through the index squared.
        scale = np.where(rows[:, 8] > 0, surface.eta**-2, 1.0)[:, None]
        other += (rows[:, 4:7] * scale).mean(axis=0)
        spread += (rows[:, 4:7] * scale).var(axis=0) / len(rows)
    same_means(found, variance, other, spread, floor=floor)


def test_layers_and_frost_in_other_media_are_refused():
    with pytest.raises(SceneError):
        trace(plane_seen_at(10.0, closures=[c.principled(color=0.8)]), 2)
    b = SceneBuilder("two glasses")
    for k, ior in enumerate((1.5, 1.3)):
        row = b.add_material(f"m{k}", closures=[c.rough_glass(ior, 0.5)])
        b.add_mesh(f"o{k}", *scenes.sphere((0, 0, 0), 1.0 + k, 1), row)
    b.set_camera(scenes.camera((0, -4.5, 1), (0, 0, 0), 4, 4))
    with pytest.raises(SceneError, match="in air alone"):
        trace(b.build(), 2)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("roughness", "multiscatter"),
    [(0.2, False), (0.4, False), (0.8, False), (0.3, True), (0.6, True), (0.8, True)],
)
def test_the_engine_sees_a_ball_of_frost_in_a_white_sky_as_the_reference_does(
    roughness, multiscatter
):
    # Its lobes are narrow, both, and wide: each path counts once.
    b = SceneBuilder("ball")
    frost = c.rough_glass(1.5, roughness, multiscatter=multiscatter)
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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("roughness", "multiscatter"), [(0.3, True), (0.6, True), (0.6, False), (0.8, True)]
)
def test_a_pane_of_frost_lets_the_photons_of_a_quad_through(roughness, multiscatter):
    """Photons go the other way: each event is that of the viewer whom they leave to.

    All is wide and even, so that no radius of a gather blurs anything.
    """
    b = SceneBuilder("pane")
    frost = c.rough_glass(1.5, roughness, multiscatter=multiscatter)
    pane = scenes.box((-4, -4, 1), (4, 4, 1.2))
    b.add_mesh("pane", *pane, b.add_material("frost", closures=[frost]))
    b.add_mesh("floor", *scenes.plane(4.0), b.add_material("grey", [m.diffuse(0.5)]))
    lamp = scenes.quad((-3, -3, 2.5), (-3, 3, 2.5), (3, 3, 2.5), (3, -3, 2.5))
    b.add_mesh("lamp", *lamp, b.add_material("lamp", [], emission=1.0))
    b.set_camera(scenes.camera((0, 0, 0.9), (0, 0, 0), 8, 8, up=(0, 1, 0), fov=1.0))
    scene = b.build()
    expected = trace(scene, 4000, seed=1)
    variance = expected.variance["combined"].sum() / expected["combined"].size ** 2
    runs = family(scene, runs=16, passes=16, photons_global=32768, photons_caustic=32768)
    means = runs["total"].mean(axis=(1, 2, 3))
    error = np.hypot(standard_error(means), np.sqrt(variance))
    # 3.3 standard errors at 15 degrees of freedom: 0.005. Of 6 runs the scatter can be half of
    # what it is: their tails are long.
    assert error < 0.01 * means.mean()
    assert abs(means.mean() - expected["combined"].mean()) < 3.3 * error
