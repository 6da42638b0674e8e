"""Builds the extension's archives: one for each platform and Python in the manifest.

    python tools/extension.py [--only linux-x64-cp313 ...] [--output dist]

The wheels that ``blender_manifest.toml`` lists are downloaded into ``wheels/`` unless they
are there. Each archive is a copy of the code with a manifest that lists only its own wheels,
put together and validated by Blender's builder, which the bpy wheel contains.
"""

from __future__ import annotations

import argparse
import importlib.util
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
MANIFEST = "blender_manifest.toml"
#: What an archive holds beside its manifest and its wheels.
CODE = ("__init__.py", "addon", "core", "LICENSE")
#: How the platform part of a wheel's name begins, by Blender's name of the platform.
PLATFORMS = {"manylinux": "linux-x64", "win": "windows-x64", "macosx": "macos-arm64"}


class Wheel(NamedTuple):
    """A wheel, by its file name."""

    file: str
    package: str
    version: str
    python: str  #: such as cp313
    tags: tuple[str, ...]  #: platforms in pip's words

    @staticmethod
    def of(path: str) -> Wheel:
        """The parts of the name at the end of ``path``."""
        file = path.rpartition("/")[2]
        package, version, python, _, tags = file.removesuffix(".whl").split("-")
        return Wheel(file, package, version, python, tuple(tags.split(".")))

    @property
    def platform(self) -> str:
        """Blender's name of the platform."""
        return next(name for start, name in PLATFORMS.items() if self.tags[0].startswith(start))

    @property
    def target(self) -> str:
        """The archive that it belongs to."""
        return f"{self.platform}-{self.python}"


def listed_wheels(text: str) -> list[Wheel]:
    """The wheels of the manifest ``text``."""
    return [Wheel.of(path) for path in tomllib.loads(text)["wheels"]]


def narrowed(text: str, target: str) -> str:
    """The manifest ``text`` with only the wheels and the platform of ``target``."""
    platform = target.rpartition("-")[0]
    lines = []
    for line in text.splitlines():
        entry = line.strip().rstrip(",").strip('"')
        if entry.endswith(".whl") and Wheel.of(entry).target != target:
            continue
        lines.append(f'platforms = ["{platform}"]' if line.startswith("platforms =") else line)
    return "\n".join(lines) + "\n"


def download(wheel: Wheel, folder: Path) -> None:
    """Fetch ``wheel`` with pip into ``folder``, unless it is there."""
    if (folder / wheel.file).is_file():
        return
    print(f"Downloading {wheel.file}", flush=True)
    number = wheel.python.removeprefix("cp")
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
    command += ["--disable-pip-version-check", "--only-binary=:all:", "--implementation", "cp"]
    command += ["--python-version", f"{number[0]}.{number[1:]}", "--dest", str(folder)]
    for tag in wheel.tags:
        command += ["--platform", tag]
    subprocess.run([*command, f"{wheel.package}=={wheel.version}"], check=True)
    if not (folder / wheel.file).is_file():
        raise SystemExit(f"pip brought another file than {wheel.file}; look into {folder}")


def builder() -> list[str]:
    """The command of Blender's extension builder."""
    spec = importlib.util.find_spec("bpy")
    folders = [] if spec is None else list(spec.submodule_search_locations or ())
    found = [
        path
        for folder in folders
        for path in Path(folder).glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")
    ]
    if not found:
        raise SystemExit("Blender's builder is part of the bpy wheel: install '.[blender]'")
    return [sys.executable, str(found[0])]


def build(target: str, text: str, output: Path) -> Path:
    """Make and validate the archive of ``target`` from the manifest ``text``."""
    values = tomllib.loads(text)
    archive = output / f"{values['id']}-{values['version']}-{target}.zip"
    with tempfile.TemporaryDirectory() as folder:
        stage = Path(folder) / values["id"]
        (stage / "wheels").mkdir(parents=True)
        for name in CODE:
            if (ROOT / name).is_dir():
                ignore = shutil.ignore_patterns("__pycache__")
                shutil.copytree(ROOT / name, stage / name, ignore=ignore)
            else:
                shutil.copy(ROOT / name, stage / name)
        own = narrowed(text, target)
        (stage / MANIFEST).write_text(own, "utf-8")
        for wheel in listed_wheels(own):
            (stage / "wheels" / wheel.file).symlink_to(ROOT / "wheels" / wheel.file)
        command = [*builder(), "build", "--source-dir", str(stage)]
        subprocess.run([*command, "--output-filepath", str(archive)], check=True)
    subprocess.run([*builder(), "validate", str(archive)], check=True)
    return archive


def main() -> None:
    """Build what the command line names, every archive by default."""
    text = (ROOT / MANIFEST).read_text("utf-8")
    targets = sorted({wheel.target for wheel in listed_wheels(text)})
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs="+", choices=targets, default=targets)
    parser.add_argument("--output", type=Path, default=ROOT / "dist")
    chosen = parser.parse_args()
    chosen.output.mkdir(parents=True, exist_ok=True)
    (ROOT / "wheels").mkdir(exist_ok=True)
    for wheel in listed_wheels(text):
        if wheel.target in chosen.only:
            download(wheel, ROOT / "wheels")
    archives = [build(target, text, chosen.output) for target in chosen.only]
    for archive in archives:
        print(f"{archive.name}: {archive.stat().st_size / 1e6:.0f} MB")


if __name__ == "__main__":
    main()
