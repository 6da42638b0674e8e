"""Many lamps: which one is asked, which ones a ray may cross (chi-square, level 0.01)."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.lights.dispatch import see_lamp
from photon_map.core.lights.selection import select_light, selection_probability
from photon_map.core.lights.tree import next_lamp
from photon_map.core.scene.builder import SceneBuilder, diffuse
from photon_map.tests import scenes
from photon_map.tests.core.lights.support import prepared
from photon_map.tests.statistics import chi_square, same_means

COUNT = 40_000


def crowd(count, radius=0.05, far=True):
    """``count`` lamps of all kinds over a floor; their places (N, 3) and intensities (N,)."""
    rng = np.random.default_rng(3)
    places = rng.uniform((-4, -4, 0.5), (4, 4, 2.0), (count, 3))
    places[0] = places[1]  # two in one place
    power = rng.random(count) ** 4 * (rng.random(count) > 0.1)
    b = SceneBuilder("crowd")
    b.add_mesh("floor", *scenes.plane(5.0), b.add_material("floor", [diffuse(0.7)]))
    for k, place in enumerate(places):
        if far and k % 3 == 1:
            matrix = scenes.look_at(place, (0, 0, 0))
            b.add_area_light(f"l{k}", matrix, power[k], 0.3, 0.1, disk=k % 2 == 0)
        elif far and k % 3 == 2:
            b.add_spot_light(
                f"l{k}", scenes.look_at(place, (0, 0, 0)), power[k], 0.5, 0.2, radius
            )
        else:
            b.add_point_light(f"l{k}", place, power[k], radius)
    if far:
        b.add_sun_light("sun", np.eye(4), 0.5, angle=0.1)
        b.set_world(0.1)
    return b, places, power


@pytest.mark.parametrize("count", [2, 63, 500])
def test_lamps_are_drawn_as_their_probability_says(count, rng):
    lights = prepared(crowd(count)[0])[0]
    p = (0.3, -0.7, 0.0)
    drawn = [select_light(lights, p, u) for u in rng.random(COUNT)]
    prob = np.array([selection_probability(lights, p, k) for k in range(count + 3)])
    shines = lights.strength > 0
    assert prob.sum() == pytest.approx(1)
    assert (prob[shines] > 0).all() and (prob[~shines] == 0).all()
    counts = np.bincount([k for k, _ in drawn], minlength=count + 3)
    common = prob * COUNT > 5
    rest = (counts[~common].sum(), prob[~common].sum() * COUNT)
    chi_square(
        np.append(counts[common], rest[0]), np.append(prob[common] * COUNT, rest[1] or 1e-9)
    )
    assert all(p == pytest.approx(prob[k], rel=1e-9) for k, p in drawn)


def test_a_ray_is_shown_every_lamp_that_it_hits(rng):
    lights = prepared(crowd(500, radius=0.3)[0])[0]
    hits = 0
    for _ in range(400):
        o, d = rng.uniform(-4, 4, 3), rng.normal(size=3)
        if rng.random() < 0.2:
            d[rng.integers(3)] = 0.0
        o, d = tuple(o), tuple(d / np.linalg.norm(d))
        reach = rng.uniform(0, 8)
        found, node = set(), 0
        entry, node = next_lamp(lights.tree, node, o, d, reach)
        while entry >= 0:
            found.add(entry)
            entry, node = next_lamp(lights.tree, node, o, d, reach)
        for k in range(500):
            if lights.strength[k] > 0 and 0 < see_lamp(lights.lamps[k], o, d)[0] <= reach:
                hits += 1
                assert k in found
    assert hits > 100


def test_no_lamp_and_one_lamp():
    for count in (0, 1):
        b = SceneBuilder("few")
        if count:
            b.add_point_light("lamp", (0, 0, 1), 1.0, 0.1)
        lights = prepared(b)[0]
        assert select_light(lights, (0.0, 0.0, 0.0), 0.5)[0] == (0 if count else -1)
        entry, _ = next_lamp(lights.tree, 0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 9.0)
        assert entry == (0 if count else -1)


def test_two_thousand_lamps_light_a_floor_as_their_sum():
    b, places, power = crowd(2000, radius=0.0, far=False)
    camera = scenes.camera(
        (0, 0, 9), (0, 0, 0), 8, 8, up=(0, 1, 0), kind="ORTHOGRAPHIC", ortho_scale=4.0
    )  # type: ignore[arg-type]
    b.set_camera(camera)
    scene = b.build()
    settings = {"passes": 32, "pixel_filter": "BOX", "filter_width": 1.0}
    runs = [
        list(render(scene, Settings(seed=k, **settings)))[-1].film.resolve("direct")[..., 0]
        for k in range(6)
    ]
    nodes, weights = np.polynomial.legendre.leggauss(4)
    axis = ((np.arange(8) - 3.5)[:, None] * 0.5 + 0.25 * nodes).ravel()
    x, y = np.meshgrid(axis, axis)
    total = np.zeros_like(x)
    for (a, c, z), watt in zip(places, power, strict=True):
        total += watt * z / ((x - a) ** 2 + (y - c) ** 2 + z * z) ** 1.5
    means = np.einsum("yixj,i,j->yx", total.reshape(8, 4, 8, 4), weights, weights) / 4
    found = np.array(runs, float)
    same_means(
        found.mean(axis=0), found.var(axis=0, ddof=1) / 6, 0.7 / np.pi * means, freedom=5
    )
    # 32 samples of one lamp out of 2000 each: chosen by power alone, 0.35 were usual.
    assert found.std(axis=0).mean() / found.mean() < 0.15
