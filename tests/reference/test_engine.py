"""The engine against the reference and against closed forms of whole images.

Each render of a family has a seed of its own, so the family's spread gives the variance;
levels are 0.01 per call, by t-tests. A relative bias that the photon map may have at this
number of passes is stated where it is allowed.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse, mirror
from photon_map.tests import scenes
from photon_map.tests.statistics import same_means

RUNS = 8


def film(scene, seed=0, **options):
    chosen = {"passes": 8, "pixel_filter": "BOX", "filter_width": 1.0, **options}
    return list(render(scene, Settings(seed=seed, **chosen)))[-1].film


def family(scene, **options):
    """Renders of ``RUNS`` seeds: layer -> (RUNS, h, w, 3) float64."""
    films = [film(scene, seed, **options) for seed in range(RUNS)]
    layers = ("emission", "direct", "caustics", "indirect")
    return {name: np.array([f.resolve(name).astype(float) for f in films]) for name in layers}


def agrees(runs, expected, variance=0.0, bias=0.0):
    """Z-test of the runs' mean over axis 0, ``bias`` relative to ``expected``."""
    spread = runs.var(axis=0, ddof=1) / RUNS
    floor = bias * np.abs(expected) + 1e-9
    same_means(runs.mean(axis=0), spread, expected, variance, floor=floor, freedom=RUNS - 1)


@pytest.mark.parametrize("smooth", [False, True])
def test_each_layer_of_cornell_glass_agrees_with_the_reference(smooth):
    scene = scenes.cornell_glass(16, smooth=smooth)
    found = family(scene)
    reference = trace(scene, 2000, seed=1)
    for name, runs in found.items():
        # Means over the image by channel: a pixel is as wide as the caustic's details.
        mean = reference[name].mean(axis=(0, 1))
        variance = reference.variance[name].mean(axis=(0, 1)) / 16**2
        bias = {"caustics": 0.02, "indirect": 0.02}.get(name, 0.0)
        agrees(runs.mean(axis=(1, 2)), mean, variance, bias)
    # Light sampling and hits of lights have no bias: pixel by pixel.
    agrees(found["direct"], reference["direct"], reference.variance["direct"])


def test_plane_mirror_is_a_virtual_light_for_photons():
    # The reference cannot see the caustic of a point: here the photons stand alone.
    scene = scenes.mirror_caustic(24, radius=0.0)

    def irradiance(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 4.0 * 1.5 / ((x - 3.5) ** 2 + (y - 0.2) ** 2 + 1.5**2) ** 1.5

    expected = 0.8 / np.pi * scenes.floor_mean(scene, irradiance)
    runs = family(scene)["caustics"][..., 0]
    agrees(runs, expected, bias=0.02)
    agrees(runs.mean(axis=(1, 2)), expected.mean(), bias=0.002)


def slab_transmittance(theta: float, n: float) -> float:
    """(1 - F) / (1 + F) of a slab with all its internal reflections."""
    t = math.asin(math.sin(theta) / n)
    s = math.sin(theta - t) / math.sin(theta + t)
    p = math.tan(theta - t) / math.tan(theta + t)
    f = (s * s + p * p) / 2
    return (1 - f) / (1 + f)


@pytest.mark.parametrize("theta", [0.01, 0.5, 1.2])
def test_sun_through_a_slab_arrives_as_a_caustic_of_fresnels_share(theta):
    b = scenes.floor_scene([diffuse(0.8)], half=3.0, size=8, height=0.4)
    slab = scenes.glass_slab(1.5, half=3.0)
    b.add_mesh("slab", *slab, b.add_material("slab", [dielectric(1.5)]))
    down = scenes.look_at((math.sin(theta), 0, math.cos(theta)), (0, 0, 0))
    b.add_sun_light("sun", down, 3.0)
    found = family(b.build(), photons_caustic=32768)
    expected = 0.8 / np.pi * 3 * math.cos(theta) * slab_transmittance(theta, 1.5)
    agrees(found["caustics"].mean(axis=(1, 2)), np.full(3, expected), bias=0.005)
    assert (found["direct"] == 0).all()


def inside_of(shells):
    """A camera within balls of these indices in a white sky."""
    b = SceneBuilder("inside glass")
    for k, n in enumerate(shells):
        ball = scenes.sphere((0, 0, 0), 2.0 - 0.5 * k, 2)
        b.add_mesh(f"ball {k}", *ball, b.add_material(f"ball {k}", [dielectric(n)]))
    b.set_world(1.0)
    b.set_camera(scenes.camera((0.1, 0.2, -0.1), (1, 1, 0), 6, 6))
    return b.build()


@pytest.mark.parametrize("split", [{"split_depth": 0}, {}, {"split_least": 0.3}])
@pytest.mark.parametrize(("shells", "ior"), [([1.5], 1.5), ([1.33, 1.5], 1.5)])
def test_radiance_inside_a_medium_is_n_squared(shells, ior, split):
    """Each path carries all of it: one that is not split, and the branches of one together.

    Also where faint branches are followed by roulette.
    """
    found = film(inside_of(shells), **split).resolve("emission")
    np.testing.assert_allclose(found, ior**2, rtol=1e-5)


def test_glowing_box_reaches_its_closed_form():
    found = family(scenes.furnace_box(albedo=0.5, emission=1.0))
    assert (found["emission"] == 1).all()
    agrees(found["direct"].mean(axis=(1, 2)), np.full(3, 0.5))
    # The global map loses light at the box's edges: boundary bias, shrinking with the radius.
    agrees(found["indirect"].mean(axis=(1, 2)), np.full(3, 0.5), bias=0.06)


def test_white_furnace_of_mirror_paint_and_glass():
    b = SceneBuilder("white furnace")
    for k, lobes in enumerate(([mirror(1.0)], [diffuse(1.0)], [dielectric(1.5)])):
        ball = scenes.sphere((1.1 * k - 1.1, 0, 0), 0.5, 1)
        b.add_mesh(f"ball {k}", *ball, b.add_material(f"ball {k}", lobes))
    b.set_world(1.0)
    b.set_camera(scenes.camera((0, -5, 1), (0, 0, 0), 18, 6))
    total = sum(family(b.build()).values())
    # Chains of total reflections longer than camera_depth are cut: 1e-3 of the light.
    agrees(total.mean(axis=(1, 2)), np.ones(3), bias=4e-3)
