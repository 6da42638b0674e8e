"""The pilot that learns where indirect light comes from (``camera_pass.guide``).

Photons that have landed around a place tell of all light there. What a gather ray is to find is
less: without the light that lamps send straight and what caustic photons bring. So gather rays
themselves are asked, which end in a photon map of the pilot's own: first as the BSDF sends
them, then guided by what those have brought, which also tells how much that helps.
"""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera_pass.chunk import PhotonMaps, follow, send_gather, trace_camera, wide_only
from .camera_pass.guide import Guide, copy_places, find_sides, no_guide, note_rays
from .camera_pass.indirect import gather_indirect, gather_order
from .camera_pass.next_event import light_directly
from .camera_pass.pixels import Pixels, Region
from .camera_pass.rays import Lit, Rays
from .camera_pass.records import VERTEX
from .film.film import SAMPLE
from .guide_zones import Learnt, Zones, find_zones
from .photon_pass import PhotonSource, photon_maps
from .photons.sight import SIGHT
from .pilot import PILOT_PASS, Radii
from .plan import Plan, Stage
from .prepared import Prepared
from .settings import USUAL_GATHER_RAYS, Settings
from .steps import Steps

#: Pass of the pilot's random numbers; no real pass reaches it.
GUIDE_PASS = PILOT_PASS + 3
#: Pixels looked at, at most.
PIXELS = 4096
#: Gather rays that leave a place together, which hangs the share of direct light on them.
TOGETHER = 2
#: So many times by the BSDF, then guided to see whether that pays, and if so at most.
PLAIN, PROBE, MOST = 2, 2, 6
#: Parts that the places are asked in, side by side.
PARTS = 4
#: Share of a render's gather rays that may go into learning.
EFFORT = 0.125
#: The probe must have less than this part of the variance that the others have: rooms with more
#: of it left have gained in variance what they lost in time.
PAYS = 0.66
#: Gather rays must bring this part of a pass's noise, before anything is learnt: where they
#: brought 0.2 to 0.3 of it, renders with a guide took as long.
SHARE = 0.4


class Brought(NamedTuple):
    """What gather rays brought, one row each.

    ``owner`` (n,): its place; ``light`` (n, 3): what the place would send to the camera if all
    rays were like it; ``zone``, ``bins``, ``ratio``: see ``note_rays``.
    """

    owner: NDArray[np.int32]
    light: NDArray[np.float64]
    zone: NDArray[np.int32]
    bins: NDArray[np.int32]
    ratio: NDArray[np.float64]


def times_to_learn(settings: Settings, region: Region) -> int:
    """How often a place sends guided rays in the pilot, 0 when that would take too long."""
    pixels = region.width * region.height
    rays = USUAL_GATHER_RAYS if settings.gather_rays < 0 else settings.gather_rays
    budget = EFFORT * settings.passes * rays * pixels / min(PIXELS, pixels)
    found = min(MOST, int(budget / TOGETHER) - PLAIN)
    return found if found >= PROBE else 0


def wants_guide(settings: Settings, plan: Plan, region: Region) -> bool:
    """Whether to look where indirect light comes from."""
    asked = settings.guide and not settings.draft and plan.is_on("indirect")
    return asked and times_to_learn(settings, region) > 0


def pilot_maps(settings: Settings, radii: Radii, source: PhotonSource) -> PhotonMaps:
    """Global photons of a pass of their own."""
    batches = [batch for batch in source.batches if not batch.caustic]
    walks = [source.walk(GUIDE_PASS, batch) for batch in batches]
    return photon_maps(settings, radii, 0, batches, walks)


class Seen(NamedTuple):
    """Places that the camera sees: ``ends``, light (n,) of their pixels, and their zones."""

    ends: Lit
    samples: NDArray[np.void]
    zones: Zones


