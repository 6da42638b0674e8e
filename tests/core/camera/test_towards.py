"""Rays from the lens towards a place: the camera's own, and what they are worth."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.camera.lens import camera_ray, towards
from photon_map.core.camera.perspective import camera_tables
from photon_map.core.film.filters import filter_table
from photon_map.core.geometry.mesh import Centre
from photon_map.core.scene.camera_data import CameraData
from photon_map.tests import scenes

CAMERAS = {
    "pinhole": {"shift_x": 0.2, "shift_y": -0.1, "clip_start": 0.3, "clip_end": 40.0},
    "lens": {"lens_radius": 0.2, "focus_distance": 2.5, "blades": 5, "blade_ratio": 1.5},
    "parallel": {"kind": "ORTHOGRAPHIC", "ortho_scale": 4.0, "clip_start": 0.3},
    "parallel lens": {
        "kind": "ORTHOGRAPHIC", "ortho_scale": 4.0, "lens_radius": 0.4, "focus_distance": 2.0,
    },
}  # fmt: skip


def tables(options):
    matrix = scenes.camera((1.0, -2.0, 1.5), (0.1, 0.2, 0.0), 8, 6).matrix
    return camera_tables(
        CameraData(width=8, height=6, matrix=matrix, **options),
        Centre(np.zeros(3), 1.0), filter_table("BOX", 1.0),
    )  # fmt: skip


@pytest.mark.parametrize("name", CAMERAS)
def test_a_ray_towards_a_place_is_the_cameras_own(name, rng):
    camera = tables(CAMERAS[name])
    for _ in range(20):
        x, y = int(rng.integers(8)), int(rng.integers(6))
        u = rng.random(4)
        o, d, before, reach = camera_ray(camera, x, y, *u)
        p = np.array(o) + rng.uniform(0.5, 5.0) * np.array(d)
        found = towards(camera, tuple(p), u[2], u[3])
        np.testing.assert_allclose(found[:2], (x + u[0], y + u[1]), atol=1e-9)
        np.testing.assert_allclose(found[2], o, atol=1e-9)
        np.testing.assert_allclose(found[3], d, atol=1e-9)
        np.testing.assert_allclose(found[4:6], (before, reach), rtol=1e-9)


@pytest.mark.parametrize("name", CAMERAS)
def test_importance_is_film_per_solid_angle(name, rng):
    camera = tables(CAMERAS[name])
    for _ in range(5):
        u = rng.random(4)
        o, d, before, _ = camera_ray(camera, 3, 2, *u)
        way = rng.uniform(0.5, 5.0)
        p, d = np.array(o) + way * np.array(d), np.array(d)
        right = np.cross(d, (0.3, 0.5, 0.8))
        right /= np.linalg.norm(right)
        step = 1e-5
        moved = [
            np.array(towards(camera, tuple(p + s * step * axis), u[2], u[3])[:2])
            for axis in (right, np.cross(d, right)) for s in (1, -1)
        ]  # fmt: skip
        columns = (moved[0] - moved[1], moved[2] - moved[3])
        area = abs(np.linalg.det(np.array(columns))) / (2 * step) ** 2
        if not camera.orthographic:
            area *= (way + before) ** 2
        assert towards(camera, tuple(p), u[2], u[3])[6] == pytest.approx(area, rel=1e-6)


def test_what_lies_behind_the_camera_is_not_seen():
    camera = tables(CAMERAS["pinhole"])
    behind = tuple(camera.position - camera.axes[2])
    assert towards(camera, behind, 0.5, 0.5)[6] == 0.0
