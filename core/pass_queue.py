"""The work of passes, queued for the threads of a render."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from typing import Any, NamedTuple, TypeVar

from .camera_pass.chunk import PhotonMaps
from .camera_pass.guide import Guide
from .camera_pass.pixels import Pixels, Region
from .jit import obey
from .light_groups import GroupChunk, lit_by, trace_groups
from .photon_pass import PhotonSource, TracedPhotons, photon_maps, walk_and_connect
from .pilot import Radii
from .prepared import Prepared
from .scene.scene import Scene
from .settings import Settings

_T = TypeVar("_T")


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

    def submit(self, work: Callable[..., _T], *arguments: Any) -> Future[_T]:
        """Queue ``work`` unless the render has been cancelled by the time it starts."""

        def guarded() -> _T:
            if self.stop.is_set():
                raise CancelledError
            return work(*arguments)

        return self._pool.submit(guarded)

    def photons(
        self, settings: Settings, radii: Radii, sides: list[Side], i: int
    ) -> Future[list[PhotonMaps]]:
        """Queue the photon batches of pass ``i`` and, behind them, the sorting."""
        batches, own = sides[0].source.batches, (settings, radii, i)
        walks = [[self.submit(walk_and_connect, *s, *own, b) for b in batches] for s in sides]

        def sort() -> list[PhotonMaps]:
            # The batches are before this task in the queue: no thread waits for itself.
            return [
                photon_maps(settings, radii, i, batches, [w.result() for w in own])
                for own in walks
            ]

        return self.submit(sort)

    def chunks(
        self,
        settings: Settings,
        region: Region,
        sides: list[Side],
        maps: list[PhotonMaps],
        pixels: Pixels,
    ) -> Iterator[Future[GroupChunk]]:
        """Camera chunks of the paths ``pixels``, each queued when it is asked for."""
        size = settings.chunk_size
        prepared = [side.prepared for side in sides]
        for start in range(0, pixels.paths, size):
            part = slice(start, start + size)
            some = Pixels(pixels.ids[part], pixels.numbers[part])
            yield self.submit(trace_groups, prepared, settings, region, some, maps)
