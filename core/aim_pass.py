"""The pilot that learns which caustic photons the camera sees (``photons.emission_histogram``).

Photons go wherever the casters send them; those that land out of sight are wasted. A pilot's
photons tell what each part of each light's beam adds to the squares of what is seen, and what
it costs. (That noise counts less where there is much light is left out: so photons would be
rare where light is focused, and discs wide there.)
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera_pass.pixels import Region
from .photon_pass import Batch, trace_batch
from .photons.aim import Aim
from .photons.emission_histogram import BINS, CASTERS, CELLS, find_bins, histogram_of
from .photons.trace import Walk
from .pilot import PILOT_PASS
from .pilot_pass import CrowdLook
from .plan import Plan, Stage
from .prepared import Prepared
from .sampling.distributions import cumulative
from .sampling.rng import PHOTON_CAUSTIC
from .settings import Settings

#: Pass of the pilot's random numbers; no real pass reaches it.
AIM_PASS = PILOT_PASS + 6
#: Photons that teach, and those that see what it brings; a power of two each, so that both
#: are nets of their own.
PHOTONS = 8192
#: Share of a render's caustic photons that may go into learning.
EFFORT = 0.25
#: A light with fewer photons than this is aimed evenly.
LEAST = 256
#: Photons of a bin that count as much as what is known of the bins around it.
BELIEF = 8.0
#: Share of the photons that go on as if nothing had been learnt.
FLOOR = 0.25
#: Time of a photon that lands, counted in those that meet no caster.
LANDING = 3.0
#: Learnt aim must leave less than this part of the variance times time of photons.
PAYS = 0.85
#: The pilot's photons must promise this before others are asked.
PROMISES = 0.95
#: Views in a disc as wide as they lie apart; by more than a pixel, as they are few.
_APART = 5


class Told(NamedTuple):
    """Photon paths (n,): their light, their bin, the square of what they bring, their time."""

    entry: NDArray[np.int32]
    bins: NDArray[np.int32]
    square: NDArray[np.float64]
    time: NDArray[np.float64]

    def part(self, some: slice) -> Told:
        """Some of the paths."""
        return Told(self.entry[some], self.bins[some], self.square[some], self.time[some])


def wants_aim(settings: Settings, plan: Plan, region: Region) -> bool:
    """Whether to look where caustic photons are seen to land."""
    if not settings.learn_aim or settings.draft or settings.photon_maps:
        return False
    count = settings.photon_count(settings.photons_caustic, region.width * region.height)
    return plan.is_on("caustics") and EFFORT * settings.passes * count >= 2 * PHOTONS


def aimed(
    prepared: Prepared,
    settings: Settings,
    plan: Plan,
    views: NDArray[np.float64],
    crowd: CrowdLook,
) -> tuple[Prepared, Plan]:
    """``prepared`` with learnt aim if that pays, and the plan with a line that says so.

    ``views`` (P, 3): where the camera would see a caustic. ``crowd``: the pilot's caustic
    photons; no others are asked unless these promise something.
    """
    told = told_by(prepared, settings, PILOT_PASS, crowd.walk, crowd.number, views)
    left = _left_when_learnt(prepared.aim, told)
    pays = left < PROMISES
    if pays:
        told = ask_photons(prepared, settings, views)
        left = _left_when_learnt(prepared.aim, told)
        pays = left < PAYS
    share = f"{100.0 * left:.0f} % of the variance of caustic photons is left"
    if pays:
        prepared = prepared._replace(aim=learnt(prepared.aim, told))
    else:
        share += ", that would not pay"
    return prepared, plan._replace(stages=(*plan.stages, Stage("photon aim", pays, share)))


def ask_photons(prepared: Prepared, settings: Settings, views: NDArray[np.float64]) -> Told:
    """What the photon paths of a pass of their own bring to places that are seen."""
    count = 2 * PHOTONS
    walk = trace_batch(prepared, settings, AIM_PASS, Batch(True, 0, count, count))
    return told_by(prepared, settings, AIM_PASS, walk, count, views)


def told_by(
    prepared: Prepared,
    settings: Settings,
    i: int,
    walk: Walk,
    count: int,
    views: NDArray[np.float64],
) -> Told:
    """What ``walk``, ``count`` caustic photons of pass ``i``, brings to ``views`` (P, 3)."""
    entry, bins = np.zeros((2, count), np.int32)
    find_bins(prepared.aim.light_cdf, settings.seed, PHOTON_CAUSTIC, i, entry, bins)
    path = walk.order // settings.photon_depth
    photons = walk.photons
    flux = photons["flux"].mean(axis=1).astype(np.float64)
    seen = _seen(photons["position"].astype(np.float64), views)
    adds = np.bincount(path, flux * seen, minlength=count)
    lands = np.bincount(path, minlength=count) > 0
    return Told(entry, bins, np.asarray(adds**2), np.where(lands, LANDING, 1.0))


def _left_when_learnt(aim: Aim, told: Told) -> float:
    """What is left for the second half of the photons when the first has taught."""
    half = len(told.entry) // 2
    return left_of_error(
        aim, learnt(aim, told.part(slice(0, half))), told.part(slice(half, None))
    )


def _seen(places: NDArray[np.float64], views: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of ``places`` (n, 3) lie about where ``views`` (P, 3) do."""
    from scipy.spatial import cKDTree

    k = min(_APART, len(views))
    if k == 0 or len(places) == 0:
        return np.zeros(len(places), np.bool_)
    tree = cKDTree(views)
    gap, nearest = tree.query(places)
    return np.asarray(gap < 2.0 * tree.query(views, k=[k])[0][nearest, 0])


