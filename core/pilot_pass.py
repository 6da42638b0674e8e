"""The pilot's parts before the first pass, which may run side by side, and what they tell.

One finds how large discs must be and where surfaces end, another sends caustic photons to see
where they crowd and which the camera sees, a third the shadow photons.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from .camera_pass.connections import connect
from .camera_pass.light_image import Expected, around, expected_from, no_connections, why_not
from .camera_pass.pixels import Region
from .photon_pass import Batch, PhotonSource, trace_batch
from .photons.photon_map import build_photon_map
from .photons.shadow import ShadowMap, shadow_map
from .photons.trace import Walk
from .pilot import (
    CROWD,
    DRAFT_CROWD,
    NOTHING,
    PILOT_PASS,
    PilotLook,
    Radii,
    first_radii,
    look_for_radii,
    no_radii,
)
from .prepared import Prepared
from .settings import Settings


class CrowdLook(NamedTuple):
    """``walk``: ``number`` caustic photons of the pilot; ``expected``: what is seen at once."""

    walk: Walk
    number: int
    expected: Expected


def parts_of_pilot(
    prepared: Prepared,
    settings: Settings,
    region: Region,
    source: PhotonSource,
    look: PilotLook,
    traced: dict[Batch, Walk],
) -> list[tuple[Any, ...]]:
    """Functions and their arguments; ``pilot_of`` takes what they return.

    Without photons nothing is asked for radii, and nothing is traced. ``traced``: batches of
    the pilot that are known already.
    """
    return [
        (_sizes, prepared, settings, source, look),
        (_crowd, prepared, settings, region, source, traced),
        (_shadows, prepared, settings),
    ]


def pilot_of(sizes: Radii, crowd: CrowdLook | None, shadows: ShadowMap | None) -> Radii:
    """What the parts have found."""
    if crowd is not None:
        sizes = sizes._replace(
            crowd=build_photon_map([crowd.walk], sizes.caustic[3]),
            crowd_photons=crowd.number,
            expected=crowd.expected,
        )
    return sizes._replace(shadows=shadows)


def pilot_radii(
    prepared: Prepared, settings: Settings, region: Region, source: PhotonSource
) -> Radii:
    """Radii of pass 0, and shadow photons when there shall be some: one part after another."""
    look = look_for_radii(prepared, settings, region) if source.batches else NOTHING
    parts = parts_of_pilot(prepared, settings, region, source, look, {})
    return pilot_of(*(work(*arguments) for work, *arguments in parts))


def _sizes(
    prepared: Prepared, settings: Settings, source: PhotonSource, look: PilotLook
) -> Radii:
    if not source.batches:
        return no_radii()
    caustics = any(batch.caustic for batch in source.batches)
    return first_radii(prepared, settings, look, source.pilot(), caustics)


def _crowd(
    prepared: Prepared,
    settings: Settings,
    region: Region,
    source: PhotonSource,
    traced: dict[Batch, Walk],
) -> CrowdLook | None:
    if not any(batch.caustic for batch in source.batches):
        return None
    # Traced even where the others are baked: they shall be others. With the seed of these, so
    # that discs are as large in all frames of a flight.
    number = DRAFT_CROWD if settings.draft else CROWD
    chosen = replace(settings, seed=source.seed)
    batch = Batch(True, 0, number, number)
    walk = traced.get(batch) if chosen.seed == settings.seed else None
    walk = walk or trace_batch(prepared, chosen, PILOT_PASS, batch)
    expected = _expected(prepared, chosen, region, walk)
    return CrowdLook(walk, number, expected._replace(passes=source.passes))


def _shadows(prepared: Prepared, settings: Settings) -> ShadowMap | None:
    return shadow_map(prepared, settings) if settings.shadow_photons else None


def _expected(prepared: Prepared, settings: Settings, region: Region, walk: Walk) -> Expected:
    """What connections of the pilot's photons, ``walk``, tell."""
    pixels = region.width * region.height
    reason = why_not(settings, pixels, 1 + len(settings.light_groups))
    if reason:
        return no_connections(region, reason)
    x0, y0, width, height = around(region)
    every = np.ones((height, width), np.uint8)
    found = connect(prepared, settings, (x0, y0), every, PILOT_PASS, walk)
    return expected_from(found, region, prepared.camera.filter_table)
