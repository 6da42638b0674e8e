"""A render: the order of its phases, and nothing else."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Generator, Iterator
from concurrent.futures import Future, wait
from dataclasses import replace
from functools import partial

from .camera_pass.chunk import PhotonMaps
from .camera_pass.pixels import Region
from .disc_size import DiscSize, sizes_discs
from .guide_pass import guided, wants_guide
from .jit import has_compiled, set_compiled
from .kept import Kept
from .light_groups import GroupChunk
from .opening import balance, pilot
from .pass_queue import CameraPass, Side, sides_of
from .photon_memory import Afforded, emitted
from .photon_pass import TracedPhotons
from .pilot import Radii
from .render_state import SILENCE, RenderState
from .scene.scene import Scene, SceneError
from .settings import Settings
from .update import Update
from .warm_up import warm_up

#: What the first render with a version of the kernels says.
COMPILING = "Compiling the kernels: half a minute or so, once after each installation"

#: What is said while the guide is learnt.
LEARNING = "looking where indirect light comes from"


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


class _Render(RenderState):
    """The phases."""

    @property
    def in_flight(self) -> int:
        """Chunks queued at a time: enough for every thread, few enough for the memory."""
        return 2 * self.settings.thread_count + 2

    def updates(self) -> Iterator[Update]:
        """All phases."""
        message = "pilot pass" if has_compiled() else COMPILING
        try:
            yield self.update("setup", "building the scene")
            prepared = yield from self.watch(
                self.queue.submit(self.kept.prepare, self.scene, self.settings, self.stop),
                "building the scene",
            )
            piloted = yield from pilot(self, prepared, message)
            prepared, source, afforded, radii, walks, ready = piloted
            traced = isinstance(source, TracedPhotons)
            discs = DiscSize(traced and sizes_discs(self.settings))
            self._afford(afforded, traced)
            source = self.kept.photons(source, self.settings)
            self.kept.leave(self.memory.expect(afforded.stored, radii))
            self.plan = radii.expected.with_stage(self.plan) if radii.expected else self.plan
            if not ready:
                known = (self.settings, self.plan, self.region, radii, source)
                yield from self.watch(self.queue.submit(warm_up, prepared, *known), message)
                set_compiled()
            self.compiling = False
            self.render_begin = time.perf_counter()
            if wants_guide(self.settings, self.plan, self.region):
                asked = (prepared, self.settings, self.region, radii, source)
                self.lesson = partial(guided, *asked)
            if walks:
                looked = balance(self, prepared, radii, source.batches, walks, traced)
                radii, other = yield from looked
                source = other or source
            sides = sides_of(self.scene, self.settings, prepared, source)
            yield from self._passes(sides, radii, discs)
            yield self.update("done", "")
        finally:
            self.stop.set()
            # A kernel that is being compiled cannot be interrupted: its thread then ends by
            # itself before the next one. Everything else is joined here.
            self.queue.close(wait=not self.compiling)

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

    def _passes(
        self, sides: list[Side], radii: Radii, discs: DiscSize
    ) -> Generator[Update, None, None]:
        """Passes until a limit is met; photons are traced up to two passes ahead.

        So there is always work in the queue while a map is sorted, and no thread idles at
        the end of a phase. A guide is learnt beside the first passes' photons.
        """
        ahead = self.memory.ahead
        maps: deque[Future[list[PhotonMaps]]] = deque()
        begun: CameraPass | None = None

        def launch(end: int) -> None:
            traced = i + len(maps) + (begun is not None)
            for k in range(traced, min(end, self.settings.passes)):
                sized = radii.with_caustics(discs.factor(k))
                maps.append(self.queue.photons(self.settings, sized, sides, k))

        def begin(k: int) -> CameraPass:
            current = maps.popleft().result()
            pixels = self.density.pixels(k, self.film)
            parts = self.queue.chunks(self.settings, self.region, sides, current, pixels)
            return CameraPass(k, current, parts)

        def follow(k: int) -> CameraPass | None:
            """Pass ``k`` while the one before is under way, if nothing else is missing."""
            known = k < self.settings.passes and not self.density.looks(k)
            return begin(k) if known and maps and maps[0].done() else None

        for i in range(self.settings.passes):
            if self.lesson is not None:
                # What it is learnt from has the memory of one of the passes ahead.
                launch(i + ahead - 1)
                guide, stage = yield from self.run(self.lesson(), LEARNING, "render")
                sides = [side.guided(guide) for side in sides]
                self.plan = self.plan._replace(stages=(*self.plan.stages, stage))
                self.lesson = None
            discs.look(i, self.film)
            launch(i + ahead)
            if begun is None:
                yield from self.watch(maps[0], "", "render")
                begun = begin(i)
            self._count(begun.maps)
            begun.queue(self.queue, self.in_flight)
            launch(i + 1 + ahead)
            begun = yield from self._camera_pass(begun, follow)
            if self._out_of_time() or self._good_enough():
                return

    def _camera_pass(
        self, now: CameraPass, follow: Callable[[int], CameraPass | None]
    ) -> Generator[Update, None, CameraPass | None]:
        """Add the chunks of a pass to the film in their order, and ``follow`` with the next.

        Ends early when the time is up.
        """
        then: CameraPass | None = None
        while now.chunks and not self._out_of_time():
            now.queue(self.queue, self.in_flight)
            if not now.waiting:
                then = then or follow(now.number + 1)
                if then:
                    then.queue(self.queue, self.in_flight - len(now.chunks))
            while not wait([now.chunks[0]], timeout=SILENCE).done:
                yield self.update("render", "")
            self._add(now.number, now.chunks.popleft().result())
            if not now.chunks and not now.waiting:
                self.film.end_pass()
            if time.perf_counter() - self.told >= SILENCE:
                yield self.update("render", "")
        return then

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

    def _good_enough(self) -> bool:
        """Whether the error asked for is met."""
        goal = self.settings.error_goal
        return goal > 0.0 and self.stated().relative_error <= goal
