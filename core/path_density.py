"""How many camera paths each pixel gets in a pass: more where they are noisy.

The least error for a number of paths has them in proportion to the standard deviation of one
(Neyman 1934), here relative to the light there as in the stated error. The first passes have
one path a pixel; their scatter, and again that of twice, four times ... as many passes, tells
the shares of the next. A pixel's share is found from its neighbours alone: by its own samples
a pixel that has missed its bright ones would get fewer, and stay too dark (Kirk & Arvo 1991,
"Unbiased sampling techniques for image synthesis").
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .camera_pass.pixels import Pixels
from .sampling.rng import REPLICATES

if TYPE_CHECKING:
    from .film.film import Film

Plane = NDArray[np.float64]

#: Passes with one path a pixel: as many as tell a scatter.
FIRST = REPLICATES
#: Least and most paths of a pixel in the mean over passes.
LEAST, MOST = 0.5, 4.0
#: Neighbours count by a Gaussian of this deviation [pixels].
WIDTH = 1.0
#: Shares that would leave more of all variance than this are not worth while.
WORTH = 0.95
#: A scatter of single paths below this is rounding.
_ROUNDING = 1e-6
#: As in the stated error: dark pixels count by this part of the mean's square.
_DARK = 0.01


class PathDensity:
    """The paths of each pass of a film; asked for in the order of the passes."""

    def __init__(self, width: int, height: int, adaptive: bool) -> None:
        self._adaptive = adaptive
        self._every = np.arange(width * height, dtype=np.int32)
        #: Paths of each pixel in each replicate: so far, and in the passes under way.
        self._done = np.zeros(width * height, np.int32)
        self._now = np.ones(width * height, np.int32)
        #: Parts of paths that are due, begun so that neighbours do not come at once: a
        #: low-discrepancy sequence over the plane (Roberts 2018).
        y, x = np.divmod(self._every.astype(np.float64), width)
        self._due = (0.7548776662466927 * x + 0.5698402909980532 * y) % 1.0
        #: Paths of each pixel in the mean over passes, None for one.
        self.shares: Plane | None = None
        #: The part of the variance of caustics that camera paths bring, not photons.
        self.caustics = 0.0

    def looks(self, i: int) -> bool:
        """Whether the paths of pass ``i`` hang on the light in the film."""
        return self._adaptive and i >= FIRST and i & (i - 1) == 0

    def pixels(self, i: int, film: Film) -> Pixels:
        """The paths of pass ``i``, which follows those in ``film``.

        The passes of one round, one of each replicate, have the same.
        """
        replicate = i % REPLICATES
        if replicate == 0 and i > 0:
            self._begin(i, film)
        if self.shares is None:
            return Pixels(self._every, self._done * REPLICATES + replicate)
        ids = np.repeat(self._every, self._now)
        before = np.cumsum(self._now) - self._now
        turn = np.arange(len(ids), dtype=np.int32) - before[ids]
        numbers = (self._done[ids] + turn) * REPLICATES + replicate
        return Pixels(ids, numbers.astype(np.int32))

    def _begin(self, i: int, film: Film) -> None:
        """A new round, with other shares after each doubling of the passes."""
        self._done += self._now
        if self.looks(i):
            self.shares = shares_of(film, self.caustics)
        if self.shares is None:
            self._now = np.ones_like(self._now)
            return
        self._due += self.shares
        self._now = np.floor(self._due).astype(np.int32)
        self._due -= self._now


def shares_of(film: Film, caustics: float = 0.0) -> Plane | None:
    """Paths of each pixel (n,), 1 in the mean; None where one each is as good.

    ``caustics``: the part of the variance of caustics that falls with the paths.
    """
    # Variances: where bright samples are rare, few pixels of many show any scatter.
    variance, light = film.scatter_of_paths(caustics)
    whole, _ = film.scatter_of_paths(1.0)
    variance, whole, light = (
        among_neighbours(plane.reshape(film.height, film.width)).ravel()
        for plane in (variance, whole, light)
    )
    floor = _DARK * float(light.mean()) ** 2
    relative = np.sqrt(variance / (light**2 + floor + 1e-300))
    if not relative.mean() > _ROUNDING:
        return None
    shares = np.clip(relative / relative.mean(), LEAST, MOST)
    shares /= shares.mean()
    saved = float((relative**2).mean() - (relative**2 / shares).mean())
    both = float((whole / (light**2 + floor + 1e-300)).mean())
    return shares if saved > (1.0 - WORTH) * both else None


def among_neighbours(plane: Plane) -> Plane:
    """Each pixel's mean over its neighbours, itself left out; ``plane`` (h, w), 0 at least."""
    from scipy.ndimage import gaussian_filter

    def blurred(values: Plane) -> Plane:
        out: Plane = gaussian_filter(values, WIDTH, mode="constant")
        return out

    point = np.zeros((1, 1))
    point[0, 0] = 1.0
    own = float(blurred(point)[0, 0])
    weight = blurred(np.ones_like(plane)) - own
    # Of what is never negative; rounding of the difference may be.
    total = np.maximum(blurred(plane) - own * plane, 0.0)
    # An image of one pixel has no neighbours.
    return np.divide(total, weight, out=np.zeros_like(plane), where=weight > 1e-9)
