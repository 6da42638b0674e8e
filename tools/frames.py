"""When viewports have drawn which picture, and waiting for one, inside of Blender."""

from __future__ import annotations

import importlib
import itertools
import time
from collections.abc import Callable, Generator
from typing import Any, NamedTuple, TypeAlias
from weakref import WeakKeyDictionary

#: Longest wait for anything [s].
PATIENCE = 240.0

#: Seconds to wait, one by one, until a part of the test has ended.
Steps: TypeAlias = Generator[float, None, None]


class Drawn(NamedTuple):
    """When a picture was drawn, processor seconds of Blender by then, whose it is."""

    at: float
    processor: float
    worker: int
    line: str


class Frames:
    """When viewports have drawn which picture of which worker."""

    def __init__(self, module: str) -> None:
        self.drawn: list[Drawn] = []
        # Numbers of workers: Python gives the identity of one that has ended to another one.
        numbers: WeakKeyDictionary[Any, int] = WeakKeyDictionary()
        viewport = importlib.import_module(f"{module}.addon.viewport").ViewportRender
        original = viewport.draw
        count = itertools.count(1)

        def draw(view: Any, context: Any, depsgraph: Any) -> str:
            before = view._drawn
            line: str = original(view, context, depsgraph)
            if view._drawn is not before and view._drawn is not None:
                worker = numbers.setdefault(view._worker, next(count))
                self.drawn.append(
                    Drawn(time.monotonic(), time.process_time(), worker, view._drawn.line)
                )
            return line

        viewport.draw = draw

    def passes(self, since: float) -> int:
        """Passes of the newest picture drawn after ``since``, 0 when there is none."""
        lines = [drawn.line for drawn in self.drawn if drawn.at > since]
        return int(lines[-1].split()[1].split("/")[0]) if lines else 0

    def workers(self, since: float) -> set[int]:
        """Those whose pictures were drawn after ``since``."""
        return {drawn.worker for drawn in self.drawn if drawn.at > since}

    def first(self, since: float, old: int) -> Drawn | None:
        """The first picture after ``since`` by another worker than ``old``."""
        for drawn in self.drawn:
            if drawn.at > since and drawn.worker != old:
                return drawn
        return None

    def until(self, passes: int, what: str) -> Steps:
        """Wait for a picture of so many passes, drawn from now on."""
        begin = time.monotonic()
        yield from until(lambda: self.passes(begin) >= passes, f"{passes} passes {what}")

    @property
    def worker(self) -> int:
        """The one that drew last."""
        return self.drawn[-1].worker if self.drawn else 0


def films(module: str) -> list[float]:
    """When final renders show a picture from now on; grows."""
    final: Any = importlib.import_module(f"{module}.addon.final")
    original, shown = final.write_film, []

    def write(*arguments: Any) -> None:
        original(*arguments)
        shown.append(time.monotonic())

    final.write_film = write
    return shown


def until(condition: Callable[[], object], what: str, patience: float = PATIENCE) -> Steps:
    """Wait for ``condition``."""
    end = time.monotonic() + patience
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError(what)
        yield 0.02
