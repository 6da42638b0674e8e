"""The error of an image against a reference that is noisy itself, and how well it is known.

A reference is kept as three independent parts. With x the image, and P, Q two parts,
(x - P)(x - Q) / w has the expectation (x - R)^2 / w: the noise of P and Q does not correlate.
The weight w = R^2 + 0.01 mean(R)^2 is taken from the third part, so that a pixel that chance
made too bright in P or Q is not weighed by the same chance. The three ways to choose them are
averaged. (With w given, this is the squared distance to the mean of all parts less the
mean's variance as known from the parts; w from the same parts makes that too small.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from measure import Image
from numpy.typing import NDArray

#: Independent parts of a reference.
PARTS = 3
#: Pixels along the side of a block whose noise is taken for independent of the others'.
BLOCK = 8


class Measured(NamedTuple):
    """relMSE of an image and the standard error that the reference leaves to it."""

    error: float
    deviation: float


@dataclass(frozen=True)
class Reference:
    """Parts (PARTS, h, w, 3) of a converged image, each worth its ``work`` (PARTS,).

    ``facts``: its json.
    """

    parts: Image
    work: NDArray[np.float64]
    facts: dict[str, Any]

    @property
    def image(self) -> Image:
        """All parts together (h, w, 3)."""
        mean: Image = np.tensordot(self.work / self.work.sum(), self.parts, axes=1)
        return mean

    @property
    def noise(self) -> float:
        """relMSE of ``image`` itself, from the variance between the parts."""
        return noise_of(self.parts, self.work)

    def error(self, image: Image) -> Measured:
        """relMSE of ``image`` (h, w, 3), which is independent of the reference.

        The deviation is a jackknife over the parts in each block of pixels, the blocks'
        variances added: it holds the noise of the reference alone, not how the error is
        spread over the image, and a firefly of one part shows in it. Where the noise of
        the parts is above the error it is up to twice too large.
        """
        if image.shape != self.parts.shape[1:]:
            raise ValueError(f"{image.shape} and {self.parts.shape[1:]} differ in size")
        pairs = np.stack([self._product(image, left_out) for left_out in range(PARTS)])
        shares = np.array([np.delete(self.work, k).prod() for k in range(PARTS)])
        shares /= shares.sum()
        whole = np.tensordot(shares, pairs, axes=1)
        total = 0.0
        for block, without in zip(
            blocks(whole), zip(*map(blocks, pairs), strict=True), strict=True
        ):
            total += jackknife(block, without, self.work)
        return Measured(float(whole.mean()), float(np.sqrt(total)) / whole.size)

    def _product(self, image: Image, left_out: int) -> Image:
        """Products of the two other parts' distances, by pixel (h, w)."""
        one, other = np.delete(self.parts, left_out, axis=0)
        judge = self.parts[left_out]
        weight = judge**2 + 0.01 * self.image.mean() ** 2
        product: Image = ((image - one) * (image - other) / weight).mean(axis=-1)
        return product


def blocks(values: Image) -> list[float]:
    """Sums over blocks of pixels of (h, w)."""
    rows = np.add.reduceat(values, np.arange(0, values.shape[0], BLOCK), axis=0)
    sums = np.add.reduceat(rows, np.arange(0, values.shape[1], BLOCK), axis=1)
    return [float(value) for value in sums.ravel()]


def jackknife(whole: float, without: Sequence[float], work: NDArray[np.float64]) -> float:
    """Variance of ``whole`` by what it is without each of the parts of unequal ``work``.

    Busing, Meijer and van der Leeden 1999, "Delete-m jackknife for unequal m", eq. 8.
    """
    ratio = work.sum() / work
    pseudo = ratio * whole - (ratio - 1.0) * np.asarray(without)
    middle = len(work) * whole - float(((1.0 - 1.0 / ratio) * np.asarray(without)).sum())
    return float(((pseudo - middle) ** 2 / (ratio - 1.0)).mean())


def noise_of(parts: Image, work: NDArray[np.float64]) -> float:
    """relMSE of the mean of ``parts`` (PARTS, h, w, 3), whose variances are as 1 / ``work``.

    From the differences of two, weighed by the third for the same reason as above.
    """
    floor = 0.01 * np.tensordot(work / work.sum(), parts, axes=1).mean() ** 2
    found = []
    for left_out, judge in enumerate(parts):
        one, other = np.delete(parts, left_out, axis=0)
        share = np.delete(work, left_out)
        single = (one - other) ** 2 * share.prod() / share.sum()
        found.append((single / (judge**2 + floor)).mean() / work.sum())
    return float(np.mean(found))
