"""What all phases of a render share: its settings so far, plan, film, threads and memory."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, wait
from typing import Any, TypeVar

from .camera_pass.guide import Guide
from .camera_pass.pixels import Region
from .film.stated_error import UNKNOWN, StatedError
from .kept import Kept
from .pass_queue import PassQueue
from .path_density import PathDensity
from .photon_memory import PhotonMemory
from .plan import Plan, Stage
from .scene.scene import Scene
from .settings import Settings
from .steps import Steps
from .update import Phase, Update
from .warm_up import empty_film

_T = TypeVar("_T")

#: Longest silence between two updates [s].
SILENCE = 0.1


class RenderState:
    """Lives as long as the iterator of its render."""

    def __init__(self, scene: Scene, settings: Settings, region: Region, kept: Kept) -> None:
        self.kept = kept
        self.scene = scene
        self.settings = settings
        self.region = region
        self.plan = Plan.of(scene, settings)
        self.film = empty_film(settings, region.width, region.height)
        # Baked photons stand still from frame to frame if each pixel has a path a pass.
        adaptive = settings.adaptive and not settings.photon_maps
        self.density = PathDensity(region.width, region.height, adaptive)
        self.stop = threading.Event()
        self.queue = PassQueue(settings.thread_count, self.stop)
        self.begin = time.perf_counter()
        self.render_begin = self.begin
        #: When the last update was made; passes are often faster than updates.
        self.told = self.begin
        #: What learns where indirect light comes from, None where nothing does.
        self.lesson: Callable[..., Steps[tuple[Guide, Stage]]] | None = None
        self.compiling = True
        self.memory = PhotonMemory(settings)
        self.error = UNKNOWN
        self.error_passes = 0

    def update(self, phase: Phase, message: str) -> Update:
        """How the render stands, in ``phase``."""
        now = self.told = time.perf_counter()
        setup = phase == "setup"
        return Update(
            phase=phase,
            passes=self.film.passes,
            film=self.film,
            error=self.stated(),
            seconds=0.0 if setup else now - self.render_begin,
            setup_seconds=(now if setup else self.render_begin) - self.begin,
            plan=self.plan,
            message=message,
            photon_bytes=self.memory.peak,
        )

    def stated(self) -> StatedError:
        """The stated error of the film as it is."""
        if self.film.passes != self.error_passes:
            self.error = self.film.stated_error()
            self.error_passes = self.film.passes
        return self.error

    def watch(
        self, future: Future[_T], message: str, phase: Phase = "setup"
    ) -> Generator[Update, None, _T]:
        """Yield updates until ``future`` is done, then hand its result over."""
        while not wait([future], timeout=SILENCE).done:
            yield self.update(phase, message)
        return future.result()

    def watch_all(
        self, futures: Iterable[Future[_T]], message: str, phase: Phase = "setup"
    ) -> Generator[Update, None, list[_T]]:
        """As ``watch``, for all of ``futures``; their results in this order."""
        found: list[_T] = []
        for future in futures:
            found.append((yield from self.watch(future, message, phase)))
        return found

    def run(
        self, steps: Steps[_T], message: str, phase: Phase = "setup"
    ) -> Generator[Update, None, _T]:
        """Yield updates until all of ``steps`` are done, the parts of a round side by side."""
        found: list[Any] | None = None
        while True:
            try:
                parts = next(steps) if found is None else steps.send(found)
            except StopIteration as end:
                result: _T = end.value
                return result
            futures = [self.queue.submit(*part) for part in parts]
            found = yield from self.watch_all(futures, message, phase)
