"""What a render finds out before its first pass: the pilot, and the balance of a pass.

Parts that need nothing of each other run side by side on the threads.
"""

from __future__ import annotations

from collections.abc import Generator
from concurrent.futures import Future
from functools import partial
from itertools import chain
from typing import NamedTuple

from .ahead import get_ready
from .aim_pass import aimed, wants_aim
from .baking.bake import photon_source
from .balance import balanced, gather_share, is_free, stage_of
from .guide_pass import SHARE, unguided
from .look import PASSES, caustics_by_paths, look_from, parts_of_look
from .photon_memory import Afforded, Stored, affordable, emitted, stored_in
from .photon_pass import Batch, PhotonSource, TracedPhotons, photon_batches, photon_maps
from .photons.trace import Walk
from .pilot import NOTHING, Radii, look_for_radii
from .pilot_pass import parts_of_pilot, pilot_of
from .prepared import Prepared
from .render_state import RenderState
from .update import Update


class Piloted(NamedTuple):
    """What is known before the first pass.

    ``walks``: photons of whole passes under way for the balance, by pass and batch; none where
    there is nothing to decide. ``ready``: whether all kernels are loaded.
    """

    prepared: Prepared
    source: PhotonSource
    afforded: Afforded
    radii: Radii
    walks: list[list[Future[Walk]]]
    ready: bool


def pilot(
    render: RenderState, prepared: Prepared, message: str
) -> Generator[Update, None, Piloted]:
    """Where photons come from, and what the pilot tells."""
    submit, settings, region = render.queue.submit, render.settings, render.region
    getting_ready = submit(get_ready, prepared, settings, render.plan, region)
    photons = render.plan.is_on("caustics") or render.plan.is_on("indirect")
    looking = submit(look_for_radii, prepared, settings, region) if photons else None
    focused = render.kept.focused(prepared, settings, render.plan)
    prepared, render.plan, traced = yield from render.run(focused, message)
    look = (yield from render.watch(looking, message)) if looking else NOTHING
    learns = wants_aim(settings, render.plan, region)
    while True:
        source, afforded = yield from render.watch(
            submit(_photons, render, prepared),
            "photon maps" if settings.photon_maps else message,
        )
        if isinstance(source, TracedPhotons):
            source.piloted = traced
        kept = render.kept.photons(source, settings)
        asked = (prepared, settings, region, kept, look, traced)
        parts = [submit(*part) for part in parts_of_pilot(*asked)]
        walks = _look_for_balance(render, source)
        sizes, crowd, shadows = yield from render.watch_all(parts, message)
        if learns and crowd is not None:
            before, learns = prepared, False
            aiming = submit(aimed, prepared, settings, render.plan, look.views, crowd)
            prepared, render.plan = yield from render.watch(aiming, message)
            if prepared is not before:
                traced = {}
                # Photons for one view serve no other, and those so far were not these.
                yield from render.watch_all(chain.from_iterable(walks), message)
                render.kept.leave(0)
                continue
        ready = yield from render.watch(getting_ready, message)
        radii = pilot_of(sizes, crowd, shadows)
        return Piloted(prepared, source, afforded, radii, walks, ready)


def _photons(render: RenderState, prepared: Prepared) -> tuple[PhotonSource, Afforded]:
    pixels = render.region.width * render.region.height
    afforded = affordable(prepared, render.settings, render.plan, pixels)
    asked = (render.scene, render.settings, render.plan, prepared, afforded)
    source, render.plan, afforded = photon_source(*asked)
    return source, afforded


def _look_for_balance(render: RenderState, source: PhotonSource) -> list[list[Future[Walk]]]:
    if not is_free(render.settings) or not source.batches:
        return []
    kept, submit = render.kept.photons(source, render.settings), render.queue.submit
    return [[submit(kept.walk, i, batch) for batch in source.batches] for i in PASSES]


def balance(
    render: RenderState,
    prepared: Prepared,
    radii: Radii,
    batches: list[Batch],
    walks: list[list[Future[Walk]]],
    traced: bool,
) -> Generator[Update, None, tuple[Radii, PhotonSource | None]]:
    """Decide what is automatic; ``traced``: whether other photons can be asked for.

    Returns the radii and, if so, where these photons come from.
    """
    asked = "looking where noise comes from"
    before, region = render.settings, render.region
    found: list[Walk] = []
    sorting = []
    while walks:
        found = yield from render.watch_all(walks.pop(0), asked)
        sorting.append(render.queue.submit(photon_maps, before, radii, 0, batches, found))
    maps = yield from render.watch_all(sorting, asked)
    parts = [
        render.queue.submit(*part) for part in parts_of_look(prepared, before, region, maps)
    ]
    seen = look_from((yield from render.watch_all(parts, asked)), batches, found)
    render.density.caustics = caustics_by_paths(seen)
    stored = stored_in(batches, found)
    fits = render.memory.fits_with(stored)
    chosen = render.settings = balanced(before, seen, region, traced, fits)
    render.plan = render.plan._replace(stages=(*render.plan.stages, stage_of(chosen)))
    if render.lesson is not None:
        share = gather_share(seen, chosen)
        if share >= SHARE:
            alone = maps[0]._replace(caustic=None, focus=None, counted=None)
            render.lesson = partial(render.lesson, alone)
        else:
            render.lesson = None
            render.plan = render.plan._replace(stages=(*render.plan.stages, unguided(share)))
    radii = radii.with_caustics(chosen.caustic_radius / before.caustic_radius)
    if not traced:
        return radii, None
    more = photon_batches(render.plan, chosen, region.width * region.height)
    source = render.kept.photons(TracedPhotons(prepared, chosen, more), chosen)
    factor = emitted(more)[0] / max(1, emitted(batches)[0])
    stored = Stored(factor * stored.caustic, stored.global_)
    render.kept.leave(render.memory.expect(stored, radii))
    return radii, source
