"""A render: the order of its phases, and nothing else."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor, wait
from dataclasses import replace
from itertools import islice
from typing import Any, NamedTuple, TypeVar

from .ahead import compile_ahead
from .aim_pass import aimed
from .baking.bake import photon_source
from .balance import (
    PASSES,
    Look,
    balanced,
    caustics_by_paths,
    is_free,
    parts_of_look,
    stage_of,
)
from .camera_pass.chunk import PhotonMaps
from .camera_pass.pixels import Pixels, Region
from .film.stated_error import UNKNOWN
from .guide_pass import guided, wants_guide
from .jit import has_compiled, obey, set_compiled
from .kept import Kept
from .light_groups import GroupChunk, lit_by, trace_groups
from .path_density import PathDensity
from .photon_memory import (
    Afforded,
    PhotonMemory,
    Stored,
    affordable,
    emitted,
    stored_in,
)
from .photon_pass import (
    PhotonSource,
    TracedPhotons,
    photon_batches,
    photon_maps,
    pilot_radii,
    walk_and_connect,
)
from .photons.trace import Walk
from .pilot import Radii
from .plan import Plan
from .prepared import Prepared
from .scene.scene import Scene, SceneError
from .settings import Settings
from .update import Phase, Update
from .warm_up import empty_film, warm_up

_T = TypeVar("_T")

#: What the first render with a version of the kernels says.
COMPILING = "Compiling the kernels: half a minute or so, once after each installation"

#: Longest silence between two updates [s].
SILENCE = 0.1


def render(scene: Scene, settings: Settings, kept: Kept | None = None) -> Iterator[Update]:
    """Render ``scene``: an update at least every 0.25 s, the last one with phase "done".

    Pulling no further (closing the iterator) is the cancel: work under way stops within a
    chunk's time and the threads are joined. Every thread count and chunk size gives the
    same film, bit for bit. Raises ``SceneError`` before any work.
    """
    if scene.camera is None:
        raise SceneError(
            f"scene '{scene.name}' has no camera: add one and make it the scene's camera"
        )
    region = Region.of(scene.camera, settings)
    if region.width * region.height == 0:
        raise SceneError(f"the border {settings.region} lies outside the image")
    return _Render(scene, settings, region, kept or Kept(0)).updates()


class _Side(NamedTuple):
    """All lights, or one group of them, and the photons of these lights."""

    prepared: Prepared
    source: PhotonSource


class _Render:
    """The state of one render; lives as long as its iterator."""

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
        self.pool = ThreadPoolExecutor(settings.thread_count, "photon_map", obey, (self.stop,))
        self.begin = self.render_begin = time.perf_counter()
        # Chunks queued at a time: enough for every thread, few enough for the memory.
        self.in_flight = 2 * settings.thread_count + 2
        self.compiling = True
        self.memory = PhotonMemory(settings)
        self.error, self.error_passes = UNKNOWN, 0

    def updates(self) -> Iterator[Update]:
        """All phases."""
        pilot = "pilot pass" if has_compiled() else COMPILING
        try:
            yield self._update("setup", "building the scene")
            prepared = yield from self._watch(
                self.pool.submit(self.kept.prepare, self.scene, self.settings, self.stop),
                "building the scene",
            )
            prepared, source, afforded = yield from self._watch(
                self.pool.submit(self._photons, prepared),
                "photon maps" if self.settings.photon_maps else pilot,
            )
            traced = isinstance(source, TracedPhotons)
            self._afford(afforded, traced)
            source = self.kept.photons(source, self.settings)
            of_pilot = (prepared, self.settings, self.region, source)
            radii = yield from self._watch(self.pool.submit(pilot_radii, *of_pilot), pilot)
            self.kept.leave(self.memory.expect(afforded.stored, radii))
            self.plan = radii.expected.with_stage(self.plan) if radii.expected else self.plan
            known = (self.settings, self.plan, self.region, radii, source)
            yield from self._watch(self.pool.submit(warm_up, prepared, *known), pilot)
            self.compiling = False
            set_compiled()
            self.render_begin = time.perf_counter()
            if wants_guide(self.settings, self.plan, self.region):
                learning = self.pool.submit(
                    guided, prepared, self.settings, self.region, radii, source
                )
                prepared, stage = yield from self._watch(learning, pilot)
                self.plan = self.plan._replace(stages=(*self.plan.stages, stage))
            if is_free(self.settings) and source.batches:
                radii, source = yield from self._balance(prepared, radii, source, traced)
            yield from self._passes(self._sides(prepared, source), radii)
            yield self._update("done", "")
        finally:
            self.stop.set()
            # A kernel that is being compiled cannot be interrupted: its thread then ends by
            # itself before the next one. Everything else is joined here.
            self.pool.shutdown(wait=not self.compiling, cancel_futures=True)

    def _update(self, phase: Phase, message: str) -> Update:
        now = time.perf_counter()
        setup = phase == "setup"
        passes = self.film.passes
        if passes != self.error_passes:
            self.error = self.film.stated_error()
            self.error_passes = passes
        return Update(
            phase=phase,
            passes=passes,
            film=self.film,
            error=self.error,
            seconds=0.0 if setup else now - self.render_begin,
            setup_seconds=(now if setup else self.render_begin) - self.begin,
            plan=self.plan,
            message=message,
            photon_bytes=self.memory.peak,
        )

    def _watch(self, future: Future[_T], message: str) -> Generator[Update, None, _T]:
        """Yield updates until ``future`` is done, then hand its result over."""
        while not wait([future], timeout=SILENCE).done:
            yield self._update("setup", message)
        return future.result()

    def _photons(self, prepared: Prepared) -> tuple[Prepared, PhotonSource, Afforded]:
        self.pool.submit(compile_ahead, prepared, self.settings, self.plan, self.region)
        prepared, plan = self.kept.focused(prepared, self.settings, self.plan)
        prepared, plan = aimed(prepared, self.settings, plan, self.region)
        pixels = self.region.width * self.region.height
        afforded = affordable(prepared, self.settings, plan, pixels)
        asked = (self.scene, self.settings, plan, prepared, afforded)
        source, self.plan, afforded = photon_source(*asked)
        return prepared, source, afforded

    def _afford(self, afforded: Afforded, traced: bool) -> None:
        """Keep to what there is memory for."""
        if afforded.warnings:
            warnings = (*self.plan.warnings, *afforded.warnings)
            self.plan = self.plan._replace(warnings=warnings)
            if traced:
                caustic, global_ = emitted(afforded.batches)
                self.settings = replace(
                    self.settings, photons_caustic=caustic, photons_global=global_
                )

    def _balance(
        self, prepared: Prepared, radii: Radii, source: PhotonSource, traced: bool
    ) -> Generator[Update, None, tuple[Radii, PhotonSource]]:
        """Decide what is automatic; ``traced``: whether other photons can be asked for."""
        asked = "looking where noise comes from"
        walks = [
            [self._submit(source.walk, i, batch) for batch in source.batches] for i in PASSES
        ]
        found: list[Walk] = []
        maps = []
        while walks:
            futures = walks.pop(0)
            found = []
            for future in futures:
                found.append((yield from self._watch(future, asked)))
            maps.append(photon_maps(self.settings, radii, 0, source.batches, found))
        parts: list[Future[Any]] = [
            self._submit(*part)
            for part in parts_of_look(prepared, self.settings, self.region, maps)
        ]
        shown = []
        for part in parts:
            shown.append((yield from self._watch(part, asked)))
        one, two, three, direct = shown
        seen = Look(one, two, three, direct, source.batches, found)
        self.density.caustics = caustics_by_paths(seen)
        before, stored = self.settings, stored_in(seen.batches, found)
        fits = self.memory.fits_with(stored)
        self.settings = balanced(before, seen, self.region, traced, fits)
        self.plan = self.plan._replace(stages=(*self.plan.stages, stage_of(self.settings)))
        if traced:
            pixels = self.region.width * self.region.height
            batches = photon_batches(self.plan, self.settings, pixels)
            source = TracedPhotons(prepared, self.settings, batches)
            source = self.kept.photons(source, self.settings)
            factor = emitted(batches)[0] / max(1, emitted(seen.batches)[0])
            stored = Stored(factor * stored.caustic, stored.global_)
            self.kept.leave(self.memory.expect(stored, radii))
        return radii.with_caustics(self.settings.caustic_radius / before.caustic_radius), source

    def _sides(self, prepared: Prepared, source: PhotonSource) -> list[_Side]:
        """All lights, and each group of them."""
        sides = [_Side(prepared, source)]
        for group in self.settings.light_groups:
            alone = lit_by(prepared, self.scene, group)
            sides.append(_Side(alone, TracedPhotons(alone, self.settings, source.batches)))
        return sides

    def _passes(self, sides: list[_Side], radii: Radii) -> Generator[Update, None, None]:
        """Passes until a limit is met; photons are traced up to two passes ahead.

        So there is always work in the queue while a map is sorted, and no thread idles at
        the end of a phase. Chunks are added to the film in order.
        """
        last = time.perf_counter()
        ahead = self.memory.ahead
        maps = deque(
            self._launch_photons(radii, sides, i)
            for i in range(min(ahead, self.settings.passes))
        )
        for i in range(self.settings.passes):
            while not wait([maps[0]], timeout=SILENCE).done:
                yield self._update("render", "")
                last = time.perf_counter()
            current = maps.popleft().result()
            self._count(current)
            waiting = self._chunks(sides, current, i)
            chunks = deque(islice(waiting, self.in_flight))
            if i + ahead < self.settings.passes:
                maps.append(self._launch_photons(radii, sides, i + ahead))
            while chunks:
                while not wait([chunks[0]], timeout=SILENCE).done:
                    yield self._update("render", "")
                    last = time.perf_counter()
                self._add(i, chunks.popleft().result())
                chunks.extend(islice(waiting, 1))
                if not chunks:
                    self.film.end_pass()
                if self._out_of_time():
                    return
                if time.perf_counter() - last >= SILENCE:
                    yield self._update("render", "")
                    last = time.perf_counter()
            if 0 < self.settings.error_goal and (
                self._update("render", "").relative_error <= self.settings.error_goal
            ):
                return

    def _add(self, i: int, chunk: GroupChunk) -> None:
        whole, groups = chunk
        ids = whole.pixels.ids
        self.film.add(i, ids, whole.samples)
        self.film.add_asked(i, ids, whole.first_hits, whole.kinds, whole.aovs)
        self.film.add_groups(ids, groups)
        self.film.statistics.rays += whole.rays

    def _count(self, sides: list[PhotonMaps]) -> None:
        statistics = self.film.statistics
        for maps in sides:
            statistics.photons_emitted += maps.emitted
            statistics.photons_stored += maps.stored
            statistics.rays += maps.rays
        self.memory.count(sides)

    def _out_of_time(self) -> bool:
        """Whether the time is up; one whole pass is always made."""
        limit = self.settings.seconds
        return (
            limit > 0
            and time.perf_counter() - self.render_begin >= limit
            and self.film.passes > 0
        )

    def _launch_photons(
        self, radii: Radii, sides: list[_Side], i: int
    ) -> Future[list[PhotonMaps]]:
        """Queue the photon batches of pass ``i`` and, behind them, the sorting."""
        batches, own = sides[0].source.batches, (self.settings, radii, i)
        walks = [[self._submit(walk_and_connect, *s, *own, b) for b in batches] for s in sides]

        def sort() -> list[PhotonMaps]:
            # The batches are before this task in the queue: no thread waits for itself.
            return [
                photon_maps(self.settings, radii, i, batches, [w.result() for w in own])
                for own in walks
            ]

        return self._submit(sort)

    def _chunks(
        self, sides: list[_Side], maps: list[PhotonMaps], i: int
    ) -> Iterator[Future[GroupChunk]]:
        """The camera chunks of pass ``i``, each queued when it is asked for."""
        pixels = self.density.pixels(i, self.film)
        size = self.settings.chunk_size
        prepared = [side.prepared for side in sides]
        for start in range(0, pixels.paths, size):
            part = slice(start, start + size)
            some = Pixels(pixels.ids[part], pixels.numbers[part])
            yield self._submit(trace_groups, prepared, self.settings, self.region, some, maps)

    def _submit(self, work: Callable[..., _T], *arguments: Any) -> Future[_T]:
        """Queue ``work`` unless the render has been cancelled by the time it starts."""

        def guarded() -> _T:
            if self.stop.is_set():
                raise CancelledError
            return work(*arguments)

        return self.pool.submit(guarded)
