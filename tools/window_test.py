"""Drives a real Blender's window as a user would: `make window BLENDER=path`.

Installs the extension into an empty profile, opens a sample under Xvfb and goes through the
rendered viewport, edits, two viewports, F12, Escape and the panels (`window_steps.py`), which
leaves screenshots in a folder. Looks whether they show what they should, and prints how long
the viewport takes from an edit to its first picture, for each sample. Ends with 1 at the
first thing that is wrong.

As in `acceptance.py` BLENDER may be a script for a chroot; `--xvfb` is then the Xvfb of the
same chroot.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from acceptance import (  # type: ignore[import-not-found]
    ROOT,
    TIMEOUT,
    AcceptanceError,
    Blender,
    check,
    fitting_archive,
)
from likeness import likeness, parted  # type: ignore[import-not-found]
from PIL import Image
from xwd import read_xwd  # type: ignore[import-not-found]

SAMPLE = "cornell_glass"
PASSES = 3
#: What runs inside of Blender.
SCRIPTS = (
    "driven.py", "frames.py", "likeness.py", "screenshots.py", "x_server.py", "xwd.py",
)  # fmt: skip
#: Of the display: the viewport has about a third of it.
WIDTH, HEIGHT = 800, 560
#: A picture with less contrast is blank.
LEAST_CONTRAST = 0.02
#: Two headless pictures by these seeds differ by twice the variance of one. A viewport's, with
#: fewer gather rays, may have three times that variance and meets a picture that has it once:
#: so it may be ``MOST_FARTHER`` times as far, and as much more as a picture is from itself one
#: pixel aside, since a cut of a screenshot is exact to a pixel.
SEEDS = (11, 12)
MOST_FARTHER = 2.0
#: An edit changes the picture by so much, the noise included.
LEAST_CHANGE = 0.001
#: Seconds that Escape may take, times the processes that share a processor, and those from an
#: edit to a picture that are asked for.
MOST_CANCEL, ASKED_LATENCY = 0.5, 0.3


def start_display(
    command: str, width: int = WIDTH, height: int = HEIGHT
) -> tuple[subprocess.Popen[str], str]:
    """An Xvfb of our own and its display."""
    server = subprocess.Popen(
        [*shlex.split(command), "-displayfd", "1", "-screen", "0", f"{width}x{height}x24",
         "-nolisten", "tcp"],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    assert server.stdout is not None
    number = server.stdout.readline().strip()
    check(number, f"{command} does not start")
    return server, f":{number}"


def headless_picture(blender: Blender, sample: Path, width: int, height: int, seed: int) -> Any:
    """What the sample looks like rendered without a window: (h, w, 3) from the bottom."""
    change = (
        "import bpy; s = bpy.context.scene; r, p = s.render, s.photon_map; "
        f"r.resolution_x, r.resolution_y, r.resolution_percentage = {width}, {height}, 100; "
        f"p.passes, p.seconds, p.seed = {PASSES}, 0, {seed}"
    )
    output = sample.parent / f"headless_{width}_{height}_{seed}_"
    blender.run(
        "-b", str(sample), "-E", "PHOTONMAP", "--python-expr", change, "-o", str(output),
        "-F", "PNG", "-f", "1",
    )  # fmt: skip
    picture = Image.open(output.with_name(f"{output.name}0001.png")).convert("RGB")
    return np.asarray(picture)[::-1] / np.float32(255)


def compare(blender: Blender, folder: Path, found: dict[str, Any]) -> None:
    """Lay pictures of the viewport beside headless ones of the same size.

    Adds how alike they are, how alike two seeds are, and a picture and itself one pixel aside.
    """
    made: dict[tuple[int, int], list[np.ndarray]] = {}
    for name in ("viewport", "resized", "border"):
        picture = np.load(folder / f"{name}.npy")
        height, width = picture.shape[:2]
        if (width, height) not in made:
            sample = folder / f"{SAMPLE}.blend"
            made[width, height] = [
                headless_picture(blender, sample, width, height, seed) for seed in SEEDS
            ]
        one, other = made[width, height]
        pairs = {
            "": (picture, one),
            " of seeds": (one, other),
            " aside": (one[1:, 1:], one[:-1, :-1]),
        }
        for what, pair in pairs.items():
            if name == "border":
                pair = (parted(pair[0])[0], parted(pair[1])[0])
            alike = likeness(*pair)
            found[name] |= {f"{key}{what}": value for key, value in alike.items()}


def steps_in(
    blender: Blender, display: str, folder: Path, script: str, sample: Path, job: dict[str, Any]
) -> dict[str, Any]:
    """Have a Blender with a window take the steps of ``script``; what they found."""
    (folder / "job.json").write_text(json.dumps({"folder": str(folder), **job}))
    for name in (script, *SCRIPTS):
        shutil.copy(ROOT / "tools" / name, folder)
    done = subprocess.run(
        [blender.command, "--offline-mode", "--window-geometry", "0",
         "0", str(WIDTH), str(HEIGHT), str(sample), "-E", "PHOTONMAP", "-P",
         str(folder / script), "--", str(folder / "job.json")],
        env={**blender.environment, "DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1"},
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
        text=True, errors="replace", timeout=TIMEOUT,
    )  # fmt: skip
    check(
        done.returncode == 0 and "Traceback" not in done.stdout,
        f"Blender ended with {done.returncode}:\n{done.stdout[-6000:]}",
    )
    found: dict[str, Any] = json.loads((folder / "found.json").read_text())
    return found


def drive(blender: Blender, display: str, folder: Path) -> dict[str, Any]:
    """Run the steps in a window; what they found."""
    copies = []
    for sample in sorted((ROOT / "sample_blends").glob("*.blend")):
        copies.append(folder / sample.name)
        copies[-1].write_bytes(sample.read_bytes())
    sample = folder / f"{SAMPLE}.blend"
    job = {
        "passes": PASSES,
        "samples": [str(copy) for copy in copies],
    }
    # Compiles: the steps in the window wait less long for a picture than that may take.
    headless_picture(blender, sample, 64, 64, 0)
    found = steps_in(blender, display, folder, "window_steps.py", sample, job)
    compare(blender, folder, found)
    return found


def judge(found: dict[str, Any]) -> None:
    """Raise at what a user would not have liked to see."""
    for name, values in found.items():
        if isinstance(values, dict):
            contrast = values.get("contrast", 1.0)
            check(contrast >= LEAST_CONTRAST, f"{name} is blank: {values}")
            change = values.get("change", 1.0)
            check(change >= LEAST_CHANGE, f"{name} changed nothing: {values}")
    for name in ("viewport", "resized", "border"):
        seen = found[name]
        seeds, aside = (1.0 - seen[f"correlation {what}"] for what in ("of seeds", "aside"))
        far = MOST_FARTHER * seen["distance of seeds"] + seen["distance aside"]
        check(
            1.0 - seen["correlation"] <= MOST_FARTHER * seeds + aside
            and seen["distance"] <= far,
            f"{name} does not show the headless picture: {seen}",
        )
    check(found["border"]["outside"] <= LEAST_CONTRAST, f"border: {found['border']}")
    check(found["F12"]["pictures"] == 1, "F12 shows no picture")
    whole, kept = (found[name]["contrast"] for name in ("F12", "cancelled picture"))
    check(kept >= 0.5 * whole, f"Escape keeps no picture: contrast {kept}, of F12 {whole}")
    escape = found["cancel"]
    shared = max(1.0, escape["load"] / (os.cpu_count() or 1))
    check(escape["seconds"] <= MOST_CANCEL * shared, f"Escape: {escape}")


def tell(found: dict[str, Any]) -> None:
    """Print what was found."""
    for name, values in found.items():
        if name not in ("version", "latency", "load"):
            print(f"  {name}: " + ", ".join(f"{k} {v:.3g}" for k, v in values.items()))
    asked = f"{ASKED_LATENCY} are asked for after an edit"
    print(f"  seconds to the first picture ({asked}), at a load of {found['load']:.1f}:")
    print("  and, in brackets, seconds of processors that Blender and the render took for it:")
    for name, values in found["latency"].items():
        parts = [f"{what} {s:.2f} ({cpu:.2f})" for what, (s, cpu) in values.items()]
        print(f"    {name}: " + ", ".join(parts))
    edits = [
        pair
        for values in found["latency"].values()
        for k, pair in values.items()
        if k != "first"
    ]
    medians = [statistics.median(column) for column in zip(*edits, strict=True)]
    print(f"    median of the edits: {medians[0]:.2f} ({medians[1]:.2f})")


@contextmanager
def installed(
    command: str, xvfb: str, folder: Path, shots: Path
) -> Iterator[tuple[Blender, str]]:
    """Blender with the extension in an empty profile below ``folder``, and a display for it.

    The screenshots are copied to ``shots`` at the end.
    """
    blender = Blender(command, folder)
    probed = blender.probe("--factory-startup")
    print(f"Blender {probed['version']}", flush=True)
    archive = fitting_archive(probed, folder)
    blender.run(
        "--command", "extension", "install-file", "-r", "user_default", "-e", str(archive)
    )
    server, display = start_display(xvfb)
    try:
        yield blender, display
    finally:
        server.terminate()
        server.wait()
        shots.mkdir(parents=True, exist_ok=True)
        for dump in folder.glob("*.xwd"):
            Image.fromarray(read_xwd(dump)).save(shots / f"{dump.stem}.png", optimize=True)


def try_window(command: str, xvfb: str, folder: Path, shots: Path) -> None:
    """The whole of it, below ``folder``; screenshots are copied to ``shots``."""
    with installed(command, xvfb, folder, shots) as (blender, display):
        found = drive(blender, display, folder)
    tell(found)
    judge(found)
    print(f"  passed; the screenshots are in {shots}")


def try_as_asked(
    what: str,
    trial: Callable[..., None],
    shots: Path,
    more: Callable[[argparse.ArgumentParser], None] = lambda parser: None,
) -> None:
    """Take Blender, display and folder from the command line; ``what`` is its help.

    ``more`` adds options, which ``trial`` gets by their names.
    """
    parser = argparse.ArgumentParser(description=what)
    more(parser)
    parser.add_argument("blender")
    parser.add_argument("--xvfb", default="Xvfb", help="command that starts Xvfb")
    parser.add_argument("--shots", type=Path, default=shots)
    chosen = vars(parser.parse_args())
    command, xvfb, shots = (chosen.pop(name) for name in ("blender", "xvfb", "shots"))
    with tempfile.TemporaryDirectory(prefix="photon_map_window_") as folder:
        try:
            trial(command, xvfb, Path(folder), shots, **chosen)
        except AcceptanceError as error:
            sys.exit(f"not accepted: {error}")


if __name__ == "__main__":
    try_as_asked(__doc__ or "", try_window, ROOT / "renders/window")
