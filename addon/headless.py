"""Render a .blend from plain Python with the ``bpy`` module; the command line's way in.

    from photon_map.addon import headless
    exported = headless.export_file("a.blend", frame=None, size=None, overrides={})
    exported.scene, exported.settings, exported.warnings
    rendered = headless.render_file(
        "a.blend", frame=3, size=(320, 180), overrides={"passes": 8, "seed": 1},
        png_path="a.png", on_update=show,
    )
    rendered.update.film.resolve("combined"), rendered.scene, rendered.settings

Both go through ``bpy.ops.render.render`` with the registered engine, so they take the same
path as Blender itself. Every failure is a ``HeadlessError`` (a ``RuntimeError``) whose text
can be shown to the user as it is, and leaves no output file; Ctrl-C raises
``KeyboardInterrupt``. ``overrides`` are fields of ``Settings`` (``None`` values are
ignored); ``size`` is in pixels and replaces the resolution and its percentage. The
``update`` is the last one, of the first view layer rendered. Its film covers only the
border when the file renders one: ``settings.region`` says which part of the image.
``on_update`` gets every ``Update`` of ``core.render`` as it comes; when it returns true the
render ends there and its image is kept, when it raises the render fails.

Importing this module imports ``bpy`` and neither numba nor scipy.
"""

from __future__ import annotations

import atexit
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from . import is_registered, register, unregister
from .job import Job, running

if TYPE_CHECKING:
    from ..core import Scene, Settings, Update


class HeadlessError(RuntimeError):
    """A file that cannot be read, exported or rendered; the message says why."""


@dataclass(frozen=True)
class Exported:
    """The frozen scene of a file, the settings to render it with, and what was lost."""

    scene: Scene
    settings: Settings
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class Rendered(Exported):
    """The same, and the last update of the render."""

    update: Update


def load(blend: str | Path) -> None:
    """Register the add-on and open ``blend``; raises ``HeadlessError``."""
    path = Path(blend).expanduser().resolve()
    if not path.exists():
        raise HeadlessError(f"there is no file '{path}'")
    if not path.is_file():
        raise HeadlessError(f"'{path}' is not a file")
    if not is_registered():
        # Before opening: a file whose engine is unknown falls back to another engine.
        register()
        # Blender 4.5 hangs at exit while an engine that has rendered is registered.
        atexit.register(_unregister_at_exit)
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        version = bpy.app.version_string
        reason = str(error).strip().removeprefix("Error: ")
        raise HeadlessError(f"Blender {version} cannot open '{path}': {reason}") from error


def export_file(
    blend: str | Path,
    *,
    frame: int | None = None,
    size: tuple[int, int] | None = None,
    overrides: Mapping[str, Any] | None = None,
) -> Exported:
    """The scene that a render of ``blend`` would see; raises ``HeadlessError``."""
    load(blend)
    job = Job(overrides=_given(overrides), export_only=True)
    _run(_prepared(frame, size), job, png_path=None)
    assert job.scene is not None and job.settings is not None
    return Exported(job.scene, job.settings, job.warnings)


def render_file(
    blend: str | Path,
    *,
    frame: int | None = None,
    size: tuple[int, int] | None = None,
    overrides: Mapping[str, Any] | None = None,
    png_path: str | Path | None = None,
    on_update: Callable[[Update], bool | None] | None = None,
) -> Rendered:
    """Render ``blend``, and let Blender write it to ``png_path``.

    Raises ``HeadlessError`` when anything fails; then nothing is written.
    """
    load(blend)
    job = Job(overrides=_given(overrides), on_update=on_update)
    _run(_prepared(frame, size), job, png_path=None if png_path is None else Path(png_path))
    assert job.scene is not None and job.settings is not None and job.update is not None
    return Rendered(job.scene, job.settings, job.warnings, job.update)


def _given(overrides: Mapping[str, Any] | None) -> dict[str, Any]:
    return {key: value for key, value in (overrides or {}).items() if value is not None}


def _prepared(frame: int | None, size: tuple[int, int] | None) -> bpy.types.Scene:
    scene = bpy.context.scene
    scene.render.engine = "PHOTONMAP"
    # Blender would render the video strips in place of the scene, without asking the engine.
    scene.render.use_sequencer = False
    if frame is not None:
        scene.frame_set(frame)
    if size is not None:
        scene.render.resolution_x, scene.render.resolution_y = size
        scene.render.resolution_percentage = 100
    if scene.camera is None:
        # Blender's own words leave it at "Cannot render, no camera".
        raise HeadlessError(
            f"scene '{scene.name}' has no camera: add one and make it the scene's camera"
        )
    return scene


def _run(scene: bpy.types.Scene, job: Job, png_path: Path | None) -> None:
    """Render ``scene`` for ``job``; the image reaches ``png_path`` only when all went well."""
    with tempfile.TemporaryDirectory(prefix="photonmap-") as folder:
        image = Path(folder) / "image.png"
        if png_path is not None:
            _write_png_to(scene, image)
        with running(job):
            try:
                bpy.ops.render.render(scene=scene.name, write_still=png_path is not None)
            except RuntimeError as error:
                if job.interrupted:
                    raise KeyboardInterrupt from error
                reason = job.failure or str(error).strip().removeprefix("Error: ")
                raise HeadlessError(reason) from error
        if job.scene is None:
            raise HeadlessError(
                f"scene '{scene.name}' has no view layer that is enabled for rendering"
            )
        if not (job.export_only or (job.update and job.update.passes)):
            raise HeadlessError("the render was stopped before its first pass was done")
        if png_path is not None:
            if not image.is_file():
                raise HeadlessError("Blender rendered but wrote no image")
            png_path.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(image, png_path)


def _write_png_to(scene: bpy.types.Scene, image: Path) -> None:
    """Have Blender write a PNG through the scene's view transform to exactly ``image``."""
    output = scene.render.image_settings
    if hasattr(output, "media_type"):  # since 5.0, and it must be set before the format
        output.media_type = "IMAGE"
    output.file_format = "PNG"
    output.color_mode = "RGBA" if scene.render.film_transparent else "RGB"
    output.color_depth = "8"
    scene.render.use_file_extension = False
    scene.render.filepath = str(image)


def _unregister_at_exit() -> None:
    if is_registered():
        unregister()
