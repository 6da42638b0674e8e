"""The reference in closed environments of known radiance (Z-tests at level 0.01)."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse, mirror
from photon_map.tests import scenes
from photon_map.tests.statistics import same_means


def test_glowing_box_has_radiance_emission_over_one_minus_albedo():
    found = trace(scenes.furnace_box(albedo=0.5, emission=1.0), 3000, seed=3)
    same_means(found["combined"], found.variance["combined"], 2.0)
    # The orders of reflection are a geometric series: 1, a, a^2 / (1 - a).
    same_means(found["emission"], found.variance["emission"], 1.0, floor=1e-12)
    same_means(found["direct"], found.variance["direct"], 0.5)
    same_means(found["indirect"], found.variance["indirect"], 0.5)
    assert (found["caustics"] == 0).all()


def test_closed_sphere_around_a_point_light_has_radiance_one():
    scene = scenes.closed_sphere(albedo=0.5, intensity=np.pi)
    found = trace(scene, 4000, seed=4)
    # The inscribed polyhedron: the flux 4 pi^2 spreads over its own, smaller area.
    a, b, c = np.moveaxis(scene.vertices[scene.faces], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    mean = found["combined"].mean()
    sigma = np.sqrt(found.variance["combined"].sum(axis=(0, 1))[0]) / 16
    same_means(mean, sigma**2, 4 * np.pi / area, floor=1e-3)


def test_white_furnace_of_all_materials_is_exactly_one():
    b = SceneBuilder("white furnace")
    materials = {
        "glass": [dielectric(1.5)],
        "silver": [mirror(1.0)],
        "paint": [diffuse(1.0)],
        "mixed": [diffuse(0.5), mirror(0.2), dielectric(1.33, 0.3)],
    }
    for k, (name, lobes) in enumerate(materials.items()):
        ball = scenes.sphere((1.1 * k - 1.65, 0, 0), 0.5, 1)
        b.add_mesh(name, *ball, b.add_material(name, lobes))
    b.set_world(1.0)
    b.set_camera(scenes.camera((0, -6, 1), (0, 0, 0), 24, 8))
    found = trace(b.build(), 64, seed=5)
    # Every path ends in the world with throughput 1, apart from very long ones.
    same_means(found["combined"], found.variance["combined"], 1.0, floor=1e-9)
    assert found["emission"].min() < 0.9


@pytest.mark.parametrize(
    ("shells", "ior"), [([1.5], 1.5), ([1.33, 1.5], 1.5), ([1.5, 1.0], 1.0)]
)
def test_radiance_inside_a_medium_is_n_squared(shells, ior):
    # The camera is inside of concentric balls, outermost first, in a uniform world.
    b = SceneBuilder("inside glass")
    for k, n in enumerate(shells):
        ball = scenes.sphere((0, 0, 0), 2.0 - 0.5 * k, 2)
        b.add_mesh(f"ball {k}", *ball, b.add_material(f"ball {k}", [dielectric(n)]))
    b.set_world(1.0)
    b.set_camera(scenes.camera((0.1, 0.2, -0.1), (1, 1, 0), 6, 6))
    found = trace(b.build(), 200, seed=6)
    same_means(found["emission"], found.variance["emission"], ior**2, floor=1e-9)


def test_diffuse_inside_water_sees_the_world_through_the_surface():
    # A camera in water looks at a white floor in water: below a plane surface the light
    # is reflected back until it leaves, so the radiance in the water is n^2 everywhere.
    n = 1.33
    b = scenes.floor_scene([diffuse(1.0)], half=60.0, size=4, height=0.5)
    surface = scenes.plane(60.0, 1.0)
    b.add_mesh("water", *surface, b.add_material("water", [dielectric(n)]))
    b.set_world(1.0)
    found = trace(b.build(), 4000, seed=7)
    # The pool's open rim at 60 m lets 1e-3 of the light in and out past the surface.
    same_means(found["combined"], found.variance["combined"], n * n, floor=4e-3)


def test_same_bits_for_any_thread_count_and_other_bits_for_another_seed():
    scene = scenes.cornell_glass(6)
    one, two = trace(scene, 8, seed=1, threads=1), trace(scene, 8, seed=1, threads=2)
    assert (one["combined"] == two["combined"]).all()
    assert (one["combined"] != trace(scene, 8, seed=2)["combined"]).any()


def test_layers_add_up_and_sixteen_times_the_samples_quarter_the_spread():
    scene = scenes.cornell_glass(6)
    few, many = trace(scene, 200, seed=8), trace(scene, 3200, seed=9)
    parts = sum(many[name] for name in ("emission", "direct", "caustics", "indirect"))
    np.testing.assert_allclose(many["combined"], parts, rtol=1e-12)
    ratio = few.variance["direct"].sum() / many.variance["direct"].sum()
    assert 12 < ratio < 20
    same_means(few["direct"], few.variance["direct"], many["direct"], many.variance["direct"])
