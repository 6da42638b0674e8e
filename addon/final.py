"""The final render: export, pull the core's updates, write the film into the result."""

from __future__ import annotations

import sys
import time
import traceback
from collections.abc import Generator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np
from numpy.typing import NDArray

from .baking import maps_settings
from .denoise import GUIDES, DenoiseError, denoise, is_available
from .export.scene import ExportCancelledError, export_scene
from .export.settings import export_settings
from .insight import remember
from .interruption import interrupting
from .job import CURRENT
from .kernel_cache import use_extension_folder
from .mattes import matte_stamps
from .motion import motion_of
from .passes import active_passes, asked_settings, pass_name
from .preview import LONG, WAITING, preview_scene, preview_settings
from .report import ExportError, ExportLog

if TYPE_CHECKING:
    from ..core import Film, Kept, Scene, Settings, Update

#: Seconds between two looks of the user at the unfinished image.
REDRAW_INTERVAL = 0.25


def render_final(engine: Any, depsgraph: Any) -> None:
    """Render the view layer of ``depsgraph`` into the result of ``engine``.

    A break (Escape, Ctrl-C in Blender) ends it and keeps the image so far. The core's
    generator is closed on every way out, so that its threads have ended on return.
    """
    job = CURRENT.get()
    engine.update_stats("", f"{depsgraph.view_layer_eval.name} | Exporting")
    log = ExportLog()
    try:
        motion = motion_of(engine, depsgraph, lambda: stopped(engine))
        scene = export_scene(depsgraph, engine, log, lambda: stopped(engine))
    except ExportCancelledError:
        write_nothing(engine, depsgraph.view_layer_eval)
        return
    view_layer = depsgraph.view_layer_eval
    layer = view_layer.name
    settings = export_settings(
        depsgraph.scene_eval,
        {
            **_asked(engine, depsgraph),
            **(job.overrides if job else {}),
        },
    )
    if engine.is_preview:
        scene = preview_scene(scene)
    if job is not None:
        job.exported(layer, scene, settings, log.messages)
        if job.export_only:
            write_nothing(engine, view_layer)
            return
    tell(engine, log.messages)
    updates, kept = _core_render(scene, settings)
    last: Update | None = None
    try:
        # Blender's own tests of a break without a window are at the updates alone.
        with interrupting(lambda: stopped(engine), kept) if watched() else nullcontext():
            last = _pull(engine, updates, view_layer, settings)
    finally:
        updates.close()
        WAITING.clear()
    if last is None or last.passes == 0:
        write_nothing(engine, view_layer)
        return
    made = {}
    if motion is not None:
        made["vector"] = motion.vectors(last.film, scene)
    denoised = _denoised(engine, depsgraph, last.film, settings)
    write_film(engine, last.film, view_layer, denoised, made)
    write_stamps(engine, {**matte_stamps(view_layer, scene), **render_stamps(layer, last)})
    if not engine.is_preview:
        remember(depsgraph.scene, last.plan, log.messages, result_line(last))
    bad = last.film.statistics.non_finite
    tell(engine, [f"{bad} samples were not finite and are black"] if bad else [])


def _asked(engine: Any, depsgraph: Any) -> dict[str, Any]:
    """What the passes, the denoiser and baked maps ask for, or a preview."""
    if engine.is_preview:
        return preview_settings()
    asked = asked_settings(depsgraph)
    guides = GUIDES if depsgraph.scene_eval.photon_map.use_denoise and is_available() else ()
    asked |= maps_settings(depsgraph.scene)
    return asked | {"first_hit": tuple(dict.fromkeys((*asked["first_hit"], *guides)))}


def _denoised(
    engine: Any, depsgraph: Any, film: Film, settings: Settings
) -> NDArray[np.float32] | None:
    """The picture without noise where the user wants it and Blender can do it.

    Not of a render that was stopped: who presses Escape does not wait.
    """
    if not depsgraph.scene_eval.photon_map.use_denoise or engine.is_preview:
        return None
    try:
        if stopped(engine):
            raise DenoiseError("the render was stopped")
        if set(GUIDES) - set(settings.first_hit):
            raise DenoiseError("this Blender was built without Open Image Denoise")
        engine.update_stats("", "Denoising")
        return denoise(film, settings.thread_count)
    except DenoiseError as error:
        tell(engine, [f"the image is not denoised: {error}"])
        return None


def stopped(engine: Any) -> bool:
    """Whether the user wants the render to end."""
    return bool(engine.test_break())


def watched() -> bool:
    """Whether somebody may look at the unfinished image; else it is written at the end."""
    return not bpy.app.background


def tell(engine: Any, warnings: Sequence[str]) -> None:
    """Show warnings, except of a material preview."""
    if not engine.is_preview:
        for message in warnings:
            engine.report({"WARNING"}, message)


def _core_render(
    scene: Scene, settings: Settings
) -> tuple[Generator[Update, None, None], Kept]:
    """Start the core; its heavy imports (numba, scipy, embreex) happen here.

    Its updates, and what cancels them.
    """
    use_extension_folder()
    try:
        from ..core import Kept, render
    except ImportError as error:
        raise ExportError(
            f"a package that the engine needs is missing: {error}; install numba, scipy and "
            "embreex for this Python, or the extension's archive, which contains them"
        ) from error
    kept = Kept(0)
    updates: Any = render(scene, settings, kept)
    return updates, kept


