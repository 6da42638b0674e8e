"""What a few pixels show before the first pass: their light with other random numbers.

Edges and soft shadows, the directions of the final gather, or the photons make an image noisy.
A few pixels are looked at with independent random numbers for each of them, which tells the
causes apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import gcd
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera_pass.chunk import (
    Chunk,
    PhotonMaps,
    trace_camera,
    trace_chunk,
    trace_gather,
    wide_only,
)
from .camera_pass.next_event import light_directly
from .camera_pass.pixels import Pixels, Region
from .camera_pass.rays import Rays
from .film.film import SAMPLE
from .photon_pass import Batch
from .photons.shadow import ShadowMap
from .photons.trace import Walk
from .pilot import PILOT_PASS
from .prepared import Prepared
from .settings import Settings

#: Passes whose random numbers are asked; no real pass reaches them.
PASSES = (PILOT_PASS + 1, PILOT_PASS + 2)
#: Pixels looked at, at most, and those whose emission is.
PIXELS, EMISSION_PIXELS = 1024, 8192
#: Weights of the error are those of ``relative_error``.
_DARK = 0.01
_LAYERS = ("emission", "direct", "caustics", "indirect")


class Noise(NamedTuple):
    """Variance of one pass relative to the squared image, by what it falls with.

    ``camera``: with passes alone; ``light``: with light samples; ``gather``: with gather
    rays; ``photons``: with caustic photons.
    """

    camera: float
    light: float
    gather: float
    photons: float


class DirectLook(NamedTuple):
    """Emission of two sets of camera paths, and direct light of one.

    ``emission`` (2, m, 3): of more pixels than the others, as lamps that are seen in glass
    are rare and bright. ``light`` (2, n, 3): by light samples, drawn twice; ``gather``
    (2, n, 3): by gather rays, drawn twice; ``samples``: how many light samples there were.
    """

    emission: NDArray[np.float64]
    light: NDArray[np.float64]
    gather: NDArray[np.float64]
    samples: int


@dataclass(frozen=True)
class Look:
    """What a few pixels show, three times.

    ``second`` has other camera paths and other photons than ``first``, ``third`` the paths of
    the first and the photons of the second; those come from ``walks``. ``direct``: that of
    the paths of the first.
    """

    first: Chunk
    second: Chunk
    third: Chunk
    direct: DirectLook
    batches: list[Batch]
    walks: list[Walk]

    @cached_property
    def noise(self) -> Noise:
        """See ``noise_of``."""
        return noise_of(self)


def pixels_of(region: Region, i: int, most: int = PIXELS) -> Pixels:
    """Path ``i`` of pixels spread over ``region``, in all of its columns."""
    total = region.width * region.height
    stride = max(1, total // most)
    while stride > 1 and gcd(stride, region.width) > 1:
        stride -= 1
    return Pixels.spread(i, min(most, total // stride), stride=stride)


def part_of_look(
    prepared: Prepared, settings: Settings, region: Region, camera: int, maps: PhotonMaps
) -> Chunk:
    """The pixels of a ``Look`` with the camera paths of ``PASSES[camera]``."""
    plain = prepared._replace(first_hits=None)
    return trace_chunk(plain, _bare(settings), region, pixels_of(region, PASSES[camera]), maps)


def parts_of_look(
    prepared: Prepared, settings: Settings, region: Region, maps: Sequence[PhotonMaps]
) -> list[tuple[Any, ...]]:
    """Functions and their arguments; ``look_from`` takes what they return."""
    chunks = ((0, 0), (1, 1), (0, 1))
    asked = (prepared, settings, region)
    return [
        *((part_of_look, *asked, camera, maps[photons]) for camera, photons in chunks),
        *((emission_look, *asked, i) for i in PASSES),
        (direct_look, *asked, maps[0].shadows),
    ]


def look_from(parts: list[Any], batches: list[Batch], walks: list[Walk]) -> Look:
    """Of what ``parts_of_look`` have found."""
    *chunks, one, two, direct = parts
    first, second, third = chunks
    direct = direct._replace(emission=np.stack([one, two]))
    return Look(first, second, third, direct, batches, walks)


def _bare(settings: Settings) -> Settings:
    """One of each, and light alone."""
    return replace(
        settings, gather_rays=1, light_samples=1, light_kinds=False, first_hit=(), aovs=()
    )


def emission_look(
    prepared: Prepared, settings: Settings, region: Region, i: int
) -> NDArray[np.float64]:
    """Emission (m, 3) that camera paths ``i`` meet."""
    pixels = pixels_of(region, i, EMISSION_PIXELS)
    seen = np.zeros(pixels.paths, SAMPLE)
    rays = Rays(prepared, pixels.paths)
    trace_camera(prepared, _bare(settings), region, pixels, rays, seen)
    return seen["emission"]


def direct_look(
    prepared: Prepared, settings: Settings, region: Region, shadows: ShadowMap | None
) -> DirectLook:
    """Direct light of the camera paths of the first part of a ``Look``; no emission."""
    bare = _bare(settings)
    pixels = pixels_of(region, PASSES[0])
    rays = Rays(prepared, pixels.paths)
    light, gather = (np.zeros((2, pixels.paths), SAMPLE) for _ in range(2))
    lit = trace_camera(prepared, bare, region, pixels, rays, np.zeros(pixels.paths, SAMPLE))
    for k, i in enumerate(PASSES):
        lit.vertices["number"] = i
        light_directly(prepared, bare, lit, shadows, light[k], None)
    ends = wide_only(lit)
    for k, i in enumerate(PASSES):
        ends.vertices["number"] = i
        if len(ends.vertices):
            trace_gather(prepared, bare, ends, gather[k])
    none = np.zeros((2, 0, 3))
    return DirectLook(none, light["direct"], gather["direct"], len(lit.vertices))


def noise_of(seen: Look) -> Noise:
    """What the parts of ``seen`` differ by."""
    one, two, three = (chunk.samples for chunk in (seen.first, seen.second, seen.third))
    total = [sum((rows[name] for name in _LAYERS), np.zeros(3)) for rows in (one, two, three)]
    mean = np.mean(total, axis=0)
    weight = _weight(mean, float(np.mean(mean)))

    # A place whose lamp one ray has missed is not dark: both draws tell how bright it is.
    direct = 0.5 * (seen.direct.light.sum(axis=0) + seen.direct.gather.sum(axis=0))
    lit = mean + direct - np.mean([rows["direct"] for rows in (one, two, three)], axis=0)
    lit_weight = _weight(lit, float(np.mean(mean)))

    def spread(
        a: NDArray[np.float64], b: NDArray[np.float64], by: NDArray[np.float64] = weight
    ) -> float:
        return float(np.nanmean(0.5 * (a - b) ** 2 * by))

    photons = spread(one["caustics"], three["caustics"])
    camera = spread(one["direct"], two["direct"])
    light = spread(seen.direct.light[0], seen.direct.light[1], lit_weight)
    gather = spread(seen.direct.gather[0], seen.direct.gather[1], lit_weight)
    camera = max(0.0, camera - light - gather)
    others = np.mean(mean) - np.mean(one["emission"] + two["emission"] + three["emission"]) / 3
    emission = seen.direct.emission[0], seen.direct.emission[1]
    camera += _emission_noise(*emission, float(others), float(np.mean(mean)))
    camera += max(0.0, spread(one["caustics"], two["caustics"]) - photons)
    gather += spread(one["indirect"], two["indirect"])
    return Noise(camera, light, gather, photons)


def _weight(light: NDArray[np.float64], mean: float) -> NDArray[np.float64]:
    return np.asarray(1.0 / (light**2 + _DARK * mean**2 + 1e-300))


def _emission_noise(
    one: NDArray[np.float64], two: NDArray[np.float64], others: float, mean: float
) -> float:
    """Noise of emission beside the mean of the ``others``.

    A rare bright sample would weigh itself down if its own pixel's mean were the weight, so
    that is the geometric mean of what either sample alone says.
    """
    roots = [
        np.sqrt((others + sample) ** 2 + _DARK * mean**2 + 1e-300) for sample in (one, two)
    ]
    return float(np.nanmean(0.5 * (one - two) ** 2 / (roots[0] * roots[1])))


def caustics_by_paths(seen: Look) -> float:
    """The part of the variance of caustics that camera paths bring, 0 to 1."""
    one, two, three = (
        chunk.samples["caustics"] for chunk in (seen.first, seen.second, seen.third)
    )
    whole = float(np.nansum((one - two) ** 2))
    photons = float(np.nansum((one - three) ** 2))
    return max(0.0, 1.0 - photons / whole) if whole > 0.0 else 0.0
