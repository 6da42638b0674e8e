"""The commands about photons: ``bake`` keeps their maps, ``photons`` shows where they are."""

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
from .core.file_replace import replacing
from .core.settings import MAPS_SUFFIX
from .source import CommandError

#: Lines of a legend.
_NAMED = 12


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
    if use is MapsUse.IGNORE:
        # Nor those that the .blend's own settings name.
        return {"photon_maps": ""}
    if not path.is_file():
        return {}
    return {"photon_maps": str(path.resolve()), "stale_maps": use.name}


class Colour(StrEnum):
    """What the points of photons are coloured by."""

    POWER = "power"
    BOUNCE = "bounce"
    CASTER = "caster"
    LIGHT = "light"


class Kind(StrEnum):
    """Which photons are shown."""

    ALL = "all"
    CAUSTIC = "caustic"
    GLOBAL = "global"


def photons(
    file: FileArgument,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="OUT.ply|OUT.png")],
    color: Annotated[Colour, typer.Option(help="What the colours tell.")] = Colour.POWER,
    kind: Annotated[Kind, typer.Option(help="Which photons.")] = Kind.ALL,
    count: Annotated[int | None, typer.Option(help="Photons to emit of each kind.")] = None,
    frame: FrameOption = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Pixels.")] = None,
    seed: Annotated[int | None, typer.Option(help="Number of the random streams.")] = None,
) -> None:
    """Show where the photons of FILE land: a cloud of points, or a picture of them."""
    overrides = {"seed": seed, "photons_caustic": count, "photons_global": count}
    with reported_errors():
        source = source_of(file, frame, size, overrides)
        if output.suffix.lower() not in (".ply", ".png"):
            raise CommandError(f"'{output}': photons are written to a .ply or a .png")
        check_writable(output, file)
        loaded = source.load()
        from .core.photon_view import picture_places, view_photons
        from .photon_picture import colours, legend, picture, write_ply

        view = view_photons(loaded.scene, loaded.settings)
        if kind is not Kind.ALL:
            view = view.only(view.caustic == (kind is Kind.CAUSTIC))
        with replacing(output) as part:
            if output.suffix.lower() == ".ply":
                write_ply(part, view, color)
            else:
                from PIL import Image

                rows, pixels = picture_places(loaded.scene, loaded.settings, view)
                camera = loaded.scene.camera
                assert camera is not None  # view_photons has looked
                seen = colours(view, color)[rows]
                Image.fromarray(picture(seen, pixels, camera.width, camera.height)).save(part)
    warn(*loaded.warnings)
    for name, number in legend(view, color)[:_NAMED]:
        typer.echo(f"{number:9d}  {name}")
    typer.echo(f"{len(view.position)} photons: wrote {output}")


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
        if sys.stdout.isatty():
            typer.echo()
    warn(*loaded.warnings)
    stored = sum(map(sum, header.stored))
    megabytes = path.stat().st_size / 1e6
    typer.echo(
        f"{header.passes} passes, {stored} photons, {megabytes:.1f} MB, {seconds:.1f} s: "
        f"wrote {path}"
    )
