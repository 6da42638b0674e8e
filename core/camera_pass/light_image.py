"""The image of caustic photons that the camera sees at once, mixed with the discs' caustics.

A pixel is the sum w image + (1 - w) discs. Both are estimates of the same light, so any w is
right that does not hang on the photons summed: it is chosen by those of a pilot pass.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..film.filters import covered_pixels
from ..jit import Table, kernel
from ..plan import Plan, Stage
from .connections import SEEN, Connected
from .pixels import Region

if TYPE_CHECKING:
    from ..settings import Settings

#: Photons in a pixel from which on connections bring more of its light than discs.
FEW = 3.0
#: Sides of the squares of pixels in which a pilot pass's photons are counted, ...
WINDOWS = (5, 11, 23, 47)
#: ... the smallest that has so many.
COUNTED = 4.0
#: Pixels around a region whose photons are counted too.
MARGIN = WINDOWS[-1] // 2
#: Discs are left alone where a smaller part of a pilot's rays to photons arrives, ...
ARRIVING = 0.25
#: ... and everywhere if a smaller part arrives where it is not.
WORTH = 0.01
#: A filter that covers less of a pixel than this is left to discs.
LEAST_COVERED = 0.25
#: The images of all passes under way take this part of the photons' memory at most.
MOST_MEMORY = 0.25


class Expected(NamedTuple):
    """Photons of a pilot pass in the usual pixel around each of ``region``.

    ``counts`` (n,), 0 where discs are left alone, None where they are everywhere; ``reason``
    says why. ``wanted`` (h, w): pixels whose photons fall, by the filter, into one that gets
    some. ``filter_table``: see ``film/filters``; ``passes`` have photons of their own, later
    ones those of one of them.
    """

    region: Region
    counts: NDArray[np.float32] | None
    reason: str
    filter_table: NDArray[np.float64]
    wanted: NDArray[np.uint8]
    passes: int = 1

    @property
    def nbytes(self) -> int:
        """Memory [bytes]."""
        return self.counts.nbytes + self.wanted.nbytes if self.counts is not None else 0

    @property
    def pixels(self) -> int:
        """Pixels of each pass's image, 0 without any."""
        return len(self.counts) if self.counts is not None else 0

    def with_stage(self, plan: Plan) -> Plan:
        """``plan`` with the stage that tells of connections."""
        stage = Stage("connections", self.counts is not None, self.reason)
        return plan._replace(stages=(*plan.stages, stage))


