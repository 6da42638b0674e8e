"""Memory of the photon maps: how many photons a pass may have below the user's limit.

What a photon takes is known, how many are stored for each one emitted is not: where the worst
case would not fit, a few are traced to see.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .camera_pass.chunk import PhotonMaps
from .camera_pass.light_image import bytes_of_connected, bytes_of_image, why_not
from .film.layers import DENSITY_LAYER
from .photon_pass import Batch, photon_batches, trace_batch
from .photons.photon_map import PhotonMap, bytes_of_map, bytes_while_building
from .photons.trace import PHOTON, Walk
from .pilot import CROWD, PILOT_PASS, Radii
from .plan import Plan
from .prepared import Prepared
from .settings import LightGroup, Settings

#: Photon paths of each kind that tell how many photons they leave.
PROBE = 4096
#: Standard errors of that number that a pass may have more, once in a million times.
MARGIN = 5.0
#: Photons of a kind that are emitted whatever the limit is: a pass has to have some.
LEAST = 256
#: Passes whose photons are traced while those of another are in use.
AHEAD = 2
#: Passes that must fit are traced one ahead, before there are fewer photons.
LEAST_AHEAD = 1

#: Passes differ by less than this factor in what they store.
_MORE = 1.05


class Stored(NamedTuple):
    """Photons that a pass stores of each kind, or an upper bound of it."""

    caustic: float
    global_: float

    def times(self, factor: float) -> Stored:
        """Of so many times the paths."""
        return Stored(self.caustic * factor, self.global_ * factor)


class Budget(NamedTuple):
    """The limit [bytes], and what takes memory beside one pass's photons.

    ``sides``: how often a photon is stored, by the groups of lights; ``counts``: whether
    there are copies for the layer of densities; ``pixels``: those of all images of photons
    connected with the camera.
    """

    limit: int
    sides: int
    counts: bool
    pixels: int = 0

    @staticmethod
    def of(settings: Settings, others: int = 0, pixels: int = 0) -> Budget:
        """What ``settings`` ask for, less the bytes of ``others``; ``pixels`` of an image."""
        sides = 1 + _most_groups(settings.light_groups)
        limit = (settings.photon_memory << 20) - others
        images = pixels * _images(settings)
        return Budget(limit, sides, DENSITY_LAYER in settings.first_hit, images)

    def bytes_of(self, stored: Stored, ahead: int) -> int:
        """Most memory of passes that store so much, ``ahead`` under way beside one in use."""
        in_use = building = 0
        for count in map(math.ceil, stored):
            copies = count * PHOTON.itemsize if self.counts else 0
            in_use += bytes_of_map(count) + copies
            building += bytes_while_building(count) + copies
        photons = self.sides * (in_use + ahead * building)
        if self.pixels == 0:
            return photons
        seen = self.sides * bytes_of_connected(math.ceil(stored.caustic))
        return photons + (1 + ahead) * bytes_of_image(self.pixels) + ahead * seen

    def part(self, stored: Stored) -> float:
        """The part, 1 at most, of ``stored`` that fits."""
        # What a photon takes goes in steps of the tables' sizes, up to twice as much.
        low, high = 0.0, 1.0
        if self.bytes_of(stored, LEAST_AHEAD) <= self.limit:
            return high
        for _ in range(30):
            middle = 0.5 * (low + high)
            fits = self.bytes_of(stored.times(middle), LEAST_AHEAD) <= self.limit
            low, high = (middle, high) if fits else (low, middle)
        return low


class Afforded(NamedTuple):
    """The batches of a pass; how many photons they store, at most; a warning if there is one.

    ``fewer``: whether there are fewer than asked for.
    """

    batches: list[Batch]
    stored: Stored
    warnings: tuple[str, ...] = ()

    @property
    def fewer(self) -> bool:
        """Whether there are fewer photons than was asked for."""
        return bool(self.warnings)


def affordable(prepared: Prepared, settings: Settings, plan: Plan, pixels: int) -> Afforded:
    """The photons of a pass within the limit of ``settings``.

    Neither threads nor the size of chunks change how many there are.
    """
    batches = photon_batches(plan, settings, pixels)
    counts = emitted(batches)
    rows = 2 if prepared.focus.found else 1
    worst = Stored(*(float(rows * count * settings.photon_depth) for count in counts))
    image = 0 if counts[0] == 0 or why_not(settings, pixels, _images(settings)) else pixels
    budget = Budget.of(settings, 5 * image, image)
    if budget.bytes_of(worst, AHEAD) <= budget.limit:
        return Afforded(batches, worst)
    each = [_stored_each(prepared, settings, k == 0) if counts[k] else 0.0 for k in (0, 1)]
    stored = Stored(each[0] * counts[0], each[1] * counts[1])
    others = bytes_of_map(math.ceil(each[0] * CROWD)) + 5 * image
    part = Budget.of(settings, others, image).part(stored)
    if part >= 1.0:
        return Afforded(batches, stored)
    fewer = [min(count, max(LEAST, int(part * count))) for count in counts]
    less = replace(settings, photons_caustic=fewer[0], photons_global=fewer[1])
    warning = (
        f"{sum(counts)} photons a pass would take more than {settings.photon_memory} MB: there "
        f"are {sum(fewer)}; raise the photons' memory limit for more"
    )
    stored = Stored(each[0] * fewer[0], each[1] * fewer[1])
    return Afforded(photon_batches(plan, less, pixels), stored, (warning,))


def emitted(batches: Iterable[Batch]) -> tuple[int, int]:
    """Photons (caustic, global) that a pass emits."""
    counts = {batch.caustic: batch.total for batch in batches}
    return counts.get(True, 0), counts.get(False, 0)


class PhotonMemory:
    """What the maps of a render take, and how far ahead passes are traced for it."""

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._others = 0
        self._pixels = 0
        self._in_use = 0
        self._building = 0
        #: Passes that are traced ahead of the one in use.
        self.ahead = AHEAD

    @property
    def peak(self) -> int:
        """Most memory [bytes] that the maps so far have taken, with those under way."""
        return self._others + self._in_use + self.ahead * self._building

    def expect(self, stored: Stored, radii: Radii) -> int:
        """Decide for passes that store so many photons, beside what ``radii`` keep.

        Returns the bytes that are left below the limit.
        """
        self._others = bytes_in(radii.crowd) if radii.crowd is not None else 0
        if radii.expected is not None:
            self._others += radii.expected.nbytes
            self._pixels = radii.expected.pixels
        budget = Budget.of(self._settings, self._others, self._pixels)
        fits = budget.bytes_of(stored, AHEAD) <= budget.limit
        self.ahead = AHEAD if fits else LEAST_AHEAD
        return budget.limit - budget.bytes_of(stored, self.ahead)

    def fits_with(self, stored: Stored) -> Callable[[float], bool]:
        """Whether passes that store ``stored`` may have so many times the caustic photons."""
        budget = Budget.of(self._settings, self._others, self._pixels)

        def fits(factor: float) -> bool:
            more = Stored(_MORE * factor * stored.caustic, _MORE * stored.global_)
            return budget.bytes_of(more, LEAST_AHEAD) <= budget.limit

        return fits

    def count(self, sides: Sequence[PhotonMaps]) -> None:
        """Count the maps of a pass, all lights' and each group's."""
        found = [
            m
            for maps in sides
            for m in (maps.caustic, maps.global_, maps.focus)
            if m is not None
        ]
        copies = sum(
            m.photons.nbytes
            for maps in sides
            if maps.counted is not None
            for m in maps.counted
            if m is not None
        )
        in_use = sum(map(bytes_in, found)) + copies
        building = sum(bytes_while_building(len(m.photons)) for m in found) + copies
        for image in (maps.connected for maps in sides):
            if image is not None:
                in_use += image.light.nbytes
                building += image.light.nbytes + bytes_of_connected(image.found)
        self._in_use = max(self._in_use, in_use)
        self._building = max(self._building, building)


def bytes_in(photon_map: PhotonMap) -> int:
    """Memory of a map and its tables."""
    parts = (photon_map.photons, photon_map.places, photon_map.keys, photon_map.start)
    return sum(part.nbytes for part in parts)


def stored_in(batches: Sequence[Batch], walks: Sequence[Walk]) -> Stored:
    """Photons of the ``walks`` of a pass."""
    counts = {True: 0, False: 0}
    for batch, walk in zip(batches, walks, strict=True):
        counts[batch.caustic] += len(walk.photons)
    return Stored(counts[True], counts[False])


def _stored_each(prepared: Prepared, settings: Settings, caustic: bool) -> float:
    """Photons that one emitted path stores, and ``MARGIN`` standard errors more."""
    walk = trace_batch(prepared, settings, PILOT_PASS, Batch(caustic, 0, PROBE, PROBE))
    paths = walk.order // settings.photon_depth
    left = np.bincount(paths, minlength=PROBE).astype(np.float64)
    return float(left.mean() + MARGIN * left.std() / math.sqrt(PROBE))


def _images(settings: Settings) -> int:
    """Images of connected photons in a pass: one of all lights, and of each group."""
    return 1 + len(settings.light_groups)


def _most_groups(groups: Iterable[LightGroup]) -> int:
    """How many groups the same light is in, at most."""
    found: Counter[tuple[str, str]] = Counter()
    for group in groups:
        found.update(("lamp", name) for name in group.lights)
        found.update(("object", name) for name in group.objects)
        found.update([("world", "")] if group.world else [])
    return max(found.values(), default=0)
