"""The commands about photons: ``bake`` keeps their maps, ``photons`` shows where they are."""

from __future__ import annotations

import re
import sys
import time
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
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
from .source import CommandError, Loaded

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
    output: Annotated[
        list[Path] | None,
        typer.Option(
            "--output", "-o", metavar="OUT.ply|OUT.png", help="May be given several times."
        ),
    ] = None,
    color: Annotated[Colour, typer.Option(help="What the colours tell.")] = Colour.POWER,
    kind: Annotated[Kind, typer.Option(help="Which photons.")] = Kind.ALL,
    at: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y",
            help="Pixel from the left and the top: what the gather discs there hold; "
            "OUT.ply takes the paths of their photons.",
        ),
    ] = None,
    count: Annotated[int | None, typer.Option(help="Photons to emit of each kind.")] = None,
    frame: FrameOption = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Pixels.")] = None,
    seed: Annotated[int | None, typer.Option(help="Number of the random streams.")] = None,
) -> None:
    """Show where the photons of FILE land: a cloud of points, or a picture of them."""
    overrides = {"seed": seed, "photons_caustic": count, "photons_global": count}
    pixel = re.fullmatch(r"(\d{1,5}),(\d{1,5})", at) if at else None
    if at and not pixel:
        raise typer.BadParameter(f"'{at}' is not like 120,80", param_hint="--at")
    outputs = output or []
    if not outputs and not pixel:
        raise typer.BadParameter("-o or --at is needed", param_hint="--output")
    with reported_errors():
        source = source_of(file, frame, size, overrides)
        suffixes = (".ply",) if pixel else (".ply", ".png")
        for path in outputs:
            if path.suffix.lower() not in suffixes:
                what = "paths" if pixel else "photons"
                raise CommandError(
                    f"'{path}': {what} are written to a {' or a '.join(suffixes)}"
                )
            check_writable(path, file)
        loaded = source.load()
        warn(*loaded.warnings)
        if pixel:
            _look_at(loaded, int(pixel[1]), int(pixel[2]), kind, color, outputs)
        else:
            _write_photons(loaded, kind, color, outputs)


def _chosen(caustic: Any, kind: Kind) -> Any:
    """Whether photons, or a disc, are of ``kind``."""
    return (caustic == (kind is Kind.CAUSTIC)) | (kind is Kind.ALL)


def _write_photons(loaded: Loaded, kind: Kind, color: Colour, outputs: list[Path]) -> None:
    """All photons as clouds or pictures, and a legend."""
    from .core.photon_shades import photon_colours, photon_legend
    from .core.photon_view import picture_places, view_photons
    from .photon_picture import picture, write_ply

    view = view_photons(loaded.scene, loaded.settings)
    view = view.only(_chosen(view.caustic, kind))
    for output in outputs:
        with replacing(output) as part:
            if output.suffix.lower() == ".ply":
                write_ply(part, view, color)
                continue
            from PIL import Image

            rows, pixels = picture_places(loaded.scene, loaded.settings, view)
            camera = loaded.scene.camera
            assert camera is not None  # view_photons has looked
            seen = photon_colours(view, color)[rows]
            Image.fromarray(picture(seen, pixels, camera.width, camera.height)).save(part)
    for entry in photon_legend(view, color)[:_NAMED]:
        typer.echo(f"{entry.number:9d}  {entry.name}")
    wrote = ", ".join(map(str, outputs))
    typer.echo(f"{len(view.position)} photons: wrote {wrote}")


def _look_at(
    loaded: Loaded, x: int, y: int, kind: Kind, color: Colour, outputs: list[Path]
) -> None:
    """The numbers of the discs that a pixel sees, and the paths of their photons."""
    from .core.photon_shades import photon_colours, photon_legend
    from .core.viewed_pass import ViewedPass
    from .photon_picture import write_paths

    camera = loaded.scene.camera
    if camera is not None and not (x < camera.width and y < camera.height):
        raise CommandError(f"pixel {x},{y} is outside of {camera.width}x{camera.height}")
    viewed = ViewedPass(loaded.scene, loaded.settings)
    assert camera is not None  # ViewedPass has looked
    place = viewed.place_at(*viewed.ray_of(x + 0.5, camera.height - y - 0.5))
    if place is None:
        raise CommandError(f"there is no surface at pixel {x},{y}")
    where = ", ".join(f"{value:.4g}" for value in place.position)
    typer.echo(f"'{place.object}' at ({where})")
    rows = []
    for disc in viewed.discs(place):
        if not _chosen(disc.caustic, kind):
            continue
        rows.append(disc.rows)
        name = "caustic" if disc.caustic else "global"
        light = ", ".join(f"{value:.4g}" for value in disc.irradiance)
        typer.echo(
            f"{name}: {len(disc.rows)} photons within {disc.radius:.4g} m, "
            f"irradiance ({light}) W/m^2"
        )
        view = viewed.view.only(disc.rows)
        for by in ("light", "caster"):
            for entry in photon_legend(view, by, disc.weight)[:_NAMED]:
                share = 100 * entry.share
                typer.echo(f"{entry.number:9d}  {share:5.1f} %  {by} {entry.name}")
    every = np.concatenate([np.zeros(0, np.intp), *rows])
    for output in outputs:
        with replacing(output) as part:
            shades = photon_colours(viewed.view.only(every), color)
            write_paths(part, viewed.paths(every), shades)
        typer.echo(f"{len(every)} paths: wrote {output}")


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