def learn_guide(
    prepared: Prepared,
    settings: Settings,
    region: Region,
    maps: PhotonMaps,
    most_pixels: int = PIXELS,
) -> Steps[tuple[Guide, float]]:
    """The guide for what the camera sees, and the part of the variance that it leaves.

    That part is measured with guided rays before they teach as well.
    """
    bare = replace(
        settings, gather_rays=TOGETHER, light_samples=1, light_kinds=False, first_hit=()
    )
    (seen,) = yield [(see_places, prepared, bare, region, most_pixels)]
    zones = seen.zones
    if maps.global_ is None or not zones.guide.zones:
        return no_guide(), 1.0
    own = prepared._replace(guide=zones.guide)
    plain = yield from _ask(own, bare, seen.ends, PLAIN, GUIDE_PASS, maps)
    weight = _weights(seen.samples, seen.ends.vertices, plain, zones.guide.zones)
    learnt = Learnt(zones)
    learnt.add(plain.zone, plain.bins, _squares(plain, weight))
    left = 1.0
    times = times_to_learn(settings, region)
    for i, number in enumerate((PROBE, times - PROBE)):
        if number > 0 and (i == 0 or left <= PAYS):
            own = prepared._replace(guide=learnt.guide())
            guided = yield from _ask(own, bare, seen.ends, number, GUIDE_PASS + 1 + i, maps)
            left = left_of_variance(guided.owner, guided.light, guided.ratio, weight)
            learnt.add(guided.zone, guided.bins, _squares(guided, weight))
    return learnt.guide(), left


