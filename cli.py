"""The ``photonmap`` command: renders a .blend or a saved scene, and explains its plan.

Exit code 0: done; 1: failed, with one line on stderr and no output file; 2: wrong usage;
130: stopped by Ctrl-C, after what had been rendered was written.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from contextlib import ExitStack
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

try:
    import typer
except ImportError as missing:
    raise SystemExit(f"{missing}; install with: pip install 'photon-map[cli]'") from missing

from .arguments import (
    FileArgument,
    FrameOption,
    check_writable,
    reported_errors,
    source_of,
    warn,
)
from .core.file_replace import replacing
from .core.film.layers import DENSITY_LAYER, aov_layer
from .core.report import ErrorCurve, render_report
from .core.scene.dump import save_scene
from .core.settings import Settings
from .core.version import ENGINE, VERSION
from .curve_file import curve_title, write_curve_plot, write_curve_table
from .image_file import Frame, write_exr
from .photon_commands import MapsUse, bake, maps_settings, photons
from .progress import ProgressDisplay, describe
from .source import CommandError, Loaded, Source

if TYPE_CHECKING:
    from .core import Update

#: Passes when only other limits were asked for: the largest count that Settings takes.
ENDLESS = 10_000_000

app = typer.Typer(
    help=f"{ENGINE}: a photon-mapping renderer for Blender's files.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


class PixelFilter(StrEnum):
    """Pixel filters by the names of the command line."""

    BOX = "box"
    GAUSSIAN = "gaussian"
    BLACKMAN_HARRIS = "blackman-harris"


class Interrupt:
    """Ctrl-C as a wish: the first asks the render to stop, the second ends everything."""

    def __init__(self) -> None:
        self.asked = False

    def __enter__(self) -> Interrupt:
        self._before = signal.signal(signal.SIGINT, self._ask)
        return self

    def __exit__(self, *_: object) -> None:
        signal.signal(signal.SIGINT, self._before)

    def _ask(self, *_: object) -> None:
        if self.asked:
            raise KeyboardInterrupt
        self.asked = True


@app.callback(invoke_without_command=True)
def about(
    version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False,
) -> None:
    """Handle what is asked without a command."""
    if version:
        typer.echo(f"{ENGINE} {VERSION}")
        raise typer.Exit


@app.command()
def render(
    file: FileArgument,
    output: Annotated[
        list[Path],
        typer.Option(
            "--output", "-o", metavar="OUT.png|OUT.exr", help="May be given once for each kind."
        ),
    ],
    frame: FrameOption = None,
    size: Annotated[str | None, typer.Option(metavar="WxH", help="Pixels.")] = None,
    passes: Annotated[int | None, typer.Option(help="Stop after so many passes.")] = None,
    seconds: Annotated[float | None, typer.Option(help="Stop after rendering so long.")] = None,
    error: Annotated[float | None, typer.Option(help="Stop at this relative error.")] = None,
    seed: Annotated[int | None, typer.Option(help="Number of the random streams.")] = None,
    threads: Annotated[int | None, typer.Option(help="Threads; 0 takes every core.")] = None,
    filter_: Annotated[PixelFilter | None, typer.Option("--filter")] = None,
    filter_width: Annotated[float | None, typer.Option(metavar="PX")] = None,
    memory: Annotated[
        int | None,
        typer.Option(metavar="MB", help="Most memory for photons; fewer where it is short."),
    ] = None,
    shadow_photons: Annotated[
        int | None,
        typer.Option(metavar="N", help="Straight paths from the lamps that spare shadow rays."),
    ] = None,
    adaptive: Annotated[
        bool | None,
        typer.Option(
            "--adaptive/--uniform", help="Camera paths where the noise is, or one a pixel."
        ),
    ] = None,
    split_depth: Annotated[
        int | None,
        typer.Option(metavar="N", help="Events at smooth glass that split view rays, 0: none."),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(
            metavar="R.json", help="Counts, times, errors; R.csv and R.svg: the curve."
        ),
    ] = None,
    maps: Annotated[
        MapsUse, typer.Option(help="Baked photon maps beside FILE that do not fit it any more.")
    ] = MapsUse.TRACE,
    save_scene_to: Annotated[
        Path | None, typer.Option("--save-scene", metavar="S.npz", help="Keep the scene.")
    ] = None,
) -> None:
    """Render FILE. It stops at the first limit that is reached.

    Limits given here (--passes, --seconds, --error) replace all of the file's.
    """
    overrides = _limits(passes, seconds, error) | {
        "seed": seed,
        "threads": threads,
        "photon_memory": memory,
        "shadow_photons": shadow_photons,
        "adaptive": adaptive,
        "split_depth": split_depth,
        "pixel_filter": filter_ and filter_.name,
        "filter_width": 1.0
        if filter_ == PixelFilter.BOX and not filter_width
        else filter_width,
    }
    with reported_errors():
        overrides |= maps_settings(file, maps)
        source = source_of(file, frame, size, overrides)
        pictures = _pictures(output)
        others = [path for path in (report, save_scene_to) if path is not None]
        if save_scene_to is not None and save_scene_to.suffix.lower() != ".npz":
            raise CommandError(f"'{save_scene_to}': a scene is saved to an .npz file")
        outputs = [*pictures.values(), *others, *(_beside(report) if report else ())]
        for path in outputs:
            check_writable(path, source.path)
        if len({os.path.realpath(path) for path in outputs}) < len(outputs):
            raise CommandError("two outputs go to the same file")
        stopped = _render_to(source, pictures, report, save_scene_to)
    if stopped:
        typer.echo("stopped by Ctrl-C; what had been rendered was written", err=True)
        raise typer.Exit(130)


@app.command()
def plan(file: FileArgument, frame: FrameOption = None) -> None:
    """Print which stages a render of FILE needs, and why."""
    with reported_errors():
        source = source_of(file, frame, None, {})
        from .core import Plan

        loaded = source.load()
        planned = Plan.of(loaded.scene, loaded.settings)
        width = max((len(stage.name) for stage in planned.stages), default=0)
        for stage in planned.stages:
            typer.echo(f"{stage.name:<{width}}  {'on ' if stage.on else 'off'}  {stage.reason}")
        warn(*loaded.warnings, *planned.warnings)


app.command()(bake)
app.command()(photons)


def main() -> None:
    """Entry point of the ``photonmap`` command."""
    app(prog_name="photonmap")


def _limits(
    passes: int | None, seconds: float | None, error: float | None
) -> dict[str, float | None]:
    """Settings for the limits asked for; without any, the file's own hold."""
    for name, value in (("seconds", seconds), ("error", error)):
        if value is not None and not value > 0:
            raise typer.BadParameter(f"{value} is not above 0", param_hint=f"--{name}")
    if passes is None and seconds is None and error is None:
        return {}
    return {
        "passes": ENDLESS if passes is None else passes,
        "seconds": seconds or 0.0,
        "error_goal": error or 0.0,
    }


