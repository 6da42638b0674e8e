"""Rays of the camera: orthographic pixels, clipping, aperture."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.camera.lens import camera_ray, sample_lens
from photon_map.core.camera.perspective import camera_tables
from photon_map.core.film.filters import filter_table
from photon_map.core.geometry.mesh import Centre
from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene.builder import SceneBuilder, diffuse
from photon_map.core.scene.camera_data import CameraData
from photon_map.core.scene.scene import SceneError
from photon_map.tests import scenes
from photon_map.tests.statistics import same_means


def tables(**options):
    return camera_tables(
        CameraData(**options), Centre(np.zeros(3), 1.0), filter_table("BOX", 1.0)
    )


def ray(camera, x, y, u_lens=0.5, v_lens=0.5):
    o, d, before, reach = camera_ray(camera, x, y, 0.5, 0.5, u_lens, v_lens)
    return np.array(o), np.array(d), before, reach


@pytest.mark.parametrize(
    ("size", "fit", "fitted"),
    [((40, 20), "AUTO", 40), ((20, 40), "AUTO", 40), ((40, 20), "VERTICAL", 20),
     ((20, 40), "HORIZONTAL", 20)],
)  # fmt: skip
def test_orthographic_pixels_are_parallel_and_equally_wide(size, fit, fitted):
    camera = tables(
        width=size[0], height=size[1], kind="ORTHOGRAPHIC", ortho_scale=6.0,
        sensor_fit=fit, shift_x=0.25, shift_y=-0.5,
    )  # fmt: skip
    pixel = 6.0 / fitted
    for x, y in ((0, 0), (size[0] - 1, 3)):
        o, d, _, _ = ray(camera, x, y)
        np.testing.assert_allclose(d, (0, 0, -1), atol=1e-12)
        expected = ((x + 0.5 - size[0] / 2) * pixel + 1.5, (y + 0.5 - size[1] / 2) * pixel - 3)
        np.testing.assert_allclose(o[:2], expected)


def test_orthographic_lens_meets_in_the_plane_of_focus():
    camera = tables(
        width=8, height=8, kind="ORTHOGRAPHIC", ortho_scale=4.0, lens_radius=0.3,
        focus_distance=2.5,
    )  # fmt: skip
    centre, _, _, _ = ray(tables(width=8, height=8, kind="ORTHOGRAPHIC", ortho_scale=4.0), 2, 3)
    for u, v in ((0.1, 0.3), (0.9, 0.8)):
        o, d, _, _ = ray(camera, 2, 3, u, v)
        assert np.hypot(*(o - centre)[:2]) <= 0.3
        at_focus = o + d * (2.5 / -d[2])
        np.testing.assert_allclose(at_focus[:2], centre[:2], atol=1e-12)


@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
def test_clipping_counts_along_the_axis(kind):
    camera = tables(width=8, height=8, kind=kind, lens=18.0, clip_start=0.5, clip_end=4.0)
    o, d, before, reach = ray(camera, 0, 7)
    assert o[2] == pytest.approx(-0.5)
    assert (o + d * reach)[2] == pytest.approx(-4.0)
    assert before * -d[2] == pytest.approx(0.5)


@pytest.mark.parametrize("blades", [3, 4, 6])
def test_a_side_of_the_aperture_is_to_the_right(blades, rng):
    # As Cycles 5.0 and 5.2 draw it: found from the blur of a small light.
    camera = tables(width=8, height=8, lens_radius=1.0, blades=blades)
    points = np.array([sample_lens(camera, u, v) for u, v in rng.random((4000, 2))])
    inner = np.cos(np.pi / blades)
    assert inner - 0.02 < points[:, 0].max() <= inner + 1e-9


def stack(kind):
    """Three panels at z = 0, -1, -2, before a world of 0.25."""
    b = SceneBuilder("panels")
    for k, (half, glow) in enumerate(((0.4, 1.0), (0.6, 2.0), (0.9, 4.0))):
        b.add_mesh(f"p{k}", *scenes.plane(half, -k), b.add_material(f"p{k}", emission=glow))
    b.set_world(0.25)
    b.set_camera(
        scenes.camera(
            (0, 0, 2), (0, 0, 0), 8, 8, up=(0, 1, 0), kind=kind, ortho_scale=2.0,
            clip_start=2.5, clip_end=3.5,
        )  # type: ignore[arg-type]
    )  # fmt: skip
    return b.build()


@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
def test_what_is_clipped_is_not_seen(kind):
    scene = stack(kind)
    options = Settings(passes=64, pixel_filter="BOX", filter_width=1.0)
    found = list(render(scene, options))[-1].film.resolve("emission")
    assert found[4, 4, 0] == pytest.approx(2.0), "neither the nearer nor the farther panel"
    assert found[0, 0, 0] == pytest.approx(0.25)
    expected = trace(scene, 400)
    # Edge pixels: the variance of both, level 0.01.
    same_means(
        found, expected.variance["emission"] * 400 / 64, expected["emission"],
        expected.variance["emission"], floor=1e-6,
    )  # fmt: skip


def test_orthographic_floor_agrees_with_the_closed_form():
    b = SceneBuilder("floor")
    b.add_mesh("floor", *scenes.plane(4.0), b.add_material("floor", [diffuse(0.5)]))
    b.add_point_light("lamp", (0, 0, 1.5), 3.0)
    b.set_camera(
        scenes.camera(
            (0, 0, 2), (0, 0, 0), 4, 4, up=(0, 1, 0), kind="ORTHOGRAPHIC", ortho_scale=2.0
        )  # type: ignore[arg-type]
    )
    options = Settings(passes=256, pixel_filter="BOX", filter_width=1.0)
    found = list(render(b.build(), options))[-1].film.resolve("direct")[..., 0]
    nodes, weights = np.polynomial.legendre.leggauss(6)
    place = (np.arange(4) - 1.5)[:, None] * 0.5 + 0.25 * nodes
    x, y = place[None, :, None, :], place[:, None, :, None]
    values = 0.5 / np.pi * 3.0 * 1.5 / (x * x + y * y + 2.25) ** 1.5
    expected = np.einsum("yxij,i,j->yx", values, weights, weights) / 4
    np.testing.assert_allclose(found, expected, rtol=4e-3)


def test_contradictions_are_refused():
    for bad in ({"clip_start": 2.0, "clip_end": 1.0}, {"kind": "ROUND"}, {"ortho_scale": 0.0}):
        b = SceneBuilder("bad")
        b.set_camera(CameraData(width=2, height=2, **bad))
        with pytest.raises(SceneError):
            b.build()
