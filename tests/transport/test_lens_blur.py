"""The thin lens: a point off the focus becomes a disc of radius R |d - f| / f."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.scene.builder import SceneBuilder
from photon_map.tests import scenes

SIZE = 65


def picture(distance, focus, radius, **options):
    """A small glowing square on the axis at ``distance``, seen through the lens."""
    b = SceneBuilder("lens")
    h = 0.02 * distance
    square = scenes.quad((-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0))
    b.add_mesh("spot", *square, b.add_material("glow", [], emission=1.0))
    camera = scenes.camera((0, 0, distance), (0, 0, 0), SIZE, SIZE, up=(0, 1, 0))
    b.set_camera(replace(camera, lens_radius=radius, focus_distance=focus, **options))
    settings = Settings(passes=512, pixel_filter="BOX", filter_width=1.0)
    return list(render(b.build(), settings))[-1].film.resolve("emission")[..., 0]


def spread(image):
    """Root mean square distance from the middle, in pixels, along x and y."""
    axis = np.arange(SIZE) - (SIZE - 1) / 2
    weight = image.astype(np.float64) / image.sum(dtype=np.float64)
    return np.sqrt((weight * axis**2).sum()), np.sqrt((weight * axis[:, None] ** 2).sum())


@pytest.mark.parametrize(("distance", "focus"), [(4.0, 2.0), (2.0, 3.0)])
def test_blur_has_the_width_of_the_circle_of_confusion(distance, focus):
    radius = 0.5
    per_metre = SIZE / (2 * np.tan(np.radians(20))) / distance
    circle = radius * abs(distance - focus) / focus * per_metre
    found = spread(picture(distance, focus, radius))
    # A disc of radius c has an rms of c / 2 along an axis; the square and pixel add theirs.
    square = 0.02 * distance * per_metre
    expected = np.sqrt(circle**2 / 4 + square**2 / 3 + 1 / 12)
    np.testing.assert_allclose(found, expected, rtol=0.03)


def test_the_plane_of_focus_is_sharp():
    radius, distance = 0.3, 3.0
    image = picture(distance, distance, radius)
    assert image[30:35, 30:35].sum() == pytest.approx(image.sum(), rel=1e-6)


def test_an_anamorphic_aperture_is_squeezed_along_x():
    x, y = spread(picture(4.0, 2.0, 0.6, blade_ratio=2.0))
    assert y / x == pytest.approx(2.0, rel=0.06)


def test_a_three_bladed_aperture_is_a_triangle():
    image = picture(4.0, 2.0, 0.7, blades=3)
    per_metre = SIZE / (2 * np.tan(np.radians(20))) / 4.0
    circle = 0.7 * per_metre
    # Half of a usual pixel's light: the brightest one is bright by chance.
    lit = (image > 0.5 * np.percentile(image[image > 0], 80)).sum()
    triangle = 3 * np.sqrt(3) / 4 * circle**2
    assert lit == pytest.approx(triangle, rel=0.15)
