"""The balance of a pass: how much of its time goes to gather rays and to caustic photons.

What makes an image noisy differs from scene to scene: edges and soft shadows, the directions
of the final gather, or the photons. A few pixels are looked at with independent random numbers
for each of them, and the numbers are chosen for the least noise times time (the optimal
allocation of stratified sampling: Neyman 1934; for paths Bolin & Meyer 1997). Time is counted
in rays and photons, not by a clock: so each render of a scene takes the same decision.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import gcd
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera_pass.chunk import Chunk, PhotonMaps, trace_chunk
from .camera_pass.pixels import Pixels, Region
from .photon_pass import Batch
from .photons.trace import Walk
from .pilot import PILOT_PASS
from .plan import Stage
from .prepared import Prepared
from .settings import AUTOMATIC, Settings

#: Passes whose random numbers are asked; no real pass reaches them.
PASSES = (PILOT_PASS + 1, PILOT_PASS + 2)
#: Pixels looked at, at most.
PIXELS = 1024
#: What is tried.
GATHER_RAYS = (1, 2, 4, 8, 16)
PHOTON_FACTORS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
#: Microseconds on one core of the machine that this was measured on; their ratios count: a
#: ray with the surface that it meets, the photons at the end of a gather ray, a photon stored,
#: a pixel.
RAY, QUERY, STORED, PIXEL = 0.55, 0.75, 0.3, 0.3
#: Noise of the camera's samples falls faster than with the number of passes (Sobol points),
#: so that less of it is left after some passes than a single one shows.
CAMERA_LEFT = 0.6
#: Weights of the error are those of ``relative_error``.
_DARK = 0.01
_LAYERS = ("emission", "direct", "caustics", "indirect")


class Noise(NamedTuple):
    """Variance of one pass relative to the squared image, by what it falls with.

    ``camera``: with passes alone; ``gather``: with gather rays; ``photons``: with caustic
    photons.
    """

    camera: float
    gather: float
    photons: float


class Cost(NamedTuple):
    """Microseconds of a pass.

    ``camera``: its camera paths and global photons; ``gather``: one gather ray for each path;
    ``photons``: as many caustic photons as it was measured with.
    """

    camera: float
    gather: float
    photons: float


class Balance(NamedTuple):
    """The decision: gather rays a place, and a factor for the caustic photons."""

    gather_rays: int
    photon_factor: float


class Look(NamedTuple):
    """What a few pixels show, three times.

    ``second`` has other camera paths and other photons than ``first``, ``third`` the paths of
    the first and the photons of the second; those come from ``walks``.
    """

    first: Chunk
    second: Chunk
    third: Chunk
    batches: list[Batch]
    walks: list[Walk]


def is_free(settings: Settings) -> bool:
    """Whether there is anything to decide."""
    return settings.gather_rays == AUTOMATIC


def pixels_of(region: Region, i: int) -> Pixels:
    """Path ``i`` of pixels spread over ``region``, in all of its columns."""
    total = region.width * region.height
    stride = max(1, total // PIXELS)
    while stride > 1 and gcd(stride, region.width) > 1:
        stride -= 1
    return Pixels.spread(i, min(PIXELS, total // stride), stride=stride)


def part_of_look(
    prepared: Prepared, settings: Settings, region: Region, camera: int, maps: PhotonMaps
) -> Chunk:
    """The pixels of a ``Look`` with the camera paths of ``PASSES[camera]``."""
    plain = prepared._replace(first_hits=None)
    bare = replace(settings, gather_rays=1, light_kinds=False, first_hit=())
    return trace_chunk(plain, bare, region, pixels_of(region, PASSES[camera]), maps)


def noise_of(seen: Look) -> Noise:
    """What the parts of ``seen`` differ by."""
    one, two, three = (chunk.samples for chunk in (seen.first, seen.second, seen.third))
    total = [sum((rows[name] for name in _LAYERS), np.zeros(3)) for rows in (one, two, three)]
    mean = np.mean(total, axis=0)
    weight = 1.0 / (mean**2 + _DARK * float(np.mean(mean)) ** 2 + 1e-300)

    def spread(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
        return float(np.nanmean(0.5 * (a - b) ** 2 * weight))

    photons = spread(one["caustics"], three["caustics"])
    camera = spread(one["emission"] + one["direct"], two["emission"] + two["direct"])
    camera += max(0.0, spread(one["caustics"], two["caustics"]) - photons)
    return Noise(camera, spread(one["indirect"], two["indirect"]), photons)


def caustics_by_paths(seen: Look) -> float:
    """The part of the variance of caustics that camera paths bring, 0 to 1."""
    one, two, three = (
        chunk.samples["caustics"] for chunk in (seen.first, seen.second, seen.third)
    )
    whole = float(np.nansum((one - two) ** 2))
    photons = float(np.nansum((one - three) ** 2))
    return max(0.0, 1.0 - photons / whole) if whole > 0.0 else 0.0


def cost_of(seen: Look, region: Region) -> Cost:
    """By the rays and photons of ``seen``."""
    pixels = region.width * region.height
    each = pixels / seen.first.pixels.paths
    gathered = seen.first.gathered * each
    photons = {True: 0.0, False: 0.0}
    for batch, walk in zip(seen.batches, seen.walks, strict=True):
        photons[batch.caustic] += walk.rays * RAY + len(walk.photons) * STORED
    return Cost(
        camera=pixels * PIXEL + (seen.first.rays * each - gathered) * RAY + photons[False],
        gather=gathered * (RAY + QUERY),
        photons=photons[True],
    )


def least_error(noise: Noise, cost: Cost, photon_factors: Sequence[float]) -> Balance:
    """What has the least product of noise and time."""

    def product(balance: Balance) -> float:
        rays, factor = balance
        left = noise.camera * CAMERA_LEFT + noise.gather / rays + noise.photons / factor
        return left * (cost.camera + cost.gather * rays + cost.photons * factor)

    tried = (Balance(rays, factor) for rays in GATHER_RAYS for factor in photon_factors)
    return min(tried, key=product)


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
    found = least_error(noise_of(seen), cost_of(seen, region), factors)
    settings = replace(settings, gather_rays=found.gather_rays)
    if not free:
        return settings
    usual = settings.photon_count(AUTOMATIC, region.width * region.height)
    return replace(
        settings,
        photons_caustic=int(usual * found.photon_factor),
        caustic_radius=settings.caustic_radius * min(1.0, found.photon_factor ** (-1 / 6)),
    )


def stage_of(settings: Settings) -> Stage:
    """The line of the plan that tells the decision."""
    caustic = ""
    if settings.photons_caustic > 0:
        caustic = f", {settings.photons_caustic} caustic photons"
    return Stage(
        "balance", True, f"{settings.gather_rays} gather rays{caustic} for the least noise"
    )
