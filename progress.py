"""Shows how a render goes: a bar on a terminal, plain lines in a log."""

from __future__ import annotations

import math
import time
from types import TracebackType
from typing import TYPE_CHECKING, TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from .core.report import completed

if TYPE_CHECKING:
    from .core import Settings, Update

_SECONDS_BETWEEN_LINES = 1.0


def describe(update: Update) -> str:
    """One line: phase, then pass, time and error as far as they are known."""
    if update.passes == 0:
        return update.message or update.phase
    error = update.relative_error
    shown = f"error {error:.4f}" if math.isfinite(error) else "error not known yet"
    return f"pass {update.passes}, {update.seconds:.1f} s, {shown}"


class ProgressDisplay:
    """A context in which ``show`` may be called with every update, as often as they come."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._console = Console(file=stream)
        self._bar: Progress | None = None
        self._last_line = ""
        self._last_time = -math.inf

    def __enter__(self) -> ProgressDisplay:
        if self._console.is_terminal:
            self._bar = Progress(
                BarColumn(), TextColumn("{task.percentage:>3.0f} %  {task.description}"),
                console=self._console, auto_refresh=False, transient=True,
            )  # fmt: skip
            self._bar.start()
            self._bar.add_task("", total=1.0)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

    def show(self, update: Update, settings: Settings) -> None:
        """Show the newest update; lines come once a second at most, and only when new."""
        line = describe(update)
        if self._bar is not None:
            task = self._bar.task_ids[0]
            done = completed(update, settings)
            self._bar.update(task, completed=done, description=line, refresh=True)
            return
        now = time.monotonic()
        if line == self._last_line or now - self._last_time < _SECONDS_BETWEEN_LINES:
            return
        self._last_line, self._last_time = line, now
        print(line, file=self._stream, flush=True)