class LightImage(NamedTuple):
    """Light (n, 3) of a pass's photons in the n pixels of a region, and its shares.

    ``so_far`` times ``expected`` (n,) photons are expected in a pixel up to this pass;
    ``found``: photons of this one.
    """

    light: NDArray[np.float32]
    expected: NDArray[np.float32]
    so_far: float
    found: int

    def at(self, ids: NDArray[np.int32]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Shares (m,) of pixels ``ids`` (m,), and the light (m, 3) that counts."""
        share = connected_share(self.so_far * self.expected[ids].astype(np.float64))
        return share, share[:, None] * self.light[ids]


def why_not(settings: Settings, pixels: int, sides: int) -> str:
    """Why no photons are connected whatever the camera sees; "" if nothing speaks against it.

    ``sides``: images of a pass, of ``pixels`` each.
    """
    if settings.light_kinds:
        return "light by kind is told apart at the ends of camera paths: discs alone"
    if settings.draft:
        return "a draft has too few photons in a pixel: discs alone"
    if 2 * sides * bytes_of_image(pixels) > MOST_MEMORY * (settings.photon_memory << 20):
        return "their images would take a quarter of the photons' memory limit: discs alone"
    return ""


def bytes_of_image(pixels: int) -> int:
    """Memory of a pass's image [bytes]."""
    return 3 * 4 * pixels


def bytes_of_connected(count: int) -> int:
    """Most memory [bytes] of ``count`` photons that are seen, until they are in an image."""
    # As they were found, in one piece, and in order; what they are ordered by, and the order.
    return count * (3 * SEEN.itemsize + 16)


def connected_share(so_far: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share (n,) of the connections where that many photons have been expected ``so_far``.

    The noise of photons counted pixel by pixel falls with all that have come so far, the blur
    of discs does not. The best weight of the discs is about 1 / (1 + n b^2), n photons in a
    pixel so far, b the relative bias of the discs.
    """
    return so_far / (so_far + FEW)


def expected_from(
    pilot: Connected, region: Region, filter_table: NDArray[np.float64]
) -> Expected:
    """What ``pilot``, photons connected with the pixels ``around(region)``, lets expect."""
    from scipy.ndimage import maximum_filter

    # A filter narrower than a pixel counts few of its photons, each with much weight.
    covered = min(1.0, covered_pixels(filter_table))
    if covered < LEAST_COVERED:
        return no_connections(region, "the filter is narrower than half a pixel: discs alone")
    counts = photons_around(pilot.seen, pilot.sent, region) * np.float32(covered)
    reach = math.ceil(filter_table[0, -1] - 0.5)
    some = counts.reshape(region.height, region.width) > 0.0
    wanted = maximum_filter(some.astype(np.uint8), 2 * reach + 1)
    # Of those that count, by the pixels that they fall into.
    x, y = pixels_of(pilot.seen["x"], pilot.seen["y"], region.x0, region.y0)
    inside = (x >= 0) & (y >= 0) & (x < region.width) & (y < region.height)
    useful = int(some[y[inside], x[inside]].sum())
    told = f"of {len(pilot.sent)} photons in view the camera sees {len(pilot.seen)} without"
    told = f"{told} mirror or glass"
    if useful == 0 or useful < WORTH * len(pilot.sent):
        return no_connections(region, f"{told}: discs alone")
    return Expected(region, counts, f"{told}, which need no disc", filter_table, wanted)


def no_connections(region: Region, reason: str) -> Expected:
    """Discs alone."""
    return Expected(region, None, reason, np.zeros((2, 0)), np.zeros((0, 0), np.uint8))


def around(region: Region) -> tuple[int, int, int, int]:
    """(x0, y0, width, height) of ``region`` with ``MARGIN``."""
    more = 2 * MARGIN
    return region.x0 - MARGIN, region.y0 - MARGIN, region.width + more, region.height + more


def pixels_of(
    x: NDArray[np.float64], y: NDArray[np.float64], x0: int, y0: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Columns and rows, counted from (x0, y0), of places on the film."""
    return np.floor(x).astype(np.int64) - x0, np.floor(y).astype(np.int64) - y0


def photons_around(
    seen: NDArray[np.void], sent: NDArray[np.float64], region: Region
) -> NDArray[np.float32]:
    """Photons (n,) in the usual pixel around each of ``region``: a little more than none.

    0 where few of those that rays were ``sent`` to are ``seen``; both of ``around(region)``,
    so that a border changes nothing.
    """
    from scipy.ndimage import uniform_filter

    x0, y0, width, height = around(region)
    pictures = []
    for places in ((seen["x"], seen["y"]), (sent[:, 0], sent[:, 1])):
        x, y = pixels_of(places[0], places[1], x0, y0)
        inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
        counts = np.bincount((y * width + x)[inside], minlength=width * height)
        pictures.append(counts.reshape(height, width).astype(np.float64))
    inner = slice(MARGIN, -MARGIN)
    out = np.zeros((region.height, region.width))
    done = np.zeros_like(out, np.bool_)
    for side in WINDOWS:
        # Running sums leave rounding errors where there is nothing.
        found, tried = (
            np.rint(uniform_filter(picture, side, mode="constant")[inner, inner] * side**2)
            for picture in pictures
        )
        now = ~done & ((tried >= COUNTED) | (side == WINDOWS[-1]))
        some = now & (found >= ARRIVING * tried)
        out[some] = ((found + 0.5) / side**2)[some]
        done |= now
    return out.ravel().astype(np.float32)


def light_image(
    expected: Expected, seen: list[NDArray[np.void]], i: int, factor: float
) -> LightImage:
    """The image of the photons ``seen`` in all batches of pass ``i``.

    ``factor``: photons of a pass for one of the pilot's.
    """
    assert expected.counts is not None
    region = expected.region
    light = np.zeros((region.width * region.height, 3), np.float32)
    rows = np.concatenate([np.zeros(0, SEEN), *seen])
    # In the order of their paths: the sums are the same whatever batches there were.
    rows = rows[np.argsort(rows["order"], kind="stable")]
    corner = (region.x0, region.y0, region.width, region.height)
    expose(expected.filter_table, corner, rows, light)
    so_far = factor * min(i + 1, expected.passes)
    return LightImage(light, expected.counts, so_far, len(rows))


@kernel
def density(table: Table, offset: float) -> float:
    """Density of the filter [1/pixel] at ``offset`` from the pixel's middle."""
    last = table.shape[1] - 1
    low = table[0, 0]
    step = (table[0, last] - low) / last
    cell = int(math.floor((offset - low) / step))
    if cell < 0 or cell >= last:
        return 0.0
    return float((table[1, cell + 1] - table[1, cell]) / step)


@kernel
def expose(table: Table, corner: tuple[int, int, int, int], seen: Table, light: Table) -> None:
    """Add the light of photons ``seen`` to the pixels around each by the filter's ``table``.

    ``light`` (n, 3): of the pixels from ``corner`` on, (x0, y0, width, height).
    """
    reach = table[0, -1]
    left, bottom, width, height = corner
    for k in range(len(seen)):
        row = seen[k]
        x0 = max(int(math.floor(row.x - reach)), left)
        x1 = min(int(math.floor(row.x + reach)) + 1, left + width)
        y0 = max(int(math.floor(row.y - reach)), bottom)
        y1 = min(int(math.floor(row.y + reach)) + 1, bottom + height)
        for y in range(y0, y1):
            across = density(table, row.y - y - 0.5)
            for x in range(x0, x1):
                weight = across * density(table, row.x - x - 0.5)
                pixel = light[(y - bottom) * width + x - left]
                for c in range(3):
                    pixel[c] += weight * row.light[c]
