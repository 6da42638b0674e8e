"""The engine's plumbing, with a core that only pretends: errors, cancel, borders, passes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blender.fake_core import update
from tests.blender.support import add_cube, headless_render, read_exr, save_exr


def test_the_first_row_is_at_the_bottom(bpy: Any, core: Any, tmp_path: Path) -> None:
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    image = read_exr(tmp_path / "a.exr")["ViewLayer.Combined"]
    assert image.shape == (30, 40, 4)
    assert image[0, :, 0] == pytest.approx(np.arange(40) + 0.875)
    assert image[:, 0, 1] == pytest.approx(np.arange(30) + 0.875)
    assert (image[..., 3] == 1).all()
    assert core.closed == 1


def test_every_pass_has_its_layer(bpy: Any, core: Any, tmp_path: Path) -> None:
    layer = bpy.context.view_layer
    for toggle in ("z", "normal", "diffuse_direct", "transmission_indirect", "emit"):
        setattr(layer, f"use_pass_{toggle}", True)
    layer.photon_map.use_pass_denoising = True
    layer.photon_map.use_pass_error = True
    layer.photon_map.use_pass_photon_density = True
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    new = bpy.app.version >= (5, 0, 0)
    image = read_exr(tmp_path / "a.exr")
    names = {
        "direct": "Diffuse Direct" if new else "DiffDir",
        "indirect": "Transmission Indirect" if new else "TransInd",
        "emission": "Emission" if new else "Emit",
    }
    assert set(image) == {
        f"ViewLayer.{name}"
        for name in (
            "Combined",
            "Depth",
            "Normal",
            "Caustics",
            "Denoising Albedo",
            "Noisy Image",
            "Denoising Normal",
            "Denoising Depth",
            "Error",
            "Photon Density",
        )
    } | {f"ViewLayer.{name}" for name in names.values()}
    assert image["ViewLayer.Depth"].shape == (30, 40, 1)
    assert (image["ViewLayer.Photon Density"] == 4000.0).all()
    assert (image["ViewLayer.Depth"] == 7.0).all()
    assert image["ViewLayer.Normal"][3, 4] == pytest.approx([0.0, 0.6, 0.8])
    assert image["ViewLayer.Denoising Albedo"][3, 4] == pytest.approx([0.1, 0.2, 0.3])
    assert image[f"ViewLayer.{names['direct']}"][3, 4] == pytest.approx([4.0, 3.0, 0.0])
    assert (image[f"ViewLayer.{names['indirect']}"] == 0.125).all()
    assert (image[f"ViewLayer.{names['emission']}"] == 0.25).all()
    assert (image["ViewLayer.Caustics"] == 0.5).all()
    assert image["ViewLayer.Error"][3, 4] == pytest.approx([0.01])


def test_the_file_says_what_it_took(bpy: Any, core: Any, tmp_path: Path) -> None:
    """Each view layer has its own numbers."""
    import OpenEXR

    bpy.context.scene.view_layers.new("Second")
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    with OpenEXR.File(str(tmp_path / "a.exr")) as file:
        header = dict(file.parts[0].header)
    for layer in ("ViewLayer", "Second"):
        said = {
            key.removeprefix(f"photon_map.{layer}."): value
            for key, value in header.items()
            if key.startswith(f"photon_map.{layer}.")
        }
        assert float(said.pop("peak_megabytes")) > 10
        assert said == {
            "passes": "4", "seconds": "1.00", "rays": "1500000", "photons": "1000",
            "film_megabytes": "1.0", "relative_error": "0.500000", "photon_megabytes": "3.0",
        }  # fmt: skip


def test_the_unfinished_image_is_shown(
    bpy: Any, core: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the user interface the result is written again and again."""
    from photon_map.addon import final

    written: list[int] = []
    real = final.write_film

    def write(engine: Any, film: Any, view_layer: Any, *others: Any) -> None:
        written.append(film.passes)
        real(engine, film, view_layer, *others)

    monkeypatch.setattr(final, "watched", lambda: True)
    monkeypatch.setattr(final, "REDRAW_INTERVAL", 0.0)
    monkeypatch.setattr(final, "write_film", write)
    bpy.context.view_layer.use_pass_z = True
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    assert written == [1, 2, 3, 4, 4]
    image = read_exr(tmp_path / "a.exr")
    assert image["ViewLayer.Combined"][5, 6] == pytest.approx([6.875, 5.875, 0.875, 1.0])
    assert (image["ViewLayer.Depth"] == 7.0).all()


def test_passes_that_are_off_are_not_there(bpy: Any, core: Any, tmp_path: Path) -> None:
    bpy.context.view_layer.photon_map.use_pass_caustics = False
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    assert set(read_exr(tmp_path / "a.exr")) == {"ViewLayer.Combined"}


def test_each_view_layer_is_rendered(bpy: Any, core: Any, tmp_path: Path) -> None:
    """Blue counts the faces, which differ between the layers."""
    only = bpy.data.collections.new("Only")
    bpy.context.scene.collection.children.link(only)
    only.objects.link(bpy.data.objects.new("First", add_cube(bpy, "Both").data))
    second = bpy.context.scene.view_layers.new("Second")
    second.layer_collection.children["Only"].exclude = True
    second.use_pass_z = True
    bpy.context.scene.view_layers.new("Off").use = False
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    image = read_exr(tmp_path / "a.exr")
    assert image["ViewLayer.Combined"][0, 0, 2] == pytest.approx(24.875)
    assert image["Second.Combined"][0, 0, 2] == pytest.approx(12.875)
    assert "Second.Depth" in image
    assert "ViewLayer.Depth" not in image
    assert not any(name.startswith("Off.") for name in image)
    assert core.closed == 2


