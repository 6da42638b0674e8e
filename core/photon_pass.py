"""One pass's photons: batches to trace, and their maps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .camera_pass.caustics import FOCUS_DISC
from .camera_pass.chunk import PhotonMaps
from .camera_pass.connections import connect
from .camera_pass.density import DensityMaps
from .camera_pass.light_image import light_image
from .camera_pass.patches import no_patches
from .film.layers import DENSITY_LAYER
from .photons.focus import parted
from .photons.photon_map import build_photon_map
from .photons.radius import GLOBAL_ALPHA, radius_factor
from .photons.rows import CELL
from .photons.trace import Walk, Watcher, trace_photons
from .pilot import PILOT_PASS, Radii
from .plan import Plan
from .prepared import Prepared
from .sampling.rng import PHOTON_CAUSTIC, PHOTON_GLOBAL
from .settings import Settings


@dataclass(frozen=True)
class Batch:
    """A slice of the photon paths of one kind in one pass."""

    caustic: bool
    start: int
    count: int
    total: int


def photon_batches(plan: Plan, settings: Settings, pixels: int) -> list[Batch]:
    """Cut the photons of a pass into batches of at most ``chunk_size`` paths."""
    batches: list[Batch] = []
    for caustic, on, chosen in (
        (True, plan.is_on("caustics"), settings.photons_caustic),
        (False, plan.is_on("indirect"), settings.photons_global),
    ):
        if not on:
            continue
        total = settings.photon_count(chosen, pixels)
        for start in range(0, total, settings.chunk_size):
            batches.append(
                Batch(caustic, start, min(settings.chunk_size, total - start), total)
            )
    return batches


class PhotonSource(Protocol):
    """Where the photons of a render come from: ``batches`` of each pass, walks, a pilot.

    ``focused``: whether they are shared out at crowded places (``photons.focus``); ``seed``
    of their random numbers; ``learnt``: whether they are sent where one camera sees them;
    ``passes`` that have photons of their own.
    """

    batches: list[Batch]
    focused: bool
    learnt: bool
    seed: int
    passes: int

    def walk(self, i: int, batch: Batch) -> Walk:
        """What ``batch`` of pass ``i`` left."""

    def pilot(self) -> NDArray[np.float64]:
        """Positions (P, 3), centred, of the global photons of a pass of its own."""


class TracedPhotons:
    """Photons traced when they are asked for."""

    def __init__(self, prepared: Prepared, settings: Settings, batches: list[Batch]) -> None:
        self._prepared = prepared
        self._settings = settings
        self.batches = batches
        self.focused = prepared.focus.found > 0
        self.learnt = len(prepared.aim.histogram.row) > 0
        self.seed = settings.seed
        self.passes = settings.passes
        #: Batches of ``PILOT_PASS`` that have been traced already.
        self.piloted: dict[Batch, Walk] = {}

    def walk(self, i: int, batch: Batch) -> Walk:
        """Emit and trace one batch of pass ``i``."""
        known = self.piloted.get(batch) if i == PILOT_PASS else None
        return known or trace_batch(self._prepared, self._settings, i, batch)

    def pilot(self) -> NDArray[np.float64]:
        """Traced with random numbers of their own."""
        walks = [self.walk(PILOT_PASS, batch) for batch in self.batches if not batch.caustic]
        positions = [walk.photons["position"].astype(np.float64) for walk in walks]
        return np.concatenate(positions) if positions else np.zeros((0, 3))


def trace_batch(
    prepared: Prepared, settings: Settings, i: int, batch: Batch, watcher: Watcher | None = None
) -> Walk:
    """Emit and trace one batch of pass ``i``; ``watcher`` may look on."""
    light_cdf = prepared.aim.light_cdf if batch.caustic else prepared.lights.photon_cdf
    purpose = PHOTON_CAUSTIC if batch.caustic else PHOTON_GLOBAL
    return trace_photons(
        prepared, prepared.aim.spheres, light_cdf, batch.caustic, settings, purpose, i,
        batch.start, batch.count, batch.total, watcher,
    )  # fmt: skip


def walk_and_connect(
    prepared: Prepared,
    source: PhotonSource,
    settings: Settings,
    radii: Radii,
    i: int,
    batch: Batch,
) -> Walk:
    """What ``batch`` of pass ``i`` left, and what the camera sees of it at once."""
    walk = source.walk(i, batch)
    expected = radii.expected
    if not batch.caustic or expected is None or expected.counts is None:
        return walk
    corner = (expected.region.x0, expected.region.y0)
    found = connect(prepared, settings, corner, expected.wanted, i, walk)
    return walk._replace(seen=found.seen, rays=walk.rays + found.rays)


def photon_maps(
    settings: Settings, radii: Radii, i: int, batches: list[Batch], walks: list[Walk]
) -> PhotonMaps:
    """Sort the walks of pass ``i`` into maps, with the radii of that pass."""
    factor = radius_factor(i, settings.alpha)
    global_radius = radii.global_ * radius_factor(i, max(settings.alpha, GLOBAL_ALPHA))
    caustic = [w for b, w in zip(batches, walks, strict=True) if b.caustic]
    global_ = [w for b, w in zip(batches, walks, strict=True) if not b.caustic]
    footprints, least, most, cell = (factor * r for r in radii.caustic)
    caustic, focused = parted(caustic)
    global_, others = parted(global_)
    focused += others
    caustic_map = build_photon_map(caustic, cell) if caustic else None
    seen = [walk.seen for walk in caustic if walk.seen is not None]
    paths = sum(b.count for b in batches if b.caustic)
    image = None
    if radii.expected is not None and seen:
        image = light_image(radii.expected, seen, i, paths / radii.crowd_photons)
    global_map = build_photon_map(global_, CELL * global_radius) if global_ else None
    counts = DENSITY_LAYER in settings.first_hit
    return PhotonMaps(
        caustic=caustic_map,
        global_=global_map,
        caustic_radii=(footprints, least, most),
        global_radius=global_radius,
        caustic_borders=radii.caustic_borders,
        global_borders=radii.global_borders,
        emitted=sum(b.count for b in batches),
        stored=sum(len(w.photons) for w in walks),
        rays=sum(w.rays for w in walks),
        patches=no_patches(),
        shadows=radii.shadows,
        crowd=radii.crowd_of(paths),
        counted=DensityMaps.of(caustic_map, global_map) if counts else None,
        focus=build_photon_map(focused, FOCUS_DISC * cell) if focused else None,
        focus_radii=(FOCUS_DISC * footprints, FOCUS_DISC * least, FOCUS_DISC * most),
        connected=image,
    )
