"""Ends a final render when the user wants it, between two updates of the core."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..core import Kept

#: Seconds between two looks.
INTERVAL = 0.02


@contextmanager
def interrupting(wanted: Callable[[], bool], kept: Kept) -> Iterator[None]:
    """Have a thread ask ``wanted`` during the block, and cancel the render that has ``kept``.

    That one then ends with ``CancelledError``. The core yields ten times a second; on a
    machine with other work that is seldom, as it works out its error before.
    """
    over = threading.Event()

    def look() -> None:
        while not over.wait(INTERVAL):
            if wanted():
                kept.cancel()
                return

    thread = threading.Thread(target=look, name="photon_map_break", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
