"""Tries the extension in a real Blender, as a new user would: `make acceptance BLENDER=path`.

In an empty profile, offline: validates and installs the archive that fits, looks at what
Blender's start loads, renders every sample headless with `-E PHOTONMAP` at a small size,
compares the pixels with those of the bpy wheel (same seed and passes), then uninstalls and
looks for what is left. Ends with 1 at the first thing that is wrong.

Everything happens below one temporary folder (TMPDIR chooses its parent), so BLENDER may be
a script that runs Blender in a chroot which has that folder under the same path.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parents[1]
MODULE = "bl_ext.user_default.photon_map"
HEAVY = ("numba", "llvmlite", "scipy", "embreex")
#: What a start may not load either: Blender itself does not.
LATE = (*HEAVY, "numpy")
#: Processor seconds that enabling the add-on may take, in the quickest of so many starts.
MOST_ENABLING, STARTS = 0.05, 5
TIMEOUT = 1800.0
SEED, PASSES, WIDTH, HEIGHT = 7, 8, 96, 64

#: Two renders of one seed take the same paths, unless a last bit of a matrix or of a
#: mathematical function turns one of them. So at most so many pixels may differ, and the
#: mean by a tenth of what the noise of the passes makes it differ between two seeds.
PIXELS_THAT_DIFFER = 0.01
RELATIVE_DIFFERENCE = 1e-3

PROBE = (
    f"LATE = {LATE!r}"
    + """
import bpy, json, sys
heavy = [name for name in LATE if name in sys.modules]
import numpy
print("PROBE" + json.dumps({
    "version": bpy.app.version_string,
    "python": f"cp{sys.version_info[0]}{sys.version_info[1]}",
    "numpy": numpy.__version__,
    "system": sys.platform,
    "enabled": [name for name in bpy.context.preferences.addons.keys() if "photon" in name],
    "engine": any(getattr(e, "bl_idname", "") == "PHOTONMAP"
                  for e in bpy.types.RenderEngine.__subclasses__()),
    "heavy": heavy,
}))
"""
)

#: Enables the extension and says what that took; its files have been compiled by then.
ENABLE = f"""
import time, addon_utils
begin = time.process_time()
assert addon_utils.enable("{MODULE}") is not None
print("PROBE" + str(time.process_time() - begin))
"""

PREPARE = (
    f"SEED, PASSES, WIDTH, HEIGHT = {SEED}, {PASSES}, {WIDTH}, {HEIGHT}"
    + """
import bpy
scene = bpy.context.scene
settings, image = scene.photon_map, scene.render.image_settings
settings.seed, settings.passes, settings.seconds, settings.error_goal = SEED, PASSES, 0, 0
scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
scene.render.resolution_percentage = 100
if hasattr(image, "media_type"):
    image.media_type = "IMAGE"
image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGBA", "32"
"""
)


class AcceptanceError(Exception):
    """What a user would have tripped over."""


def check(good: object, what: str) -> None:
    """Raise unless ``good``."""
    if not good:
        raise AcceptanceError(what)


class Blender:
    """A Blender executable with a profile of its own below ``folder``."""

    def __init__(self, command: str, folder: Path) -> None:
        self.command = command
        self.profile, home = folder / "profile", folder / "home"
        (self.profile / "config").mkdir(parents=True)
        home.mkdir()
        self.environment = {
            **{
                k: v for k, v in os.environ.items() if not k.startswith(("PHOTON_", "BLENDER_"))
            },
            "BLENDER_USER_RESOURCES": str(self.profile),
            "HOME": str(home),
            "XDG_CACHE_HOME": str(home / ".cache"),
        }

    def run(self, *arguments: str) -> str:
        """Run it offline; its output. An exit code other than 0 is wrong."""
        done = subprocess.run(
            [self.command, "--offline-mode", *arguments], env=self.environment,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
            text=True, errors="replace", timeout=TIMEOUT,
        )  # fmt: skip
        check(
            done.returncode == 0 and "Traceback" not in done.stdout,
            f"blender {' '.join(arguments)[:200]} ended with {done.returncode}:\n{done.stdout}",
        )
        return done.stdout

    def probe(self, *arguments: str) -> dict[str, Any]:
        """What a start with ``arguments`` finds."""
        found: dict[str, Any] = self._asked(PROBE, *arguments)
        return found

    def enabling(self) -> float:
        """Processor seconds that enabling the installed extension takes."""
        return min(float(self._asked(ENABLE, "--factory-startup")) for _ in range(STARTS))

    def _asked(self, script: str, *arguments: str) -> Any:
        """What ``script`` prints as JSON after PROBE."""
        output = self.run("-b", *arguments, "--python-expr", script)
        line = next(line for line in output.splitlines() if line.startswith("PROBE"))
        return json.loads(line.removeprefix("PROBE"))

    def left_over(self) -> list[str]:
        """Files of the add-on or of its packages in the profile."""
        names = ("photon_map", *HEAVY)
        return [
            str(path.relative_to(self.profile))
            for path in sorted(self.profile.rglob("*"))
            if any(
                name in part for part in path.relative_to(self.profile).parts for name in names
            )
        ]


def fitting_archive(found: dict[str, Any], dist: Path) -> Path:
    """The archive for this platform and Python, built now."""
    system = {"linux": "linux-x64", "win32": "windows-x64", "darwin": "macos-arm64"}
    target = f"{system[found['system']]}-{found['python']}"
    command = [sys.executable, str(ROOT / "tools/extension.py"), "--only", target]
    subprocess.run([*command, "--output", str(dist)], check=True, stdout=subprocess.PIPE)
    return next(dist.glob(f"*-{target}.zip"))


def read_pixels(path: Path) -> np.ndarray:
    """Combined (H, W, 4) of an EXR."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.parts[0].channels
        return np.stack([channels[name].pixels for name in "RGBA"], axis=2)


