"""Border renders lie where Blender puts them, with and without cropping."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blender.support import headless_render, read_exr, save_exr


def set_border(bpy: Any, border: tuple[float, float, float, float], crop: bool) -> None:
    render = bpy.context.scene.render
    render.use_border, render.use_crop_to_border = True, crop
    # Blender keeps minimum and maximum apart while they are set.
    render.border_min_x, render.border_min_y = 0.0, 0.0
    render.border_max_x, render.border_max_y = 1.0, 1.0
    render.border_min_x, render.border_min_y = border[:2]
    render.border_max_x, render.border_max_y = border[2:]


def test_border_without_crop(bpy: Any, core: Any, tmp_path: Path) -> None:
    set_border(bpy, (0.25, 0.1, 0.5, 0.7), crop=False)
    save_exr(bpy, tmp_path / "a.exr")
    job = headless_render(bpy)
    assert job.settings.region == (10, 3, 20, 21)
    image = read_exr(tmp_path / "a.exr")["ViewLayer.Combined"]
    assert image.shape == (30, 40, 4)
    assert image[3, 10] == pytest.approx([10.875, 3.875, 0.875, 1.0])
    assert image[20, 19] == pytest.approx([19.875, 20.875, 0.875, 1.0])
    outside = np.ones((30, 40), bool)
    outside[3:21, 10:20] = False
    assert not image[outside].any()


def test_border_with_crop(bpy: Any, core: Any, tmp_path: Path) -> None:
    set_border(bpy, (0.25, 0.1, 0.5, 0.7), crop=True)
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    image = read_exr(tmp_path / "a.exr")["ViewLayer.Combined"]
    assert image.shape == (18, 10, 4)
    assert image[0, 0] == pytest.approx([10.875, 3.875, 0.875, 1.0])


@pytest.mark.parametrize("crop", [False, True])
def test_any_border_fits_blenders_rounding(
    bpy: Any, core: Any, tmp_path: Path, crop: bool
) -> None:
    """Sizes that are one off would raise, offsets that are one off would shift the ramp."""
    rng = np.random.default_rng(5)
    render = bpy.context.scene.render
    bpy.context.scene.photon_map.passes = 1
    cases = [np.sort(rng.random((2, 2)), axis=0).ravel() for _ in range(25)]
    halves = [np.array([k + 0.5, k + 0.5, k + 7.5, k + 7.5]) / 64 for k in range(4)]
    for number, case in enumerate(cases + halves):
        if number < len(cases):
            render.resolution_x, render.resolution_y = rng.integers(30, 99, 2).tolist()
        else:
            render.resolution_x = render.resolution_y = 64
        if (case[2:] - case[:2]).min() < 0.1:
            continue
        set_border(bpy, tuple(case.tolist()), crop=crop)
        save_exr(bpy, tmp_path / "a.exr")
        job = headless_render(bpy)
        image = read_exr(tmp_path / "a.exr")["ViewLayer.Combined"]
        x0, y0, x1, y1 = job.settings.region
        if crop:
            assert image.shape[:2] == (y1 - y0, x1 - x0)
        else:
            image = image[y0:y1, x0:x1]
        expected = np.mgrid[y0:y1, x0:x1].astype(float) + 0.875
        assert image[..., 0] == pytest.approx(expected[1])
        assert image[..., 1] == pytest.approx(expected[0])


def test_a_border_around_everything_is_none(bpy: Any, core: Any, tmp_path: Path) -> None:
    set_border(bpy, (0.0, 0.0, 1.0, 1.0), crop=False)
    save_exr(bpy, tmp_path / "a.exr")
    assert headless_render(bpy).settings.region is None
    assert read_exr(tmp_path / "a.exr")["ViewLayer.Combined"].shape == (30, 40, 4)
