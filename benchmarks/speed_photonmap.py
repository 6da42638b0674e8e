"""Photon Map from its core, as the benchmark runs it.

The kernels are loaded by a first render, as of a pass. The clock counts all that comes after
the building of the ray tracer, which is left out, as it is of the peers: every pilot, and
rendering. Beside the images at the times asked for there is one at each power of two of
the passes, and with each what the engine says of its own error.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from threading import Event
from typing import Any

import numpy as np
from measure import Image

from photon_map.core import Kept, Scene, Settings, render
from photon_map.core.geometry.intersector import Intersector
from photon_map.core.prepared import Prepared
from photon_map.core.version import ENGINE, VERSION

ENDLESS = 10_000_000
#: Passes after which an image is kept, besides those at the times asked for.
PASSES = [2**k for k in range(1, 24)]


def version() -> str:
    """Name and version."""
    return f"{ENGINE} {VERSION}"


def settings(seed: int, threads: int, passes: int = ENDLESS) -> Settings:
    """The engine's own choices, but the box filter that all peers have."""
    return Settings(
        passes=passes, seed=seed, threads=threads, pixel_filter="BOX", filter_width=1.0
    )


class QueryClock:
    """Seconds of the processor in ray queries, over all threads."""

    def __init__(self) -> None:
        self.spent: list[float] = []

    def watch(self, owner: type, name: str) -> None:
        """Count the calls of a method of ``owner`` from now on."""
        method = getattr(owner, name)

        def timed(*arguments: Any) -> Any:
            begin = time.thread_time()
            try:
                return method(*arguments)
            finally:
                self.spent.append(time.thread_time() - begin)

        setattr(owner, name, timed)


class Built(Kept):
    """Keeps nothing, and tells when the ray tracer was built: ``seconds`` of the clock."""

    def __init__(self) -> None:
        super().__init__(0)
        self.seconds = 0.0

    def prepare(self, scene: Scene, settings: Settings, stop: Event) -> Prepared:
        """As without a clock."""
        prepared = super().prepare(scene, settings, stop)
        self.seconds = time.perf_counter()
        return prepared


def snapshots(
    scene: Scene, engine: str, times: Sequence[float], seed: int, threads: int, ready: Any
) -> Iterator[tuple[float, Image, dict[str, float]]]:
    """Seconds, image (h, w, 3) with row 0 at the top, and what ``Row`` tells of us alone.

    Soon after each of ``times`` and of ``PASSES``.
    """
    for update in render(scene, settings(seed, threads)):
        if update.passes:
            break
    ready()
    built = Built()
    waiting, powers, paused = list(times), list(PASSES), 0.0
    clock = QueryClock()
    for name in ("nearest", "is_free"):
        clock.watch(Intersector, name)
    updates = render(scene, settings(seed, threads), built)
    begun = 0.0
    for update in updates:
        if update.phase == "setup":
            clock.spent.clear()
            begun = time.process_time()
            continue
        seconds = time.perf_counter() - built.seconds - paused
        if not update.passes or (seconds < waiting[0] and update.passes < powers[0]):
            continue
        stopped, worked = time.perf_counter(), time.process_time()
        image = update.film.resolve("combined")[::-1, :, :3].astype(np.float64)
        while waiting and waiting[0] <= seconds:
            waiting.pop(0)
        while powers[0] <= update.passes:
            powers.pop(0)
        told = {
            "passes": update.passes,
            "stated": update.relative_error,
            "noise": update.error.noise,
            "bias": update.error.bias,
            "embree": sum(clock.spent) / max(worked - begun, 1e-9),
        }
        yield seconds, image, told
        paused += time.perf_counter() - stopped
        begun += time.process_time() - worked
        if not waiting:
            updates.close()
            return
