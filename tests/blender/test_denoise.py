"""Denoising: less error, caustics as they were, and no picture lost where there is none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blender.support import headless_render, read_exr, save_exr
from tests.blender.test_citizen import build


def layers(bpy: Any, folder: Path, passes: int, seed: int = 0) -> dict[str, np.ndarray]:
    """Passes by name of the scene with a glass cube."""
    own = bpy.context.scene.photon_map
    own.passes, own.seed = passes, seed
    save_exr(bpy, folder / "a.exr")
    headless_render(bpy)
    return {k.split(".")[1]: v for k, v in read_exr(folder / "a.exr").items()}


def rest_of(image: dict[str, np.ndarray]) -> np.ndarray:
    """Light without caustics."""
    return image["Combined"][..., :3] - image["Caustics"]


def rel_mse(image: np.ndarray, truth: np.ndarray) -> float:
    gap = (image - truth)[..., :3]
    return float(np.mean(gap**2 / (truth[..., :3] ** 2 + 0.01 * truth[..., :3].mean() ** 2)))


def test_there_is_less_noise_and_caustics_are_kept(bpy: Any, tmp_path: Path) -> None:
    from photon_map.addon.denoise import is_available

    assert is_available(), "the bpy wheels bring it along"
    build(bpy)
    # An area lamp's mirror image is a few pixels of 100 and more: at so few passes, no picture.
    bpy.data.lights[0].type = "SUN"
    bpy.data.lights[0].energy = 3.0
    world = bpy.data.worlds.new("World")
    world.color = (0.5, 0.5, 0.5)
    bpy.context.scene.world = world
    truth = layers(bpy, tmp_path, 200, seed=9)
    bpy.context.view_layer.photon_map.use_pass_denoising = True
    plain = layers(bpy, tmp_path, 4)
    assert np.array_equal(plain["Combined"], plain["Noisy Image"])
    bpy.context.scene.photon_map.use_denoise = True
    got = layers(bpy, tmp_path, 4)
    assert np.array_equal(got["Noisy Image"], plain["Combined"])
    assert np.array_equal(got["Caustics"], plain["Caustics"])
    assert np.array_equal(got["Combined"][..., 3], plain["Combined"][..., 3])
    errors = [rel_mse(rest_of(image), rest_of(truth)) for image in (plain, got)]
    assert errors[1] < 0.7 * errors[0], errors
    # No more than the photons bring lies above what the denoiser makes of the rest.
    assert rest_of(got).min() > -1e-4


def test_without_the_library_the_image_is_as_it_was(
    bpy: Any, core: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Any
) -> None:
    from photon_map.addon import denoise

    monkeypatch.setattr(denoise, "_NAMES", {})
    bpy.context.scene.photon_map.use_denoise = True
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    image = read_exr(tmp_path / "a.exr")["ViewLayer.Combined"]
    assert image[5, 6] == pytest.approx([6.875, 5.875, 0.875, 1.0])
    assert "not denoised" in "".join(capfd.readouterr())


def test_a_render_that_was_stopped_is_not_denoised(
    bpy: Any, core: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: Any
) -> None:
    """A denoiser takes seconds; who presses Escape has the picture as it is."""
    from photon_map.addon import final

    def never(*_: Any) -> None:
        raise AssertionError("it is denoised")

    monkeypatch.setattr(final, "denoise", never)
    monkeypatch.setattr(final, "stopped", lambda engine: core.passes_made >= 3)
    bpy.context.scene.photon_map.use_denoise = True
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    assert read_exr(tmp_path / "a.exr")["ViewLayer.Combined"][5, 6, 3] == 1.0
    assert "not denoised: the render was stopped" in "".join(capfd.readouterr())


def test_the_switch_says_what_it_lacks(bpy: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from photon_map.addon import denoise
    from photon_map.addon.ui.render import draw_denoise

    class Column:
        active = True

        def __init__(self) -> None:
            self.words: list[str] = []

        def row(self) -> Any:
            self.inner = Column()
            return self.inner

        def prop(self, owner: Any, name: str) -> None:
            assert name in owner.bl_rna.properties

        def label(self, text: str, icon: str) -> None:
            self.words.append(text)

    own = bpy.context.scene.photon_map
    seen = []
    for names in (denoise._NAMES, {}):
        monkeypatch.setattr(denoise, "_NAMES", names)
        for own.use_denoise in (False, True):
            column = Column()
            draw_denoise(column, own)
            seen.append((column.inner.active, len(column.words)))
    assert seen == [(True, 0), (True, 0), (False, 0), (False, 1)]
