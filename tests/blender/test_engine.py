"""The engine's plumbing, with a core that only pretends: errors, cancel, borders, passes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.blender.support import add_camera, add_cube, headless_render, read_exr, save_exr


def update(
    phase: str, passes: int, film: Any, error: float, seconds: float, plan: Any = None
) -> Any:
    """Looks like ``core.Update``, whose import needs Numba."""
    return SimpleNamespace(
        phase=phase, passes=passes, film=film, relative_error=error, seconds=seconds,
        setup_seconds=0.5, plan=plan, message="",
    )  # fmt: skip


class FakeFilm:
    """A ramp in which every pixel tells its place.

    The direct light's red is the column and its green the row from the bottom, both of the
    whole image; its blue counts the faces of the scene.
    """

    def __init__(self, region: tuple[int, int, int, int], faces: int) -> None:
        x0, y0, x1, y1 = region
        self.width, self.height, self.passes = x1 - x0, y1 - y0, 0
        self.statistics = SimpleNamespace(non_finite=0)
        rows, columns = np.mgrid[y0:y1, x0:x1]
        direct = np.stack([columns, rows, np.full_like(rows, faces)], axis=2)
        self.layers = {
            "direct": direct,
            "emission": self.flat(0.25),
            "caustics": self.flat(0.5),
            "indirect": self.flat(0.125),
            "depth": self.flat(7.0),
            "normal": self.flat(0.0, 0.6, 0.8),
            "albedo": self.flat(0.1, 0.2, 0.3),
            "combined": np.concatenate([direct + 0.875, self.flat(1.0)], axis=2),
        }
        for layer in ("emission", "caustics", "indirect"):
            self.layers[layer] = np.repeat(self.layers[layer], 3, axis=2)
        self.LAYERS = {name: layer.shape[2] for name, layer in self.layers.items()}

    def flat(self, *values: float) -> np.ndarray:
        return np.broadcast_to(values, (self.height, self.width, len(values)))

    def resolve(self, layer: str) -> np.ndarray:
        assert self.passes > 0
        return np.ascontiguousarray(self.layers[layer], dtype=np.float32)


class FakeCore:
    """Takes the place of ``core.render``, with ``FakeFilm``."""

    def __init__(self) -> None:
        self.passes_made = 0
        self.closed = 0
        self.fail_at: int | None = None
        self.error: BaseException = ValueError("the core broke")
        self.on_pass: Callable[[int], None] = lambda number: None
        self.warnings: tuple[str, ...] = ()

    def render(self, scene: Any, settings: Any) -> Iterator[Any]:
        x0, y0, x1, y1 = settings.region or (0, 0, scene.camera.width, scene.camera.height)
        film = FakeFilm((x0, y0, x1, y1), len(scene.faces))
        plan = SimpleNamespace(stages=(), warnings=self.warnings)
        try:
            yield update("setup", 0, film, float("inf"), 0.0, plan)
            for number in range(settings.passes):
                if number == self.fail_at:
                    raise self.error
                film.passes = number + 1
                self.passes_made = number + 1
                self.on_pass(number + 1)
                yield update("render", number + 1, film, 0.5, number + 1.0, plan)
            yield update("done", settings.passes, film, 0.5, 1.0, plan)
        finally:
            self.closed += 1


@pytest.fixture
def core(bpy: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    if bpy is None:
        return None
    import photon_map.core

    fake = FakeCore()
    # Into the dictionary: looking at the real one first would import Numba.
    monkeypatch.setitem(vars(photon_map.core), "render", fake.render)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 40, 30
    scene.render.resolution_percentage = 100
    scene.photon_map.passes = 4
    add_camera(bpy)
    return fake


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
    for toggle in ("z", "normal", "diffuse_direct", "diffuse_indirect", "emit"):
        setattr(layer, f"use_pass_{toggle}", True)
    layer.photon_map.use_pass_denoising_albedo = True
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    new = bpy.app.version >= (5, 0, 0)
    image = read_exr(tmp_path / "a.exr")
    names = {
        "direct": "Diffuse Direct" if new else "DiffDir",
        "indirect": "Diffuse Indirect" if new else "DiffInd",
        "emission": "Emission" if new else "Emit",
    }
    assert set(image) == {
        f"ViewLayer.{name}"
        for name in ("Combined", "Depth", "Normal", "Caustics", "Denoising Albedo")
    } | {f"ViewLayer.{name}" for name in names.values()}
    assert image["ViewLayer.Depth"].shape == (30, 40, 1)
    assert (image["ViewLayer.Depth"] == 7.0).all()
    assert image["ViewLayer.Normal"][3, 4] == pytest.approx([0.0, 0.6, 0.8])
    assert image["ViewLayer.Denoising Albedo"][3, 4] == pytest.approx([0.1, 0.2, 0.3])
    assert image[f"ViewLayer.{names['direct']}"][3, 4] == pytest.approx([4.0, 3.0, 0.0])
    assert (image[f"ViewLayer.{names['indirect']}"] == 0.125).all()
    assert (image[f"ViewLayer.{names['emission']}"] == 0.25).all()
    assert (image["ViewLayer.Caustics"] == 0.5).all()


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
    cube.is_holdout = True
    bpy.ops.render.render()
    out = "".join(capfd.readouterr())
    assert out.count("holdouts and shadow catchers") == 1
    assert out.count("has no light") == 1


def test_progress_follows_the_nearest_limit(bpy: Any) -> None:
    from photon_map.addon.final import progress, stats_line
    from photon_map.core.settings import Settings

    def at(passes: int, seconds: float, error: float) -> Any:
        return update("render", passes, None, error, seconds)

    assert progress(at(16, 0, 1), Settings(passes=64)) == 0.25
    assert progress(at(1, 5, 1), Settings(passes=64, seconds=10)) == 0.5
    assert progress(at(4, 0, 0.2), Settings(passes=64, error_goal=0.1)) == 0.25
    assert progress(at(1, 0, float("inf")), Settings(passes=64, error_goal=0.1)) == 1 / 64
    assert progress(at(4, 0, 0.0), Settings(passes=4, error_goal=0.1)) == 1.0
    line = stats_line("ViewLayer", at(16, 0, 0.05), 0.25)
    assert line == "ViewLayer | 25 % | Pass 16 | Error 5.00 %"
