"""The commands about photons: ``bake`` keeps their maps in a file beside the scene's."""

from __future__ import annotations

import sys
import time
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

from .arguments import (
    FileArgument,
    FrameOption,
    check_writable,
    reported_errors,
    source_of,
    warn,
)
from .core.settings import MAPS_SUFFIX


class MapsUse(StrEnum):
    """What a render does about baked maps; all but ``ignore`` take those that fit."""

    TRACE = "trace"
    REBUILD = "rebuild"
    REFUSE = "refuse"
    IGNORE = "ignore"


def maps_path(file: Path) -> Path:
    """Where the baked maps of a scene's file lie."""
    return file.with_suffix(MAPS_SUFFIX)


def maps_settings(file: Path, use: MapsUse) -> dict[str, Any]:
    """Fields of ``Settings`` for the maps beside ``file``, when there are any."""
    path = maps_path(file)
    if use is MapsUse.IGNORE or not path.is_file():
        return {}
    return {"photon_maps": str(path.resolve()), "stale_maps": use.name}


def bake(
    file: FileArgument,
    passes: Annotated[int, typer.Option(min=1, help="Rounded up to a multiple of 4.")] = 64,
    frame: FrameOption = None,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Pixels: photon counts follow them.")
    ] = None,
    seed: Annotated[int | None, typer.Option(help="Number of the random streams.")] = None,
    threads: Annotated[int | None, typer.Option(help="Threads; 0 takes every core.")] = None,
) -> None:
    """Keep the photons of FILE in FILE.pmap, for renders from other cameras.

    A render of FILE takes them from there for as long as nothing but the camera changes.
    """
    with reported_errors():
        source = source_of(file, frame, size, {"seed": seed, "threads": threads})
        path = maps_path(file)
        check_writable(path, file)
        loaded = source.load()
        from . import core

        def show(done: int) -> None:
            if sys.stdout.isatty():
                typer.echo(f"\rpass {done}", nl=False)

        begin = time.perf_counter()
        header = core.bake(loaded.scene, loaded.settings, path, passes, show)
        seconds = time.perf_counter() - begin
    warn(*loaded.warnings)
    stored = sum(map(sum, header.stored))
    megabytes = path.stat().st_size / 1e6
    typer.echo(
        f"{header.passes} passes, {stored} photons, {megabytes:.1f} MB, {seconds:.1f} s: "
        f"wrote {path}"
    )