def _pictures(outputs: list[Path]) -> dict[str, Path]:
    """The outputs by suffix."""
    pictures: dict[str, Path] = {}
    for path in outputs:
        suffix = path.suffix.lower()
        if suffix not in (".png", ".exr"):
            raise CommandError(f"'{path}': an image is written to a .png or an .exr")
        if suffix in pictures:
            raise typer.BadParameter(f"two {suffix} files", param_hint="--output")
        pictures[suffix] = path
    return pictures


def _beside(report: Path) -> tuple[Path, Path]:
    """Where the curve of a report goes: a table and a plot."""
    return report.with_suffix(".csv"), report.with_suffix(".svg")


def _details(update: Update) -> dict[str, str]:
    return {"software": f"{ENGINE} {VERSION}", "render": describe(update)}


def _frame(result: Loaded) -> Frame | None:
    """The whole image, when only a region of it was rendered."""
    region, camera = result.settings.region, result.scene.camera
    if region is None or camera is None:
        return None
    return Frame(camera.width, camera.height, region[0], region[1])


def _render_to(
    source: Source, pictures: dict[str, Path], report: Path | None, scene_file: Path | None
) -> bool:
    """Render ``source`` into its files, all of them or none; True when Ctrl-C ended it."""
    curve = ErrorCurve()
    with ExitStack() as stack:
        parts = {key: stack.enter_context(replacing(path)) for key, path in pictures.items()}
        interrupt = stack.enter_context(Interrupt())
        with ProgressDisplay(sys.stdout) as display:

            def on_update(update: Update, settings: Settings) -> bool:
                curve.add(update)
                display.show(update, settings)
                if interrupt.asked and update.passes == 0:
                    raise KeyboardInterrupt
                return interrupt.asked

            result = source.render(on_update, parts.get(".png"), _details)
        if ".exr" in parts:
            film = result.update.film
            asked = [DENSITY_LAYER] if DENSITY_LAYER in result.settings.first_hit else []
            asked += map(aov_layer, result.settings.aovs)
            layers = {layer: film.resolve(layer) for layer in (*film.LAYERS, *asked)}
            write_exr(parts[".exr"], layers, _details(result.update), _frame(result))
        if report is not None:
            data = render_report(result.update, result.scene, result.settings, curve.points)
            text = json.dumps(data, indent=2, allow_nan=False) + "\n"
            stack.enter_context(replacing(report)).write_text(text, encoding="utf-8")
            film = result.update.film
            title = curve_title(result.scene.name, film.width, film.height)
            table, plot = _beside(report)
            write_curve_table(stack.enter_context(replacing(table)), curve.points)
            write_curve_plot(stack.enter_context(replacing(plot)), curve.points, title)
        if scene_file is not None:
            save_scene(scene_file, result.scene, result.settings)
    warn(*result.warnings, *result.update.plan.warnings)
    written = [*pictures.values(), *((report, *_beside(report)) if report else ())]
    written += [scene_file] if scene_file else []
    typer.echo(f"{describe(result.update)}: wrote {', '.join(map(str, written))}")
    return interrupt.asked


if __name__ == "__main__":
    main()