@pytest.mark.parametrize("at", [0, 2])
def test_an_error_fails_the_operator_and_writes_nothing(
    bpy: Any, core: Any, tmp_path: Path, at: int
) -> None:
    core.fail_at = at
    save_exr(bpy, tmp_path / "a.exr")
    with pytest.raises(RuntimeError, match="the core broke"):
        bpy.ops.render.render(write_still=True)
    assert list(tmp_path.iterdir()) == []
    assert core.closed == 1
    core.fail_at = None
    bpy.ops.render.render(write_still=True)
    assert (tmp_path / "a.exr").is_file(), "the next render is a new one"


def test_an_error_in_the_second_layer_writes_nothing(
    bpy: Any, core: Any, tmp_path: Path
) -> None:
    bpy.context.scene.view_layers.new("Second")
    bpy.context.scene.view_layers.new("Third")
    save_exr(bpy, tmp_path / "a.exr")

    def count(number: int) -> None:
        core.fail_at = 3 if core.closed == 1 else None

    core.on_pass = count
    with pytest.raises(RuntimeError, match="the core broke"):
        bpy.ops.render.render(write_still=True)
    assert list(tmp_path.iterdir()) == []
    assert core.closed == 2, "the third layer was not begun"


def test_ctrl_c_fails_the_operator_and_writes_nothing(
    bpy: Any, core: Any, tmp_path: Path
) -> None:
    core.fail_at, core.error = 2, KeyboardInterrupt()
    save_exr(bpy, tmp_path / "a.exr")
    with pytest.raises(RuntimeError, match="interrupted"):
        bpy.ops.render.render(write_still=True)
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(KeyboardInterrupt):
        headless_render(bpy)


def test_an_error_while_registering_passes_is_shown(
    bpy: Any, core: Any, monkeypatch: pytest.MonkeyPatch, capfd: Any, tmp_path: Path
) -> None:
    """Blender drops what is reported while it asks for the passes."""
    from photon_map.addon import engine

    def broken(*_: Any) -> None:
        raise ValueError("no passes today")

    monkeypatch.setattr(engine, "register_passes", broken)
    bpy.context.scene.view_layers.new("Second")
    save_exr(bpy, tmp_path / "a.exr")
    with pytest.raises(RuntimeError, match="no passes today"):
        bpy.ops.render.render(write_still=True)
    assert "Traceback" in capfd.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_cancel_keeps_the_image(
    bpy: Any, core: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from photon_map.addon import final

    bpy.context.scene.photon_map.passes = 1000
    monkeypatch.setattr(final, "stopped", lambda engine: core.passes_made >= 3)
    save_exr(bpy, tmp_path / "a.exr")
    job = headless_render(bpy)
    assert core.passes_made == 3
    assert core.closed == 1
    assert job.update.passes == 3
    image = read_exr(tmp_path / "a.exr")["ViewLayer.Combined"]
    assert image[5, 6] == pytest.approx([6.875, 5.875, 0.875, 1.0])


def test_cancel_during_the_export(
    bpy: Any, core: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from photon_map.addon import final

    add_cube(bpy, "Cube")
    monkeypatch.setattr(final, "stopped", lambda engine: True)
    save_exr(bpy, tmp_path / "a.exr")
    bpy.ops.render.render(write_still=True)
    assert core.passes_made == 0
    assert core.closed == 0


def test_updates_reach_the_caller(bpy: Any, core: Any) -> None:
    from photon_map.addon import headless
    from photon_map.addon.job import CURRENT, Job

    seen: list[tuple[str, int]] = []
    job = Job(
        overrides={"passes": 3},
        on_update=lambda update: seen.append((update.phase, update.passes)),
    )
    headless._run(bpy.context.scene, job, png_path=None)
    assert seen == [("setup", 0), ("render", 1), ("render", 2), ("render", 3), ("done", 3)]
    assert CURRENT.get() is None


def test_an_error_of_the_caller_ends_the_render(bpy: Any, core: Any, tmp_path: Path) -> None:
    from photon_map.addon import headless
    from photon_map.addon.job import Job

    def stop(update: Any) -> None:
        if update.passes == 2:
            raise OSError("the pipe is broken")

    with pytest.raises(headless.HeadlessError, match="the pipe is broken"):
        headless._run(bpy.context.scene, Job(on_update=stop), tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []
    assert core.closed == 1


def test_warnings_are_shown(bpy: Any, core: Any, capfd: Any) -> None:
    """Those of the export and those of the plan, each once."""
    core.warnings = ("scene 'Scene' has no light",)
    bpy.data.objects.new("x", None)
    cube = add_cube(bpy, "Cube")
    cube.is_shadow_catcher = True
    bpy.ops.render.render()
    out = "".join(capfd.readouterr())
    assert out.count("shadow catchers are rendered") == 1
    assert out.count("has no light") == 1


def test_the_status_line_tells_pass_and_error(bpy: Any) -> None:
    from photon_map.addon.final import stats_line

    def at(passes: int, seconds: float, error: float) -> Any:
        return update("render", passes, None, error, seconds)

    line = stats_line("ViewLayer", at(16, 0, 0.05), 0.25)
    assert line == "ViewLayer | 25 % | Pass 16 | Error 5.00 %"
