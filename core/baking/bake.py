"""Traces the photons of many passes into a file, and takes them from there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..focus_pass import focus_of, wants_focus
from ..photon_memory import Afforded, Budget, Stored, emitted
from ..photon_pass import Batch, PhotonSource, TracedPhotons, photon_batches
from ..photons.trace import PHOTON, Walk
from ..plan import Plan, Stage
from ..prepared import Prepared, prepare
from ..sampling.rng import REPLICATES
from ..scene.scene import Scene
from ..settings import AUTOMATIC, Settings
from ..steps import run
from .fingerprint import TRACING_VERSION, changes, fingerprint
from .maps_file import MOST_KEPT, BakeError, BakeHeader, MapsFile, write_maps

#: Passes of a bake that nobody has chosen.
DEFAULT_PASSES = 64
#: Changes that a message names one by one.
_NAMED = 4


def whole_passes(passes: int) -> int:
    """``passes`` rounded up so that each replicate of the film has as many.

    Pass ``i`` beyond those baked then meets its own replicate's photons again, and the
    scatter between the replicates goes on telling how noisy the photons are.
    """
    return max(1, -(-passes // REPLICATES)) * REPLICATES


def bake(
    scene: Scene,
    settings: Settings,
    path: Path,
    passes: int = DEFAULT_PASSES,
    on_pass: Callable[[int], None] = lambda done: None,
) -> BakeHeader:
    """Write the photons of ``whole_passes(passes)`` passes of ``scene`` to ``path``.

    ``on_pass`` hears how many are done. Raises ``SceneError`` or ``OSError``; the file
    appears whole or not at all.
    """
    prepared = prepare(scene, settings)
    camera = scene.camera
    assert camera is not None  # prepare has looked
    plan = Plan.of(scene, settings)
    if wants_focus(settings, plan):
        found = run(focus_of(prepared, settings, plan.is_on("caustics")))
        prepared = prepared._replace(focus=found.focus)
    batches = photon_batches(plan, settings, camera.width * camera.height)
    source = TracedPhotons(prepared, settings, batches)
    return write_bake(scene, settings, prepared, source, path, passes, on_pass)


def write_bake(
    scene: Scene,
    settings: Settings,
    prepared: Prepared,
    source: TracedPhotons,
    path: Path,
    passes: int,
    on_pass: Callable[[int], None] = lambda done: None,
) -> BakeHeader:
    """As ``bake``, of a scene that is prepared."""
    header = BakeHeader(
        passes=whole_passes(passes),
        seed=settings.seed,
        emitted=emitted(source.batches),
        tracing_version=TRACING_VERSION,
        fingerprint=fingerprint(scene, settings),
        origin=tuple(float(x) for x in prepared.centre.origin),  # type: ignore[arg-type]
        scene=scene.name,
    )
    with ThreadPoolExecutor(settings.thread_count, "photon_map_bake") as pool:

        def all_passes() -> Iterator[tuple[NDArray[np.void], NDArray[np.void]]]:
            ahead = [pool.submit(_in_order, source, 0)] if header.passes else []
            for i in range(header.passes):
                if i + 1 < header.passes:
                    # One pass is traced while the one before it is written.
                    ahead.append(pool.submit(_in_order, source, i + 1))
                yield ahead.pop(0).result()
                on_pass(i + 1)

        return write_maps(path, header, source.pilot(), all_passes())


def _in_order(source: PhotonSource, i: int) -> tuple[NDArray[np.void], NDArray[np.void]]:
    """The (caustic, global) photons of pass ``i`` in the order of their paths."""
    walks = [source.walk(i, batch) for batch in source.batches]
    maps = []
    for caustic in (True, False):
        own = [w for b, w in zip(source.batches, walks, strict=True) if b.caustic == caustic]
        photons = np.concatenate([w.photons for w in own]) if own else np.zeros(0, PHOTON)
        order = np.concatenate([w.order for w in own]) if own else np.zeros(0, np.int64)
        maps.append(photons[np.argsort(order, kind="stable")])
    return maps[0], maps[1]


class BakedPhotons:
    """The photons of a file in place of traced ones; see ``photon_pass.PhotonSource``.

    What they are of crowded places was settled when they were baked.
    """

    focused = learnt = False

    def __init__(self, file: MapsFile, plan: Plan) -> None:
        self._file = file
        self.seed = file.header.seed
        self.passes = file.header.passes
        emitted = file.header.emitted
        self.batches = [
            Batch(caustic, 0, count, count)
            for caustic, count, stage in (
                (True, emitted[0], "caustics"),
                (False, emitted[1], "indirect"),
            )
            if plan.is_on(stage)
        ]

    def pass_of(self, i: int) -> int:
        """Which of the stored passes stands for pass ``i``."""
        return i % self._file.header.passes

    def walk(self, i: int, batch: Batch) -> Walk:
        """Photons of one kind; no ray was traced for them."""
        photons = self._file.photons(self.pass_of(i))[0 if batch.caustic else 1]
        return Walk(photons, np.arange(len(photons), dtype=np.int64), 0)

    def pilot(self) -> NDArray[np.float64]:
        """Where the pilot's global photons lay."""
        return self._file.pilot.astype(np.float64)


