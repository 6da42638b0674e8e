"""Lamps in the plane of a face, and glowing faces far from the scene's middle."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.photon_pass import Batch, trace_batch
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import SceneBuilder, diffuse
from photon_map.core.scene.scene import Scene
from photon_map.tests import scenes

OPTIONS = {"passes": 8, "pixel_filter": "BOX", "filter_width": 1.0}


def ceiling_lamp(height: float) -> Scene:
    """The inside of a box, z = -1 .. 1, under an area lamp at ``height``."""
    b = SceneBuilder("ceiling lamp")
    b.add_mesh("box", *scenes.box((-1, -1, -1), (1, 1, 1)), b.add_material("w", [diffuse(0.5)]))
    matrix = np.eye(4)
    matrix[2, 3] = height
    b.add_area_light("lamp", matrix, 3.0, 0.7, 0.5)
    b.set_camera(scenes.camera((0, 0, 0.9), (0, 0, 0), 8, 8, up=(0, 1, 0), fov=1.2))
    return b.build()


@pytest.mark.parametrize("above", [0.0, 1e-7, -1e-7])
def test_a_lamp_in_the_plane_of_the_ceiling_shines_as_one_below_it(above):
    at, below = (
        list(render(ceiling_lamp(z), Settings(**OPTIONS)))[-1].film
        for z in (1.0 + above, 0.9999)
    )
    for layer in ("direct", "indirect"):
        found, expected = at.resolve(layer), below.resolve(layer)
        # Same seed, nearly the same paths.
        np.testing.assert_allclose(found.mean(), expected.mean(), rtol=0.01)
        assert (found > 0.5 * expected).all(), f"{layer}: dark pixels"


def test_no_photon_of_a_lamp_in_the_ceiling_is_lost():
    settings = Settings(photon_depth=1)
    prepared = prepare(ceiling_lamp(1.0), settings)
    walk = trace_batch(prepared, settings, 0, Batch(False, 0, 4096, 4096))
    flux = walk.photons["flux"][:, 0].sum(dtype=np.float64)
    assert flux == pytest.approx(3.0 * 0.35 * np.pi, rel=1e-6)


@pytest.mark.parametrize("distance", [3.0, 300.0, 3e4])
def test_a_glowing_face_far_away_lights_a_fine_floor(distance):
    """A face of ``distance`` side over a floor of small faces: no shadow ray hits its goal."""
    b = SceneBuilder("far")
    steps = np.linspace(-0.5, 0.5, 41)
    points = np.array([(x, y, 0.0) for y in steps for x in steps])
    first = np.array([r * 41 + c for r in range(40) for c in range(40)])
    faces = np.concatenate(
        [
            np.stack([first, first + 1, first + 42], axis=1),
            np.stack([first, first + 42, first + 41], axis=1),
        ]
    )
    b.add_mesh("floor", points, faces, b.add_material("floor", [diffuse(0.5)]))
    glow = b.add_material("glow", [], emission=2.0)
    h = distance / 2
    b.add_mesh(
        "sky", *scenes.quad((-h, h, distance), (h, h, distance), (h, -h, distance),
                            (-h, -h, distance)), glow,
    )  # fmt: skip
    b.set_camera(scenes.camera((0, 0, 1), (0, 0, 0), 8, 8, up=(0, 1, 0), fov=0.6))
    film = list(render(b.build(), Settings(**{**OPTIONS, "passes": 64})))[-1].film
    found = film.resolve("direct")[..., 0].astype(np.float64)
    # Form factor of a coaxial square of side a at distance a, from below: Howell C-11.
    x = 0.5
    part = x / np.sqrt(1 + x * x) * np.arctan(x / np.sqrt(1 + x * x))
    factor = 4 / (2 * np.pi) * 2 * part
    error = 3.7 * found.std(ddof=1) / 8
    assert error < 0.01
    # 3.7 standard errors at 63 pixels: 0.0005; the nearest floor spreads over 0.1 of the sky.
    assert abs(found.mean() - 0.5 * 2.0 * factor) < error + (0.005 if distance < 10 else 0)
