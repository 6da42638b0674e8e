"""Where the command line gets its scenes: a .blend through the add-on, or a saved .npz."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .blender_libraries import import_blender
from .core.scene.dump import load_scene
from .core.scene.scene import Scene
from .core.settings import Settings
from .image_file import write_png

if TYPE_CHECKING:
    from .core import Update


class CommandError(Exception):
    """Something that the user can mend; the message is all that is shown."""


@dataclass(frozen=True)
class Loaded:
    """A scene, the settings to render it with, and what was lost on the way."""

    scene: Scene
    settings: Settings
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class Rendered(Loaded):
    """The same after a render, with its last update."""

    update: Update


#: Gets every update; True asks the render to stop and to keep what it has.
OnUpdate = Callable[["Update", Settings], bool]


@dataclass(frozen=True)
class Source:
    """A file with a scene, and what the command line changes about it.

    ``size`` is in pixels; ``overrides`` are fields of ``Settings`` that win over the file's.
    """

    path: Path
    frame: int | None
    size: tuple[int, int] | None
    overrides: dict[str, Any]

    @property
    def is_blend(self) -> bool:
        """Whether Blender has to open the file."""
        return self.path.suffix.lower() == ".blend"

    def load(self) -> Loaded:
        """The scene as a render would see it.

        Raises ``CommandError``, ``SceneError``, ``SettingsError``, ``OSError`` or, for a
        .blend without bpy, ``BlenderMissingError``; so does ``render``.
        """
        return self._load_blend() if self.is_blend else self._load_npz()

    def render(
        self, on_update: OnUpdate, png: Path | None, details: Callable[[Update], dict[str, str]]
    ) -> Rendered:
        """Render, and write the picture to ``png``: a .blend's through its view transform.

        ``details`` makes the picture's metadata (Blender writes its own).
        """
        if self.is_blend:
            return self._render_blend(on_update, png)
        rendered = self._render_npz(on_update)
        if png is not None:
            pixels = rendered.update.film.resolve("combined")
            write_png(png, pixels, details(rendered.update))
        return rendered

    def _load_npz(self) -> Loaded:
        scene, settings = load_scene(self.path)
        if self.size is not None and scene.camera is not None:
            width, height = self.size
            scene = replace(scene, camera=replace(scene.camera, width=width, height=height))
            settings = replace(settings, region=None)
        return Loaded(scene, replace(settings, **self.overrides), ())

    def _render_npz(self, on_update: OnUpdate) -> Rendered:
        from . import core

        loaded = self._load_npz()
        update: Update | None = None
        # A generator: closing it is what stops the threads.
        pulled: Any = core.render(loaded.scene, loaded.settings)
        with closing(pulled) as updates:
            for update in updates:
                if on_update(update, loaded.settings):
                    break
        if update is None or update.passes == 0:
            raise CommandError("the render ended without an image")
        return Rendered(loaded.scene, loaded.settings, loaded.warnings, update)

    def _load_blend(self) -> Loaded:
        import_blender()
        from .addon import headless

        try:
            exported = headless.export_file(
                self.path, frame=self.frame, size=self.size, overrides=self.overrides
            )
        except headless.HeadlessError as problem:
            raise CommandError(str(problem)) from problem
        return Loaded(exported.scene, exported.settings, exported.warnings)

    def _render_blend(self, on_update: OnUpdate, png: Path | None) -> Rendered:
        import_blender()
        from .addon import headless, job

        def pass_on(update: Update) -> bool:
            current = job.CURRENT.get()
            settings = current.settings if current is not None else None
            return on_update(update, settings or Settings())

        try:
            done = headless.render_file(
                self.path, frame=self.frame, size=self.size, overrides=self.overrides,
                png_path=png, on_update=pass_on,
            )  # fmt: skip
        except headless.HeadlessError as problem:
            raise CommandError(str(problem)) from problem
        return Rendered(done.scene, done.settings, done.warnings, done.update)