def _pull(
    engine: Any, updates: Generator[Update, None, None], view_layer: Any, settings: Settings
) -> Update | None:
    """Draw updates until the core is done or the user stops it; the last one."""
    from ..core import completed

    job = CURRENT.get()
    last: Update | None = None
    first = True
    shown = 0
    redrawn = time.monotonic()
    for last in _until_cancelled(updates, engine):
        if first:
            tell(engine, last.plan.warnings)
            first = False
        if engine.is_preview and last.setup_seconds > LONG:
            WAITING.set()
        enough = job is not None and job.updated(view_layer.name, last)
        fraction = completed(last, settings)
        engine.update_progress(fraction)
        engine.update_stats("", stats_line(view_layer.name, last, fraction))
        used = last.film.nbytes / 2**20
        engine.update_memory_stats(memory_used=used, memory_peak=used)
        if enough or stopped(engine):
            break
        now = time.monotonic()
        if watched() and last.passes > shown and now - redrawn > REDRAW_INTERVAL:
            write_film(engine, last.film, view_layer)
            shown, redrawn = last.passes, time.monotonic()
    return last


def _until_cancelled(
    updates: Generator[Update, None, None], engine: Any
) -> Generator[Update, None, None]:
    """``updates``, up to where the user wanted no more of them."""
    try:
        yield from updates
    except CancelledError as error:
        if not stopped(engine):
            raise
        # Its frames hold the scene, and are held by futures of theirs.
        traceback.clear_frames(error.__traceback__)


def write_stamps(engine: Any, stamps: Mapping[str, str]) -> None:
    """Write metadata of the file, which belong to the whole result and not to its parts."""
    result = engine.get_result()
    for key, text in stamps.items():
        result.stamp_data_add_field(key, text)


def write_film(
    engine: Any,
    film: Film,
    view_layer: Any,
    denoised: NDArray[np.float32] | None = None,
    made: Mapping[str, NDArray[np.float32]] | None = None,
) -> None:
    """Copy the film into the render result; the film's first row is Blender's, the lowest.

    ``denoised`` (h, w, 4) takes the place of Combined. ``made``: layers (h, w, channels)
    that the film does not have; while they are not known their passes stay as they are.
    """
    result = engine.begin_result(0, 0, film.width, film.height, layer=view_layer.name)
    try:
        if not result.layers:  # the layer was disabled meanwhile
            return
        passes = result.layers[0].passes
        resolved = dict(made or {})
        for entry in active_passes(view_layer):
            target = passes.get(pass_name(entry))
            if target is None or (entry.layer == "vector" and "vector" not in resolved):
                continue
            if entry.layer not in resolved:
                resolved[entry.layer] = film.resolve(entry.layer)
            whole = resolved[entry.layer]
            if entry.name == "Combined" and denoised is not None:
                whole = denoised
            part = whole[..., entry.first : entry.first + len(entry.channels)]
            pixels = np.ascontiguousarray(part, dtype=np.float32)
            target.rect.foreach_set(pixels.ravel())
    finally:
        engine.end_result(result)


def write_nothing(engine: Any, view_layer: Any) -> None:
    """Leave an empty result: Blender crashes when it writes a multilayer EXR without one."""
    engine.end_result(engine.begin_result(0, 0, 1, 1, layer=view_layer.name))


def result_line(update: Update) -> str:
    """How a render ended, for the panel."""
    parts = [f"{update.passes} passes", f"{update.seconds:.1f} s"]
    if update.passes >= 2 and update.relative_error < float("inf"):
        parts.append(f"relative error {100 * update.relative_error:.2f} %")
    parts.append(f"{update.film.statistics.rays / 1e6:.1f} million rays")
    return ", ".join(parts)


def render_stamps(layer: str, update: Update) -> dict[str, str]:
    """Metadata of the file: how the picture came about, and how wrong it says it is."""
    statistics = update.film.statistics
    stamps = {
        "passes": str(update.passes),
        "seconds": f"{update.seconds:.2f}",
        "rays": str(statistics.rays),
        "photons": str(statistics.photons_emitted),
        "photon_megabytes": f"{update.photon_bytes / 2**20:.1f}",
        "film_megabytes": f"{update.film.nbytes / 2**20:.1f}",
        "peak_megabytes": f"{peak_memory() / 2**20:.0f}",
    }
    if update.passes >= 2 and update.relative_error < float("inf"):
        stamps["relative_error"] = f"{update.relative_error:.6f}"
    return {f"photon_map.{layer}.{key}": text for key, text in stamps.items()}


def peak_memory() -> int:
    """Most memory that the whole process has had so far [bytes], 0 where nobody knows."""
    try:
        import resource
    except ImportError:  # Windows
        return 0
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most


def stats_line(layer: str, update: Update, fraction: float) -> str:
    """The line of statistics: Blender shows it above the image and in the console."""
    parts = [layer, f"{100 * fraction:.0f} %", f"Pass {update.passes}"]
    if update.passes >= 2 and update.relative_error < float("inf"):
        parts.append(f"Error {100 * update.relative_error:.2f} %")
    if update.phase != "render" and update.message:
        parts.append(update.message)
    return " | ".join(parts)
