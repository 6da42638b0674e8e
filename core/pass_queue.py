"""The work of passes, queued for the threads of a render."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError, Future, InvalidStateError, ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from itertools import count
from typing import Any, NamedTuple, TypeVar

from .camera_pass.chunk import PhotonMaps
from .camera_pass.guide import Guide
from .camera_pass.pixels import Pixels, Region
from .jit import obey
from .light_groups import GroupChunk, lit_by, trace_groups
from .photon_pass import PhotonSource, TracedPhotons, photon_maps, walk_and_connect
from .photons.trace import Walk
from .pilot import Radii
from .prepared import Prepared
from .scene.scene import Scene
from .settings import Settings

_T = TypeVar("_T")
_P = TypeVar("_P")


class Side(NamedTuple):
    """All lights, or one group of them, and the photons of these lights."""

    prepared: Prepared
    source: PhotonSource

    def guided(self, guide: Guide) -> Side:
        """With gather rays that ``guide`` sends."""
        return self._replace(prepared=self.prepared._replace(guide=guide))


def sides_of(
    scene: Scene, settings: Settings, prepared: Prepared, source: PhotonSource
) -> list[Side]:
    """All lights, and each group of them."""
    sides = [Side(prepared, source)]
    for group in settings.light_groups:
        alone = lit_by(prepared, scene, group)
        sides.append(Side(alone, TracedPhotons(alone, settings, source.batches)))
    return sides


class PassQueue:
    """Threads, and what they are asked for; nothing starts any more once ``stop`` is set."""

    def __init__(self, threads: int, stop: threading.Event) -> None:
        self.stop = stop
        self._pool = ThreadPoolExecutor(threads, "photon_map", obey, (stop,))

    def close(self, wait: bool) -> None:
        """Forget what is queued; ``wait`` for what is under way."""
        self._pool.shutdown(wait=wait, cancel_futures=True)

    def _check(self) -> None:
        if self.stop.is_set():
            raise CancelledError

    def submit(self, work: Callable[..., _T], *arguments: Any) -> Future[_T]:
        """Queue ``work`` unless the render has been cancelled by the time it starts."""

        def guarded() -> _T:
            self._check()
            return work(*arguments)

        return self._pool.submit(guarded)

    def photons(
        self, settings: Settings, radii: Radii, sides: list[Side], i: int
    ) -> Future[list[PhotonMaps]]:
        """Queue the photon batches of pass ``i``, and the sorting by who has the last one."""
        batches = sides[0].source.batches
        parts = [
            partial(walk_and_connect, side.prepared, side.source, settings, radii, i, batch)
            for side in sides
            for batch in batches
        ]

        def sort(walks: list[Walk]) -> list[PhotonMaps]:
            each = len(batches)
            return [
                photon_maps(settings, radii, i, batches, walks[k * each : (k + 1) * each])
                for k in range(len(sides))
            ]

        return self.join(parts, sort)

    def join(
        self, parts: Sequence[Callable[[], _P]], then: Callable[[list[_P]], _T]
    ) -> Future[_T]:
        """Queue ``parts``; who does the last one goes on with ``then``, of what all returned.

        A task for that would keep a thread waiting for the others.
        """
        if not parts:
            return self.submit(then, [])
        whole: Future[_T] = Future()
        found: dict[int, _P] = {}
        done = count(1)

        def do(k: int) -> None:
            try:
                self._check()
                found[k] = parts[k]()
                if next(done) == len(parts):
                    whole.set_result(then([found[k] for k in range(len(parts))]))
            except BaseException as error:
                with suppress(InvalidStateError):  # another part has failed before
                    whole.set_exception(error)

        for k in range(len(parts)):
            self._pool.submit(do, k)
        return whole

    def chunks(
        self,
        settings: Settings,
        region: Region,
        sides: list[Side],
        maps: list[PhotonMaps],
        pixels: Pixels,
    ) -> Iterator[Callable[[], GroupChunk]]:
        """What camera chunks of the paths ``pixels`` are to do."""
        size = settings.chunk_size
        prepared = [side.prepared for side in sides]
        for start in range(0, pixels.paths, size):
            part = slice(start, start + size)
            some = Pixels(pixels.ids[part], pixels.numbers[part])
            yield partial(trace_groups, prepared, settings, region, some, maps)


class CameraPass:
    """Pass ``number``: its chunks that are queued, in order, and those still ``waiting``.

    ``maps``: those of its sides, which the chunks ask.
    """

    def __init__(
        self, number: int, maps: list[PhotonMaps], waiting: Iterable[Callable[[], GroupChunk]]
    ) -> None:
        self.number = number
        self.maps = maps
        self.waiting = deque(waiting)
        self.chunks: deque[Future[GroupChunk]] = deque()

    def queue(self, queue: PassQueue, most: int) -> None:
        """Have ``most`` of its chunks in ``queue``, if there are so many."""
        while self.waiting and len(self.chunks) < most:
            self.chunks.append(queue.submit(self.waiting.popleft()))