def see_places(
    prepared: Prepared, settings: Settings, region: Region, most_pixels: int
) -> Seen:
    """What ``most_pixels`` at most of ``region`` see."""
    total = region.width * region.height
    stride = max(1, total // most_pixels)
    pixels = Pixels.spread(GUIDE_PASS, total // stride, stride=stride)
    samples = np.zeros(pixels.paths, SAMPLE)
    rays = Rays(prepared, pixels.paths)
    ends = wide_only(trace_camera(prepared, settings, region, pixels, rays, samples))
    light_directly(prepared, settings, ends, None, samples, None)
    # Other threads will read them, and this one's room is for others then.
    ends = Lit(ends.vertices.copy(), ends.lobes.copy())
    side = np.zeros(len(ends.vertices), np.int32)
    find_sides(ends.vertices, ends.lobes, side)
    return Seen(ends, samples, find_zones(ends.vertices["p"], side))


def _ask(
    prepared: Prepared, settings: Settings, ends: Lit, times: int, i: int, maps: PhotonMaps
) -> Steps[Brought]:
    """``_send`` from ``PARTS`` parts of ``ends``."""
    cuts = np.linspace(0, len(ends.vertices), PARTS + 1).astype(int)
    found: list[Brought] = yield [
        (_send, prepared, settings, Lit(ends.vertices[a:b], ends.lobes), times, i, maps)
        for a, b in itertools.pairwise(cuts)
    ]
    for start, brought in zip(cuts[:-1], found, strict=True):
        brought.owner[:] += start
    return Brought(*(np.concatenate(columns) for columns in zip(*found, strict=True)))


def _send(
    prepared: Prepared, settings: Settings, ends: Lit, times: int, i: int, maps: PhotonMaps
) -> Brought:
    """``TOGETHER`` gather rays from ``ends``, ``times`` times, and what each brings."""
    assert maps.global_ is not None
    copies = np.empty(len(ends.vertices) * times, VERTEX)
    copy_places(ends.vertices, times, i, copies)
    many = Lit(copies, ends.lobes)
    rays = Rays(prepared, len(copies) * TOGETHER)
    count = send_gather(prepared, settings, many, rays)
    paths = rays.paths[:count]
    owner = paths["slot"] // times
    directions = paths["direction"].copy()
    zone, bins = np.zeros((2, count), np.int32)
    ratio = np.zeros(count)
    note_rays(prepared.guide, ends.vertices, ends.lobes, owner, directions, zone, bins, ratio)
    paths["slot"] = np.arange(count)
    rows = np.zeros(count, SAMPLE)
    far = follow(prepared, settings, rays, count, True, rows)
    none = np.zeros(len(far.vertices), np.bool_)
    gather_indirect(
        far.lobes, maps.global_, maps.global_borders, maps.global_radius, far.vertices,
        gather_order(maps.global_, far.vertices, none), rows, np.zeros(SIGHT), maps.patches,
    )  # fmt: skip
    wanted = TOGETHER * ends.vertices["portion"]
    light = (rows["direct"] + rows["indirect"]) * wanted[owner, None]
    return Brought(owner, light, zone, bins, ratio)


def _weights(
    samples: NDArray[np.void], places: NDArray[np.void], brought: Brought, zones: int
) -> NDArray[np.float64]:
    """What the variance of each place counts (P, 3): by ``relative_error``, and by its rays.

    Indirect light is the mean of the zone's: that of a few rays would give weight to places
    that look dark by chance.
    """
    light = _mean_of(brought.owner, brought.light, len(places))
    at = np.full(len(places), -1)
    at[brought.owner] = brought.zone
    known = at >= 0
    light[known] = _mean_of(at[known], light[known], zones)[at[known]]
    slots = places["slot"]
    seen = samples["emission"] + samples["direct"]
    for c in range(3):
        seen[:, c] += np.bincount(slots, light[:, c], minlength=len(seen))
    weight = 1.0 / (seen**2 + 0.01 * np.mean(seen) ** 2 + 1e-300)
    return np.asarray(weight[slots] / places["portion"][:, None])


def _mean_of(
    owner: NDArray[np.integer[Any]], light: NDArray[np.float64], count: int
) -> NDArray[np.float64]:
    """Mean (count, 3) of the ``light`` (n, 3) of each owner."""
    number = np.maximum(np.bincount(owner, minlength=count), 1)
    sums = [np.bincount(owner, light[:, c], minlength=count) for c in range(3)]
    return np.stack(sums, axis=1) / number[:, None]


def _squares(brought: Brought, weight: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weighted square (n,) of what each ray would bring if the BSDF had sent it."""
    light = brought.light * brought.ratio[:, None]
    return np.asarray((weight[brought.owner] * light**2).mean(axis=1))


def left_of_variance(
    owner: NDArray[np.int32],
    light: NDArray[np.float64],
    ratio: NDArray[np.float64],
    weight: NDArray[np.float64],
) -> float:
    """Variance of guided rays over that of others, both from the guided ones.

    ``light`` (n, 3) of the rays of places ``owner`` (n,), ``ratio`` (n,) times as dense as
    others would be, ``weight`` (P, 3). A ray stands for ``ratio`` others that would bring
    ``ratio`` times as much less. The squared mean is that of products of different rays.
    """
    count = len(weight)
    number = np.bincount(owner, minlength=count)
    several = number > 1
    square = (weight[owner] * light**2).mean(axis=1)
    sums = _mean_of(owner, light, count) * number[:, None]
    own = np.bincount(owner, square, minlength=count)
    pairs = ((weight * sums**2).mean(axis=1) - own)[several]
    pairs = pairs / (number * (number - 1.0))[several]
    each = 1.0 / np.maximum(number, 1)
    guided = float((own * each)[several].sum())
    plain = float((np.bincount(owner, square * ratio, minlength=count) * each)[several].sum())
    mean = float(pairs.sum())
    if not plain - mean > 0.0:
        return 1.0
    return max(0.0, (guided - mean) / (plain - mean))


def guided(
    prepared: Prepared,
    settings: Settings,
    region: Region,
    radii: Radii,
    source: PhotonSource,
    maps: PhotonMaps | None = None,
) -> Steps[tuple[Guide, Stage]]:
    """A guide if that pays, else none, and the plan's line that says so.

    ``maps``: global photons to learn from, that no picture shows; without, a pass of its own.
    """
    if maps is None:
        (maps,) = yield [(pilot_maps, settings, radii, source)]
    guide, left = yield from learn_guide(prepared, settings, region, maps)
    share = f"{100.0 * left:.0f} % of the variance of gather rays is left"
    if left > PAYS:
        return no_guide(), Stage("guide", False, f"{share}, that would not pay")
    return guide, Stage("guide", True, f"{guide.zones} zones; {share}")


def unguided(share: float) -> Stage:
    """The plan's line where gather rays bring too small a ``share`` of the noise."""
    reason = f"gather rays bring {100.0 * share:.0f} % of the noise: learning would not pay"
    return Stage("guide", False, reason)
