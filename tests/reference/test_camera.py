"""The reference's camera: where a point is seen, and how wide a lens blurs it."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.reference.camera import film_plane
from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.camera_data import CameraData
from photon_map.core.scene.scene import SceneError
from photon_map.tests import scenes


def axis_pixel(camera: CameraData) -> tuple[float, float]:
    """Pixel position, from the bottom left, of the camera's axis."""
    table = film_plane(camera)
    x, y = -table[4, :2] / table[5, :2]
    return float(x), float(y)


@pytest.mark.parametrize(
    ("size", "fit", "side"),
    [((40, 20), "AUTO", 40), ((20, 40), "AUTO", 40), ((40, 20), "VERTICAL", 20),
     ((20, 40), "HORIZONTAL", 20)],
)  # fmt: skip
def test_shift_counts_in_the_fitted_side(size, fit, side):
    camera = CameraData(
        width=size[0], height=size[1], sensor_fit=fit, shift_x=0.1, shift_y=-0.2
    )
    x, y = axis_pixel(camera)
    assert x == pytest.approx(size[0] / 2 - 0.1 * side)
    assert y == pytest.approx(size[1] / 2 + 0.2 * side)


def test_field_of_view_follows_the_fit():
    def width_at_one(**options: object) -> float:
        camera = CameraData(width=40, height=20, lens=50.0, **options)  # type: ignore[arg-type]
        return float(film_plane(camera)[5, 0] * 40)

    assert width_at_one() == pytest.approx(36 / 50)
    # 24 mm over 20 rows of the same square pixels.
    assert width_at_one(sensor_fit="VERTICAL") == pytest.approx(24 / 50 * 2)
    # With AUTO the sensor's width goes with the larger side, here 20 x 3 against 40.
    assert width_at_one(pixel_aspect_y=3.0) == pytest.approx(36 / 50 * 40 / 60)


def test_row_zero_is_at_the_bottom_and_column_zero_left():
    b = SceneBuilder("corner light")
    b.add_mesh(
        "spark", *scenes.box((0.9, 0.9, -3), (1.1, 1.1, -2.9)), b.add_material("s", emission=1)
    )
    b.set_camera(CameraData(width=8, height=8, lens=36.0))
    found = trace(b.build(), 64)["emission"][:, :, 0]
    assert found[4:, 4:].sum() > 0
    assert found[:4].sum() == 0 and found[:, :4].sum() == 0


@pytest.mark.parametrize("focus", [1.0, 4.0])
def test_thin_lens_blurs_by_radius_times_defocus(focus):
    lens, distance, size, half = 0.2, 2.0, 64, 0.05
    b = SceneBuilder("blur")
    panel = scenes.quad(
        *[(x * half, y * half, -distance) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    )
    b.add_mesh("spark", *panel, b.add_material("spark", emission=1.0))
    camera = CameraData(
        width=size, height=size, lens=36.0, lens_radius=lens, focus_distance=focus
    )
    b.set_camera(camera)
    found = trace(b.build(), 1000, seed=3)["emission"][:, :, 0]
    pixel = distance * 1.0 / size
    middle = (np.arange(size) + 0.5 - size / 2) * pixel
    x, y = np.meshgrid(middle, middle)
    # In the plane of focus of the spark: a uniform disc, plus the square, plus the pixel.
    radius = lens * abs(distance - focus) / focus
    expected = radius**2 / 2 + 2 * half**2 / 3 + 2 * pixel**2 / 12
    moment = (found * (x**2 + y**2)).sum() / found.sum()
    assert moment == pytest.approx(expected, rel=0.03)
    assert found[np.hypot(x, y) > radius + 2 * half + 2 * pixel].sum() == 0
    # The lens spreads the light and loses none: the spark's share of the film.
    assert found.sum() * pixel**2 == pytest.approx(4 * half**2, rel=0.05)


def test_what_it_cannot_do_it_refuses():
    with pytest.raises(SceneError, match="no camera"):
        trace(SceneBuilder("empty").build(), 2)
    b = SceneBuilder("blades")
    b.set_camera(CameraData(width=2, height=2, blades=6, lens_radius=0.1))
    with pytest.raises(ValueError, match="round"):
        trace(b.build(), 2)


def test_empty_scene_shows_the_world():
    b = SceneBuilder("sky")
    b.set_world((0.1, 0.2, 0.3))
    b.set_camera(CameraData(width=2, height=3))
    found = trace(b.build(), 2)
    np.testing.assert_allclose(found["combined"][2, 1], (0.1, 0.2, 0.3))
