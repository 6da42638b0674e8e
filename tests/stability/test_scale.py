"""Coordinate scale 1e-4 to 1e4 and offset 1e5: the same picture, path by path."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse
from photon_map.tests import scenes
from photon_map.tests.stability.support import LIGHT, moved, note, shot


def all_layers(size: int = 12):
    """A box with glass, mirror, lens blur, an area, a point and a sun: all estimators."""
    scene = scenes.cornell_glass(size, smooth=True)
    b = SceneBuilder()
    b.add_point_light("point", (0.5, -0.5, 0.8), 0.5, radius=0.05)
    b.add_spot_light("spot", scenes.look_at((-0.5, -0.8, 0.8), (0, 0, -1)), 2.0, 0.6)
    b.add_sun_light("sun", scenes.look_at((0, -3, 1), (0, 0, 0)), 0.5, angle=0.01)
    more = b.build()
    lights = np.concatenate([scene.lights, more.lights])
    shares = np.concatenate([scene.light_photons, more.light_photons])
    names = (*scene.light_names, "point", "spot", "sun")
    camera = replace(scene.camera, lens_radius=0.02, focus_distance=4.9)
    return replace(scene, lights=lights, light_photons=shares, light_names=names, camera=camera)


def compare(a, b, share):
    """Same seed, same random numbers: only paths that meet an edge may differ."""
    for name in LIGHT:
        x, y = a[name], b[name]
        note(x, y)
        assert abs(x.mean() / y.mean() - 1) < share, name
        # Root mean square difference over the image, relative to its root mean square.
        rms = np.sqrt(((x - y) ** 2).mean() / (y**2).mean())
        assert rms < 4 * share, f"{name}: {rms}"


@pytest.mark.parametrize("scale", [1e-4, 1e-2, 1e2, 1e4])
def test_scale_changes_no_picture(scale):
    scene = all_layers()
    compare(shot(moved(scene, scale)), shot(scene), 2e-3)


@pytest.mark.parametrize("offset", [(1e5, 0, 0), (-1e5, 1e5, 1e5)])
def test_offset_changes_no_picture(offset):
    scene = all_layers()
    compare(shot(moved(scene, offset=offset)), shot(scene), 2e-3)


def lens_floor(world: float, at: tuple[float, float], size: int = 8):
    """A glass ball of 1 cm above a floor patch at ``at`` in a world ``world`` metres wide."""
    b = SceneBuilder("lens")
    grey = b.add_material("grey", [diffuse(0.8)])
    x, y = at
    ball = scenes.sphere((x, y, 0.01), 0.005, 3)
    normals = scenes.sphere_normals(ball, (x, y, 0.01))
    b.add_mesh("ball", *ball, b.add_material("glass", [dielectric(1.5)]), normals)
    h = 0.05
    low, high = np.array((x - h, y - h)), np.array((x + h, y + h))
    b.add_mesh("patch", *scenes.quad((*low, 0), (high[0], low[1], 0), (*high, 0),
                                     (low[0], high[1], 0)), grey)  # fmt: skip
    if world > 1:
        b.add_mesh("land", *scenes.plane(world / 2, -1.0), grey)
        for s in (-1, 1):
            tower = scenes.box((s * world / 2 - 5, -5, -1), (s * world / 2 + 5, 5, 100))
            b.add_mesh(f"tower {s}", *tower, grey)
    b.add_sun_light("sun", scenes.look_at((0.2, 0, 1), (0, 0, 0)), 3.0, angle=0.01)
    b.set_camera(scenes.camera((x, y - 0.03, 0.04), (x, y, 0), size, size, fov=0.5))
    return b.build()


@pytest.mark.parametrize("at", [(0.0, 0.0), (123.456, -77.7), (480.0, 310.0)])
def test_caustic_of_a_lens_of_1_cm_in_a_scene_of_1_km(at):
    small = shot(lens_floor(0.1, (0.0, 0.0)), passes=16)
    large = shot(lens_floor(1000.0, at), passes=16)
    for name in ("caustics", "direct"):
        found, expected = large[name], small[name]
        note(found, expected)
        assert found.mean() == pytest.approx(expected.mean(), rel=0.01), name
        rms = np.sqrt(((found - expected) ** 2).mean() / (expected**2).mean())
        assert rms < 0.05, name