def photon_source(
    scene: Scene, settings: Settings, plan: Plan, prepared: Prepared, afforded: Afforded
) -> tuple[PhotonSource, Plan, Afforded]:
    """Where a render takes its photons from, and the plan with a stage that says so.

    With ``settings.photon_maps`` that fit, from there. Else ``settings.stale_maps`` decides:
    they are traced, or baked again first, or ``BakeError`` is raised. ``afforded``: what a
    pass has when it is traced; what it has in the end is returned.
    """
    traced = TracedPhotons(prepared, settings, afforded.batches)
    if not settings.photon_maps:
        return traced, plan, afforded
    path = Path(settings.photon_maps)
    try:
        return _fitting(path, scene, settings, plan, prepared)
    except BakeError as problem:
        if settings.stale_maps == "REFUSE":
            raise
        if settings.stale_maps == "TRACE":
            warning = f"{problem}; photons are traced instead"
            return traced, _with_stage(plan, False, str(problem), warning), afforded
        warning = f"{problem}; they were baked again"
        wanted = min(DEFAULT_PASSES, settings.passes)
    write_bake(scene, settings, prepared, traced, path, wanted)
    counts = emitted(afforded.batches)
    baked = replace(settings, photons_caustic=counts[0], photons_global=counts[1])
    source, plan, afforded = _fitting(path, scene, baked, plan, prepared)
    return source, plan._replace(warnings=(*plan.warnings, warning)), afforded


def _fitting(
    path: Path, scene: Scene, settings: Settings, plan: Plan, prepared: Prepared
) -> tuple[PhotonSource, Plan, Afforded]:
    limit = settings.photon_memory << 20
    file = MapsFile(path, min(MOST_KEPT, limit // 4))
    found = misfits(file.header, scene, settings, plan, prepared)
    if found:
        rest = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
        raise BakeError(
            f"photon maps '{path}' are of another scene: {', '.join(found[:_NAMED])}{rest}; "
            "bake them again"
        )
    reason = f"{file.header.passes} passes from '{path.name}'"
    stored = Stored(*(float(max(counts)) for counts in zip(*file.header.stored, strict=True)))
    source = BakedPhotons(file, plan)
    warnings: tuple[str, ...] = ()
    if Budget.of(settings, file.kept_bytes).part(stored) < 1.0:
        warnings = (
            f"photon maps '{path.name}' take more than {settings.photon_memory} MB a pass: "
            "bake fewer photons, or raise their memory limit",
        )
    plan = _with_stage(plan, True, reason)
    return source, plan, Afforded(source.batches, stored, warnings)


def misfits(
    header: BakeHeader, scene: Scene, settings: Settings, plan: Plan, prepared: Prepared
) -> list[str]:
    """Why maps of ``header`` are not those of ``scene``, in words."""
    if header.tracing_version != TRACING_VERSION:
        return ["another version of Photon Map made them"]
    found = changes(header.fingerprint, fingerprint(scene, settings))
    for stage, name, stored in (
        ("caustics", "photons_caustic", header.emitted[0]),
        ("indirect", "photons_global", header.emitted[1]),
    ):
        chosen = getattr(settings, name)
        if plan.is_on(stage) and (stored == 0 or chosen not in (AUTOMATIC, stored)):
            found.append(f"{name} was {stored}")
    if not found and tuple(prepared.centre.origin) != header.origin:
        found.append("the origin has moved")
    return found


def _with_stage(plan: Plan, on: bool, reason: str, *warnings: str) -> Plan:
    stages = (*plan.stages, Stage("photon maps", on, reason))
    return plan._replace(stages=stages, warnings=(*plan.warnings, *warnings))
