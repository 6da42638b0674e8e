"""The balance of a pass: how its time is shared out to light samples, gather rays, photons.

What makes an image noisy differs from scene to scene (``look``). The numbers are chosen for the
least noise times time (the optimal allocation of stratified sampling: Neyman 1934; for paths
Bolin & Meyer 1997). Time is counted in rays and photons, not by a clock: so each render of a
scene takes the same decision.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

from .camera_pass.pixels import Region
from .look import Look, Noise
from .plan import Stage
from .settings import AUTOMATIC, Settings

#: What is tried.
GATHER_RAYS = (1, 2, 4, 8, 16)
LIGHT_SAMPLES = (1, 2, 4)
PHOTON_FACTORS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
#: Microseconds on one core of the machine that this was measured on; their ratios count: a
#: camera ray with the surface that it meets, a point of a light with its shadow ray, a gather
#: ray with the photons at its end, a photon's ray, a photon stored, sorted and found. Fitted to
#: 55 passes of the benchmark's scenes; photons count by less than half of what they take, as
#: their discs are smaller if there are more, and no noise tells of that bias.
RAY, LIGHT, GATHER, PHOTON_RAY, STORED = 0.57, 0.2, 0.58, 0.35, 0.25
#: Noise of the camera's samples falls faster than with the number of passes (Sobol points),
#: so that less of it is left after some passes than a single one shows.
CAMERA_LEFT = 0.6


class Cost(NamedTuple):
    """Microseconds of a pass.

    ``camera``: its camera paths and global photons; ``light``: a light sample for each path;
    ``gather``: one gather ray for each path; ``photons``: as many caustic photons as it was
    measured with.
    """

    camera: float
    light: float
    gather: float
    photons: float


class Balance(NamedTuple):
    """The decision: light samples and gather rays a place, a factor for caustic photons."""

    light_samples: int
    gather_rays: int
    photon_factor: float


def is_free(settings: Settings) -> bool:
    """Whether there is anything to decide."""
    return settings.gather_rays == AUTOMATIC


def cost_of(seen: Look, region: Region) -> Cost:
    """By the rays and photons of ``seen``."""
    pixels = region.width * region.height
    each = pixels / seen.first.pixels.paths
    gathered = seen.first.gathered * each
    lit = seen.direct.samples * each
    seeing = seen.first.rays * each - gathered - lit
    photons = {True: 0.0, False: 0.0}
    for batch, walk in zip(seen.batches, seen.walks, strict=True):
        photons[batch.caustic] += walk.rays * PHOTON_RAY + len(walk.photons) * STORED
    return Cost(
        camera=seeing * RAY + photons[False],
        light=lit * LIGHT,
        gather=gathered * GATHER,
        photons=photons[True],
    )


def least_error(
    noise: Noise,
    cost: Cost,
    photon_factors: Sequence[float],
    light_samples: Sequence[int] = LIGHT_SAMPLES,
) -> Balance:
    """What has the least product of noise and time."""

    def product(balance: Balance) -> float:
        lights, rays, factor = balance
        left = (noise.camera + noise.light / lights) * CAMERA_LEFT
        left += noise.gather / rays + noise.photons / factor
        time = cost.camera + cost.light * lights + cost.gather * rays + cost.photons * factor
        return left * time

    return min(
        (Balance(*n) for n in itertools.product(light_samples, GATHER_RAYS, photon_factors)),
        key=product,
    )


def balanced(
    settings: Settings,
    seen: Look,
    region: Region,
    traced: bool,
    fits: Callable[[float], bool] = lambda factor: True,
) -> Settings:
    """``settings`` with the numbers that ``seen`` asks for in place of automatic ones.

    ``traced``: whether the number of photons is free, as it is not with baked maps; ``fits``:
    whether there is memory for so many times the caustic photons. With
    more photons the discs of caustics are smaller by the sixth root: their bias, which goes
    with the fourth power of the radius, falls as fast as the noise (Silverman 1986, 4.3).
    """
    free = traced and settings.photons_caustic == AUTOMATIC
    free = free and any(batch.caustic for batch in seen.batches)
    factors = [f for f in PHOTON_FACTORS if f <= 1.0 or fits(f)] if free else [1.0]
    samples: Sequence[int] = LIGHT_SAMPLES
    if settings.light_samples != AUTOMATIC:
        samples = (settings.light_samples,)
    found = least_error(seen.noise, cost_of(seen, region), factors, samples)
    settings = replace(
        settings, gather_rays=found.gather_rays, light_samples=found.light_samples
    )
    if not free:
        return settings
    usual = settings.photon_count(AUTOMATIC, region.width * region.height)
    return replace(
        settings,
        photons_caustic=int(usual * found.photon_factor),
        caustic_radius=settings.caustic_radius * min(1.0, found.photon_factor ** (-1 / 6)),
    )


def gather_share(seen: Look, settings: Settings) -> float:
    """The part of a pass's noise, 0 to 1, that gather rays bring by ``balanced`` settings."""
    noise = seen.noise
    usual = sum(batch.count for batch in seen.batches if batch.caustic)
    factor = settings.photons_caustic / usual if usual and settings.photons_caustic > 0 else 1.0
    gather = noise.gather / settings.gather_rays
    others = CAMERA_LEFT * (noise.camera + noise.light / settings.light_samples)
    whole = gather + others + noise.photons / factor
    return gather / whole if whole > 0.0 else 0.0


def stage_of(settings: Settings) -> Stage:
    """The line of the plan that tells the decision."""
    caustic = ""
    if settings.photons_caustic > 0:
        caustic = f", {settings.photons_caustic} caustic photons"
    return Stage(
        "balance",
        True,
        f"{settings.light_samples} light samples, {settings.gather_rays} gather rays{caustic} "
        "for the least noise",
    )