def learnt(aim: Aim, told: Told) -> Aim:
    """``aim`` with densities in proportion to the root of error over time, above a floor.

    That is the least variance times time (Neyman 1934). Few photons lean on more around them.
    """
    count = len(aim.light_cdf)
    before = np.diff(aim.light_cdf, prepend=0.0)
    number = np.bincount(told.entry, minlength=count).astype(np.float64)
    square, time = (
        _mean_of(np.bincount(told.entry, x, minlength=count), number, x.mean())
        for x in (told.square, told.time)
    )
    share = before * np.sqrt(square / time)
    total = share.sum()
    share = FLOOR * before + (1.0 - FLOOR) * (share / total if total > 0.0 else before)
    row = np.full(count, -1, np.int32)
    known = np.flatnonzero(number >= LEAST)
    row[known] = np.arange(len(known))
    density = [_bins_of(told, entry) for entry in known]
    table = np.array(density).reshape(-1, CASTERS, BINS, BINS)
    return aim._replace(light_cdf=cumulative(share), histogram=histogram_of(row, table))


def _mean_of(
    sums: NDArray[Any], number: NDArray[np.float64], around: Any
) -> NDArray[np.float64]:
    """Mean of ``number`` photons with these sums, which lean on the mean around them."""
    return np.asarray((sums + BELIEF * around) / (number + BELIEF))


def _bins_of(told: Told, entry: int) -> NDArray[np.float64]:
    """Density (CASTERS, BINS, BINS) of one light, mean 1.

    A bin leans on 4 x 4 around it, these on all of their caster's, and that on the light's.
    """
    at = told.entry == entry
    bins = told.bins[at]
    sums = [
        np.bincount(bins, x, minlength=CELLS).reshape(CASTERS, BINS // 4, 4, BINS // 4, 4)
        for x in (told.square[at], told.time[at], np.ones(len(bins)))
    ]
    means: list[Any] = [x.sum() / len(bins) for x in sums[:2]]
    for axes in ((1, 2, 3, 4), (2, 4), ()):
        square, time, number = (x.sum(axis=axes, keepdims=True) for x in sums)
        means = [_mean_of(x, number, m) for x, m in zip((square, time), means, strict=True)]
    density = np.sqrt(means[0] / means[1]).reshape(CASTERS, BINS, BINS)
    mean = density.mean()
    if not mean > 0.0:
        return np.ones((CASTERS, BINS, BINS))
    return np.asarray(FLOOR + (1.0 - FLOOR) * density / mean)


def left_of_error(aim: Aim, other: Aim, told: Told) -> float:
    """Mean square times mean time of photons by ``other``, over those of ``aim`` that tell."""
    before, after = (np.diff(a.light_cdf, prepend=0.0) for a in (aim, other))
    ratio = after[told.entry] / before[told.entry]
    row = other.histogram.row[told.entry]
    known = row >= 0
    caster, rest = np.divmod(told.bins, BINS * BINS)
    i, j = np.divmod(rest, BINS)
    at = row[known], caster[known], i[known], j[known]
    parts = [np.diff(table, prepend=0.0, axis=-1) for table in other.histogram[1:]]
    ratio[known] *= CELLS * parts[0][at[:2]] * parts[1][at[:3]] * parts[2][at]
    whole = told.square.mean() * told.time.mean()
    if not whole > 0.0:
        return 1.0
    return float((told.square / ratio).mean() * (told.time * ratio).mean() / whole)
