"""What the commands of ``photonmap`` share: their file, their errors, their outputs."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from .blender_libraries import BlenderMissingError
from .core.scene.scene import SceneError
from .core.settings import Settings, SettingsError
from .source import CommandError, Source

#: Blender's last frame; beyond it takes this one without a word.
LAST_FRAME = 1_048_574

FileArgument = Annotated[Path, typer.Argument(metavar="FILE.blend|FILE.npz")]
FrameOption = Annotated[int | None, typer.Option(help="Frame of the .blend to take.")]


@contextmanager
def reported_errors() -> Iterator[None]:
    """Turn what a user can mend into one line on stderr and an exit code."""
    try:
        yield
    except SettingsError as problem:
        fail(problem, 2)
    except (CommandError, SceneError, BlenderMissingError, OSError, MemoryError) as problem:
        fail(problem, 1)
    except KeyboardInterrupt:
        fail("stopped by Ctrl-C before the first pass was done; nothing was written", 130)


def fail(problem: object, code: int) -> None:
    """One line on stderr, and the end of the command."""
    text = " ".join(str(problem).split()) or type(problem).__name__
    typer.echo(f"photonmap: error: {text}", err=True)
    raise typer.Exit(code)


def warn(*warnings: str) -> None:
    """Each warning once, on stderr."""
    for text in dict.fromkeys(warnings):
        typer.echo(f"photonmap: warning: {text}", err=True)


def source_of(
    file: Path, frame: int | None, size: str | None, overrides: dict[str, Any]
) -> Source:
    """Check everything about the input that can be checked without opening it."""
    given = {key: value for key, value in overrides.items() if value is not None}
    Settings(**given)
    pixels = re.fullmatch(r"([1-9]\d{0,4})x([1-9]\d{0,4})", size) if size else None
    if size and not pixels:
        raise typer.BadParameter(f"'{size}' is not like 640x360", param_hint="--size")
    if not file.exists():
        raise CommandError(f"there is no file '{file}'")
    if not file.is_file():
        raise CommandError(f"'{file}' is not a file")
    if file.suffix.lower() not in (".blend", ".npz"):
        raise CommandError(f"'{file}' is neither a .blend nor an .npz")
    if frame is not None and file.suffix.lower() == ".npz":
        raise typer.BadParameter("an .npz holds one frame only", param_hint="--frame")
    if frame is not None and abs(frame) > LAST_FRAME:
        raise typer.BadParameter(f"{frame} is beyond {LAST_FRAME}", param_hint="--frame")
    pair = (int(pixels[1]), int(pixels[2])) if pixels else None
    return Source(file, frame, pair, given)


def check_writable(path: Path, source: Path) -> None:
    """Raise ``CommandError`` when ``path`` could not be written after the render."""
    if path.exists() and not path.is_file():
        raise CommandError(f"'{path}' is not a file")
    if path.exists() and path.samefile(source):
        raise CommandError(f"'{path}' would overwrite the scene that is rendered")
    try:
        # The only question that answers for every file system and user.
        tempfile.TemporaryFile(dir=Path(os.path.realpath(path)).parent).close()
    except OSError as problem:
        raise CommandError(f"cannot write '{path}': {problem.strerror}") from problem
