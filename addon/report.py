"""What the user is told: export warnings, and errors that Blender would swallow."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ..core.scene.errors import SceneError
from ..core.settings import SettingsError
from .job import CURRENT


class ExportError(RuntimeError):
    """A scene that cannot be exported; the message names the data and what to do."""


class ExportLog:
    """Collects warnings of one export, each once, in the order they came up."""

    def __init__(self) -> None:
        self._warnings: dict[object, str] = {}
        self._grouped: dict[str, dict[str, None]] = {}

    def warn(self, message: str, key: object = None) -> None:
        """Keep ``message``, unless there is one of the same ``key`` (default: its text)."""
        self._warnings.setdefault(message if key is None else key, message)

    def warn_group(self, what: str, name: str) -> None:
        """Keep one warning ``what`` for all the ``name`` it happens to."""
        self._grouped.setdefault(what, {}).setdefault(name)

    @property
    def messages(self) -> tuple[str, ...]:
        """All warnings; grouped ones list up to six names."""
        grouped = []
        for what, names in self._grouped.items():
            shown = ", ".join(list(names)[:6])
            more = f" and {len(names) - 6} more" if len(names) > 6 else ""
            grouped.append(f"{what}: {shown}{more}")
        return (*self._warnings.values(), *grouped)


@contextmanager
def guarded(engine: Any) -> Iterator[None]:
    """Turn an exception of a callback into an error that Blender shows.

    Blender only prints a traceback, saves a blank image and calls it finished; an error
    report makes the operator fail, and a command-line Blender end with 1. A context
    manager, because Blender counts the arguments of callbacks and a decorator hides them.
    """
    try:
        yield
    except (Exception, KeyboardInterrupt) as error:
        expected = isinstance(error, (ExportError, SceneError, SettingsError))
        if not (expected or isinstance(error, KeyboardInterrupt)):
            traceback.print_exc()
            sys.stderr.flush()
        show_error(engine, error)


def show_error(engine: Any, error: BaseException) -> None:
    """Report ``error`` so that the render operator fails and writes no image."""
    interrupted = isinstance(error, KeyboardInterrupt)
    engine.failure = "interrupted" if interrupted else str(error) or type(error).__name__
    job = CURRENT.get()
    if job is not None and not job.failure:
        job.failure, job.interrupted = engine.failure, interrupted
    message = f"Photon Map: {engine.failure}"
    if not engine.is_preview:
        engine.report({"ERROR"}, message)
    engine.error_set(message)