def compare(image: np.ndarray, expected: np.ndarray, name: str) -> str:
    """How the pixels compare, as words; raises where they differ by more than is stated."""
    check(image.shape == expected.shape, f"{name}: {image.shape}, expected {expected.shape}")
    check(np.isfinite(image).all(), f"{name}: pixels are not finite")
    if np.array_equal(image, expected):
        return "the same bits"
    scale = 1e-3 * expected[..., :3].mean() + np.abs(expected)
    off = (np.abs(image - expected) > RELATIVE_DIFFERENCE * scale).any(axis=2).mean()
    mean = abs(image[..., :3].mean() / expected[..., :3].mean() - 1.0)
    words = f"{100 * off:.2f} % of the pixels differ by more than 0.1 %, the mean {mean:.1e}"
    check(off <= PIXELS_THAT_DIFFER and mean <= RELATIVE_DIFFERENCE, f"{name}: {words}")
    return words


def render_samples(blender: Blender, folder: Path, photonmap: str) -> None:
    """Render every sample both ways and compare."""
    for number, sample in enumerate(sorted((ROOT / "sample_blends").glob("*.blend"))):
        copy = folder / sample.name
        copy.write_bytes(sample.read_bytes())
        output = folder / sample.stem
        begin = time.monotonic()
        shown = blender.run(
            "-b", str(copy), "-E", "PHOTONMAP", "--python-expr", PREPARE,
            "-o", f"{output}_", "-f", "1",
        )  # fmt: skip
        seconds = time.monotonic() - begin
        check("100 %" in shown, f"{sample.name}: no percentage in the log:\n{shown}")
        compiles = "ompiling" in shown
        check(
            compiles == (number == 0), f"{sample.name}: compiling was said: {compiles}\n{shown}"
        )
        wheel = folder / f"{sample.stem}_wheel.exr"
        command = [photonmap, "render", str(sample), "-o", str(wheel), "--frame", "1"]
        command += ["--seed", str(SEED), "--passes", str(PASSES), "--size", f"{WIDTH}x{HEIGHT}"]
        subprocess.run(command, check=True, capture_output=True)
        words = compare(
            read_pixels(folder / f"{sample.stem}_0001.exr"), read_pixels(wheel), sample.name
        )
        print(f"  {sample.name}: {seconds:.1f} s, {words}", flush=True)


def accept(command: str, photonmap: str, folder: Path) -> None:
    """The whole of it, below ``folder``."""
    blender = Blender(command, folder)
    found = blender.probe("--factory-startup")
    print(f"Blender {found['version']}, {found['python']}, NumPy {found['numpy']}")
    archive = fitting_archive(found, folder)
    print(f"  {archive.name}: {archive.stat().st_size / 1e6:.0f} MB")
    blender.run("--command", "extension", "validate", str(archive))
    begin = time.monotonic()
    blender.run(
        "--command", "extension", "install-file", "-r", "user_default", "-e", str(archive)
    )
    print(f"  installed in {time.monotonic() - begin:.1f} s")
    started = blender.probe()
    check(started["engine"] and started["enabled"] == [MODULE], f"after the install: {started}")
    check(not started["heavy"], f"a start of Blender loads {started['heavy']}")
    enabling = blender.enabling()
    print(f"  enabled in {1000 * enabling:.0f} ms of a processor")
    check(enabling <= MOST_ENABLING, f"enabling takes {enabling} s of a processor")
    render_samples(blender, folder, photonmap)
    blender.run("--command", "extension", "remove", "photon_map")
    ended = blender.probe()
    check(not ended["engine"] and not ended["enabled"], f"after the removal: {ended}")
    check(not blender.left_over(), f"left behind: {blender.left_over()[:20]}")
    print("  uninstalled, nothing is left")


def main() -> None:
    """Try the Blender of the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("blender")
    parser.add_argument("--photonmap", default=str(Path(sys.executable).with_name("photonmap")))
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="photon_map_acceptance_") as folder:
        try:
            accept(chosen.blender, chosen.photonmap, Path(folder))
        except AcceptanceError as error:
            raise SystemExit(f"not accepted: {error}") from error


if __name__ == "__main__":
    main()
