"""The command line around a fake render; real ones are in tests/blender and below."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image
from typer.testing import CliRunner, Result

from photon_map import cli
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.camera_data import CameraData
from photon_map.core.scene.dump import load_scene, save_scene
from photon_map.core.scene.scene import SceneError
from photon_map.core.settings import Settings
from photon_map.core.version import VERSION
from tests.fake_render import LAYERS, PLAN, FakeRender

SAVED = Settings(passes=5, seconds=30.0, seed=3, region=(0, 0, 2, 2))


@pytest.fixture
def scene_file(tmp_path: Path) -> Path:
    builder = SceneBuilder("tiny")
    builder.set_camera(CameraData(width=4, height=3))
    path = tmp_path / "in" / "tiny.npz"
    path.parent.mkdir()
    save_scene(path, builder.build(), SAVED)
    return path


@pytest.fixture
def out(tmp_path: Path) -> Path:
    folder = tmp_path / "out"
    folder.mkdir()
    return folder


@pytest.fixture
def fake(monkeypatch: pytest.MonkeyPatch) -> FakeRender:
    render = FakeRender()
    monkeypatch.setattr("photon_map.core.render", render, raising=False)
    return render


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli.app, [str(argument) for argument in arguments])


def render(scene: Path, *arguments: str | Path) -> Result:
    return run("render", scene, *arguments)


def test_one_render_gives_png_and_exr(scene_file: Path, out: Path, fake: FakeRender):
    result = render(scene_file, "-o", out / "a.png", "-o", out / "a.exr")
    assert result.exit_code == 0, result.output
    assert len(fake.calls) == 1
    assert sorted(os.listdir(out)) == ["a.exr", "a.png"]
    with OpenEXR.File(str(out / "a.exr"), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
        assert VERSION in file.header()["software"]
    colours = [name for name in LAYERS if name not in ("combined", "depth", "normal")]
    wanted = {*"RGBA", "depth.Z", "normal.X", "normal.Y", "normal.Z"}
    assert set(channels) == wanted | {f"{name}.{c}" for name in colours for c in "RGB"}
    assert {pixels.dtype for pixels in channels.values()} == {np.dtype("f4")}
    # The film's row 0 is the bottom, the file's the top; red counts from the bottom.
    assert channels["R"].tolist() == [[1.0] * 4, [0.5] * 4, [0.0] * 4]
    with Image.open(out / "a.png") as image:
        assert image.mode == "RGB"
        assert VERSION in image.info["software"]
        pixels = np.asarray(image)
    # 0.5 linear is 188 in sRGB (IEC 61966-2-1: 255 (1.055 0.5^(1/2.4) - 0.055) = 187.5).
    assert pixels[:, 0, 0].tolist() == [255, 188, 0]
    assert pixels[0, :, 1].tolist()[::3] == [0, 255]


def test_report_and_scene_are_written(scene_file: Path, out: Path, fake: FakeRender):
    result = render(
        scene_file, "-o", out / "a.png", "--seed", "8",
        "--report", out / "r.json", "--save-scene", out / "s.npz",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    report = json.loads((out / "r.json").read_text())
    assert (report["scene"], report["seed"], report["passes"]) == ("tiny", 8, 4)
    assert [point["pass"] for point in report["curve"]] == [1, 2, 3, 4]
    assert report["plan"][1] == {"stage": "lens", "on": False, "reason": PLAN.stages[1].reason}
    scene, settings = load_scene(out / "s.npz")
    assert scene.name == "tiny"
    assert settings == fake.settings


def test_settings_of_the_command_line_win(scene_file: Path, out: Path, fake: FakeRender):
    chosen = "--threads 2 --filter blackman-harris --filter-width 2.5 --size 8x6".split()
    assert render(scene_file, "-o", out / "a.png", *chosen).exit_code == 0
    scene, settings = fake.calls[0]
    assert (settings.threads, settings.pixel_filter, settings.filter_width) == (
        2, "BLACKMAN_HARRIS", 2.5,
    )  # fmt: skip
    assert settings.seed == 3
    assert scene.camera is not None
    assert (scene.camera.width, scene.camera.height) == (8, 6)
    assert settings.region is None, "a region in pixels means nothing at another size"


@pytest.mark.parametrize(
    ("arguments", "limits"),
    [
        ([], (5, 30.0, 0.0)),
        (["--passes", "3"], (3, 0.0, 0.0)),
        (["--seconds", "2.5"], (cli.ENDLESS, 2.5, 0.0)),
        (["--error", "0.1"], (cli.ENDLESS, 0.0, 0.1)),
        (["--passes", "9", "--seconds", "1"], (9, 1.0, 0.0)),
    ],
)
def test_limits_of_the_command_line_replace_the_files(
    arguments: list[str], limits: tuple, scene_file: Path, out: Path, fake: FakeRender
):
    assert render(scene_file, "-o", out / "a.png", *arguments).exit_code == 0
    settings = fake.settings
    assert (settings.passes, settings.seconds, settings.error_goal) == limits


def assert_refused(
    result: Result, code: int, message: str, out: Path, fake: FakeRender
) -> None:
    assert result.exit_code == code, result.output
    assert message in result.stderr
    assert fake.calls == [], "it rendered before it looked"
    assert os.listdir(out) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["IN/no.blend", "-o", "OUT/a.png"], "there is no file"),
        (["IN", "-o", "OUT/a.png"], "is not a file"),
        (["IN/notes.txt", "-o", "OUT/a.png"], "neither a .blend nor an .npz"),
        (["IN/broken.npz", "-o", "OUT/a.png"], "is not a scene file"),
        (["IN/tiny.npz", "-o", "OUT/a.jpg"], "to a .png or an .exr"),
        (["IN/tiny.npz", "-o", "OUT/no/a.png"], "cannot write"),
        (["IN/tiny.npz", "-o", "IN/folder.png"], "is not a file"),
        (["IN/tiny.npz", "-o", "OUT/a.png", "--save-scene", "OUT/s.blend"], "an .npz file"),
        (["IN/tiny.npz", "-o", "OUT/a.png", "--save-scene", "IN/tiny.npz"], "overwrite"),
        (["IN/tiny.npz", "-o", "OUT/a.png", "--report", "OUT/no/r.json"], "cannot write"),
    ],
)
def test_what_can_be_mended_is_one_line_before_any_work(
    arguments: list[str], message: str, scene_file: Path, out: Path, fake: FakeRender
):
    (scene_file.parent / "notes.txt").touch()
    (scene_file.parent / "broken.npz").write_text("nothing")
    (scene_file.parent / "folder.png").mkdir()
    places = {"IN": str(scene_file.parent), "OUT": str(out)}
    paths = [a.replace("IN", places["IN"]).replace("OUT", places["OUT"]) for a in arguments]
    result = run("render", *paths)
    assert_refused(result, 1, message, out, fake)
    assert result.stderr.count("\n") == 1
    assert result.stdout == ""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--size", "3by4"], "not like 640x360"),
        (["--size", "0x4"], "not like 640x360"),
        (["--seconds", "0"], "is not above 0"),
        (["--error", "nan"], "is not above 0"),
        (["--frame", "2"], "one frame only"),
        (["--passes", "-1"], "it must be from 1"),
        (["--filter", "mitchell"], "mitchell"),
        (["-o", "b.png"], "two .png files"),
        (["--unknown"], "No such option"),
    ],
)
def test_wrong_usage_ends_with_2(
    arguments: list[str], message: str, scene_file: Path, out: Path, fake: FakeRender
):
    result = render(scene_file, "-o", out / "a.png", *arguments)
    assert_refused(result, 2, message, out, fake)


def failing_at(number: int, error: BaseException) -> Callable[[int], None]:
    def fail(i: int) -> None:
        if i == number:
            raise error

    return fail


@pytest.mark.parametrize("number", [0, 3])
def test_a_failure_leaves_no_output_and_the_older_one(
    number: int, scene_file: Path, out: Path, fake: FakeRender
):
    (out / "a.exr").write_text("older")
    fake.at_pass = failing_at(number, SceneError("light 'Lamp': power must not be negative"))
    result = render(
        scene_file, "-o", out / "a.png", "-o", out / "a.exr", "--report", out / "r.json"
    )
    assert result.exit_code == 1
    assert "error: light 'Lamp': power must not be negative" in result.stderr
    assert os.listdir(out) == ["a.exr"]
    assert (out / "a.exr").read_text() == "older"


def test_a_defect_of_ours_keeps_its_traceback(scene_file: Path, out: Path, fake: FakeRender):
    fake.at_pass = failing_at(2, ZeroDivisionError("ours"))
    result = render(scene_file, "-o", out / "a.png")
    assert result.exit_code == 1
    assert isinstance(result.exception, ZeroDivisionError)
    assert os.listdir(out) == []


def interrupting_at(*numbers: int) -> Callable[[int], None]:
    def interrupt(i: int) -> None:
        if i in numbers:
            os.kill(os.getpid(), signal.SIGINT)

    return interrupt


def test_ctrl_c_keeps_what_was_rendered(scene_file: Path, out: Path, fake: FakeRender):
    before = signal.getsignal(signal.SIGINT)
    fake.at_pass = interrupting_at(2)
    result = render(scene_file, "-o", out / "a.png", "--report", out / "r.json")
    assert result.exit_code == 130, result.output
    assert fake.closed
    assert json.loads((out / "r.json").read_text())["passes"] == 2
    assert (out / "a.png").exists()
    assert signal.getsignal(signal.SIGINT) is before


def test_ctrl_c_before_the_first_pass_writes_nothing(
    scene_file: Path, out: Path, fake: FakeRender
):
    fake.at_pass = interrupting_at(0)
    result = render(scene_file, "-o", out / "a.png")
    assert result.exit_code == 130
    assert "nothing was written" in result.stderr
    assert os.listdir(out) == []
    assert fake.closed


def test_a_second_ctrl_c_ends_at_once(scene_file: Path, out: Path, fake: FakeRender):
    def twice(i: int) -> None:
        if i == 3:
            os.kill(os.getpid(), signal.SIGINT)
            os.kill(os.getpid(), signal.SIGINT)

    fake.at_pass = twice
    result = render(scene_file, "-o", out / "a.png")
    assert result.exit_code == 130
    assert os.listdir(out) == []


def test_plan_says_what_is_on_and_why(scene_file: Path, monkeypatch: pytest.MonkeyPatch):
    class Planner:
        @staticmethod
        def of(scene: object, settings: Settings) -> object:
            return PLAN

    monkeypatch.setattr("photon_map.core.Plan", Planner, raising=False)
    result = run("plan", scene_file)
    assert result.exit_code == 0
    assert result.stdout.splitlines() == [
        "caustic photons  on   1 caster: 'Glass'",
        "lens             off  the aperture is closed",
    ]
    assert result.stderr == "photonmap: warning: the scene has no light\n"


def test_the_command_itself_starts_and_knows_its_version():
    command = [sys.executable, "-m", "photon_map.cli", "--version"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout.strip()) == (0, f"Photon Map {VERSION}")


def test_help_does_not_load_the_kernels():
    code = "import sys; from photon_map import cli; print('numba' in sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60
    )
    assert done.stdout.strip() == "False", done.stderr


def test_two_outputs_to_one_file_are_refused(scene_file: Path, out: Path) -> None:
    result = render(scene_file, "-o", out / "a.png", "--report", out / "." / "a.png")
    assert result.exit_code == 1
    assert "two outputs go to the same file" in result.output
    assert not list(out.iterdir())


def test_a_frame_that_blender_does_not_have(tmp_path: Path) -> None:
    blend = tmp_path / "a.blend"
    blend.touch()
    result = render(blend, "-o", tmp_path / "a.png", "--frame", 1_048_575)
    assert result.exit_code == 2
    assert "1048575 is beyond 1048574" in result.output
