"""Sums of what the passes saw, per pixel and layer; films of different passes add up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..sampling.rng import REPLICATES
from .accumulate import (
    add_samples,
    bias_square,
    crossed_means,
    relative_mean,
    scatter_of_parts,
    variance_of_mean,
)
from .first_hits import FirstHits
from .layers import (
    FIRST_HIT_LAYERS,
    KIND_COLORS,
    KIND_LAYERS,
    KINDS,
    LIGHT_LAYERS,
    aov_layer,
    group_layer,
)
from .repeated import add_each, each_once
from .stated_error import UNKNOWN, StatedError

#: Depth of a pixel that sees nothing [m].
NOTHING_DEPTH = 1e10

#: What one chunk of camera paths adds: one row per pixel, all float64. ``shrink``: what the
#: density estimates would lose with half the area for their discs.
SAMPLE = np.dtype(
    [(name, "f8", 3) for name in (*LIGHT_LAYERS, "normal", "albedo")]
    + [("depth", "f8"), ("hit", "f8"), ("alpha", "f8"), ("shrink", "f8", 3)],
    align=True,
)

#: The same as plain numbers per row, and those of them that are summed for the layers.
COLUMNS = SAMPLE.itemsize // 8
SUMMED = COLUMNS - 3
#: The bias of a disc over smooth light falls with its area: half the area leaves half of it,
#: so all of it is twice what was lost (Richardson's extrapolation; Silverman 1986, section
#: 3.3). At straight edges the root mean square is 1.4 to 1.8 times that, but over whole images
#: of caustics, weighed as below, twice is what the references tell.
BIAS_FACTOR = 2.0
#: Times what half the area loses is taken off the light where it weighs a bias: discs fill
#: dark places beside bright ones, and an error counts by the light that belongs there.
SHARPEN = 1.4
#: Exponent of the noise weighed by the other replicates in the geometric mean with that weighed
#: by all: measured on the benchmark's scenes (CONTRIBUTING, "Decisions").
CROSSED = 0.6
#: With less than all replicates: the relative variance q of a pixel, taken by its own mean, is
#: too small by this times q^2 (delta method, for exponential samples).
SKEW = 2.0
#: Width of the square of pixels over which the layer "error" is averaged: the scatter of
#: four replicates knows a single pixel's to a factor of two only.
_ERROR_WINDOW = 5


@dataclass
class RenderStatistics:
    """Counts over all passes in the film."""

    photons_emitted: int = 0
    photons_stored: int = 0
    rays: int = 0
    non_finite: int = 0


class Film:
    """The picture so far, ``height`` rows from the bottom, ``width`` pixels each.

    ``LAYERS`` are always there, ``first_hits`` hold those that were asked for beside them.
    Memory: 21 float64 sums, 28 for the error and 5 counters: 412 bytes a pixel, 144 for the
    light by kind if it is kept, 48 for each group of lights, 32 for each AOV.
    """

    LAYERS: ClassVar[dict[str, int]] = {
        "combined": 4,
        "emission": 3,
        "direct": 3,
        "caustics": 3,
        "indirect": 3,
        "depth": 1,
        "normal": 3,
        "albedo": 3,
        "error": 1,
    }

    def __init__(
        self,
        width: int,
        height: int,
        exposure: float = 1.0,
        first_hit: tuple[str, ...] = (),
        matte_ranks: int = 6,
        light_kinds: bool = False,
        light_groups: tuple[str, ...] = (),
        aovs: tuple[str, ...] = (),
    ) -> None:
        self.width = width
        self.height = height
        self.exposure = exposure
        self.statistics = RenderStatistics()
        #: Whole passes in the film.
        self.passes = 0
        count = width * height
        self._sum = np.zeros((count, SUMMED))
        self._count = np.zeros(count, np.int32)
        self._part_sum = np.zeros((REPLICATES, count, 3))
        self._part_count = np.zeros((REPLICATES, count), np.int32)
        self._part_caustics = np.zeros((REPLICATES, count))
        self._shrink = np.zeros((REPLICATES, count, 3))
        self.first_hits = FirstHits(count, first_hit, matte_ranks) if first_hit else None
        self._kinds = np.zeros((count, len(KIND_LAYERS), 3)) if light_kinds else None
        groups = [group_layer(name, c) for name in light_groups for c in (False, True)]
        self._groups = {name: np.zeros((count, 3)) for name in groups}
        self._aovs = {aov_layer(name): np.zeros((count, 4)) for name in aovs}

    @property
    def nbytes(self) -> int:
        """Memory of the sums [bytes]."""
        own = self._sum.nbytes + self._count.nbytes + self._shrink.nbytes
        own += self._part_sum.nbytes + self._part_count.nbytes + self._part_caustics.nbytes
        own += self._kinds.nbytes if self._kinds is not None else 0
        own += sum(p.nbytes for p in (*self._groups.values(), *self._aovs.values()))
        return own + (self.first_hits.nbytes if self.first_hits else 0)

    def add(self, i: int, ids: NDArray[np.int32], samples: NDArray[np.void]) -> None:
        """Add pass ``i``'s ``samples`` (n,) ``SAMPLE`` to the pixels ``ids`` (n,).

        A sample with a NaN or infinity is counted and replaced by black: one bad path may
        not spoil a pixel for good.
        """
        replicate = i % REPLICATES
        self.statistics.non_finite += add_samples(
            self._sum, self._count, self._part_sum[replicate], self._part_count[replicate],
            self._part_caustics[replicate], self._shrink[replicate], ids,
            samples.view(np.float64).reshape(len(samples), COLUMNS),
            3 * len(LIGHT_LAYERS), 3 * LIGHT_LAYERS.index("caustics"),
        )  # fmt: skip

    def end_pass(self) -> None:
        """All of a pass has been added."""
        self.passes += 1

    def add_asked(
        self,
        i: int,
        ids: NDArray[np.int32],
        first_hits: NDArray[np.void] | None,
        kinds: NDArray[np.float64] | None,
        aovs: NDArray[np.float64] | None = None,
    ) -> None:
        """Add what pass ``i`` has beside the light, to the pixels ``ids`` (n,), ascending.

        ``first_hits`` (n,) ``FIRST_HIT``, ``kinds`` (n, 6, 3) finite light by
        ``KIND_LAYERS``, ``aovs`` (n, A, 4); None for what was not asked for.
        """
        if aovs is not None:
            for k, plane in enumerate(self._aovs.values()):
                values = aovs[:, k]
                finite = np.isfinite(values).all(axis=1, keepdims=True)
                add_each(plane, ids, np.where(finite, values, 0.0))
        if self.first_hits is not None and first_hits is not None:
            for rows, pixels in each_once(ids):
                self.first_hits.add(i, pixels, first_hits[rows])
        if self._kinds is not None and kinds is not None:
            add_each(self._kinds, ids, kinds)

    def add_groups(self, ids: NDArray[np.int32], groups: NDArray[np.float64]) -> None:
        """Add finite light (n, G, 2, 3) of each group, in all and as caustics."""
        parts = groups.reshape(len(groups), len(self._groups), 3).swapaxes(0, 1)
        for plane, part in zip(self._groups.values(), parts, strict=True):
            add_each(plane, ids, part)

    def merge(self, other: Film) -> None:
        """Add the passes of ``other``, a film of the same size and other pass numbers."""
        if (other.width, other.height) != (self.width, self.height):
            raise ValueError(
                f"films of {self.width}x{self.height} and {other.width}x{other.height} "
                "pixels cannot be merged"
            )
        self._sum += other._sum
        self._count += other._count
        self._part_sum += other._part_sum
        self._part_count += other._part_count
        self._part_caustics += other._part_caustics
        self._shrink += other._shrink
        self.passes += other.passes
        if self.first_hits is not None and other.first_hits is not None:
            self.first_hits.merge(other.first_hits)
        if self._kinds is not None and other._kinds is not None:
            self._kinds += other._kinds
        for name, plane in self._groups.items():
            plane += other._groups[name]
        for name, plane in self._aovs.items():
            plane += other._aovs[name]
        for name, value in vars(other.statistics).items():
            setattr(self.statistics, name, getattr(self.statistics, name) + value)

    def resolve(self, layer: str) -> NDArray[np.float32]:
        """The mean of a layer: (height, width, channels) float32, bottom row first.

        Light is radiance [W/(m^2 sr)] times ``exposure``, alpha premultiplied; depth is
        metres along the camera's axis, ``NOTHING_DEPTH`` where nothing was hit; normals are
        world space; error is the expected distance of Combined from the truth, as light.
        """
        if layer in FIRST_HIT_LAYERS:
            return self._first_hit(layer)
        if layer in KIND_LAYERS:
            return self._kind(layer)
        if layer in self._aovs:
            mean = self._aovs[layer] / np.maximum(self._count, 1)[:, None]
            return mean.reshape(self.height, self.width, 4).astype(np.float32)
        if layer in self._groups:
            light = self.exposure * self._groups[layer] / np.maximum(self._count, 1)[:, None]
            return light.reshape(self.height, self.width, 3).astype(np.float32)
        if layer not in self.LAYERS:
            raise ValueError(f"no layer '{layer}'; there are {', '.join(self.LAYERS)}")
        if layer == "error":
            return self._error()
        count = np.maximum(self._count, 1)[:, None]
        hit = self._of("hit")
        if layer == "combined":
            out = np.empty((len(count), 4))
            out[:, :3] = sum(self._of(name) for name in LIGHT_LAYERS)
            out[:, :3] *= self.exposure
            out[:, 3:] = self._of("alpha")
            out /= count
        elif layer == "depth":
            out = np.where(hit > 0, self._of("depth") / np.maximum(hit, 1), NOTHING_DEPTH)
        elif layer == "normal":
            out = self._of(layer) / np.maximum(hit, 1)
        else:
            out = self._of(layer) / count
            if layer in LIGHT_LAYERS:
                out *= self.exposure
        shape = (self.height, self.width, self.LAYERS[layer])
        return np.ascontiguousarray(out.reshape(shape), dtype=np.float32)

    def _first_hit(self, layer: str) -> NDArray[np.float32]:
        if self.first_hits is None:
            raise ValueError(f"layer '{layer}' was not rendered: ask for it in the settings")
        plane = self.first_hits.resolve(layer)
        if layer in ("seen_emission", "environment"):
            plane = plane * self.exposure
        shape = (self.height, self.width, plane.shape[1])
        return np.ascontiguousarray(plane.reshape(shape), dtype=np.float32)

    def _kind(self, layer: str) -> NDArray[np.float32]:
        """Light of one kind over the colour of that kind, 0 where that is black."""
        if self._kinds is None or self.first_hits is None:
            raise ValueError(f"layer '{layer}' was not rendered: ask for it in the settings")
        k = KIND_LAYERS.index(layer)
        color = self.first_hits.resolve(KIND_COLORS[k % len(KINDS)])
        light = self.exposure * self._kinds[:, k] / np.maximum(self._count, 1)[:, None]
        out = np.divide(light, color, out=np.zeros_like(light), where=color > 0)
        shape = (self.height, self.width, 3)
        return np.ascontiguousarray(out.reshape(shape), dtype=np.float32)

    def _error(self) -> NDArray[np.float32]:
        from scipy.ndimage import uniform_filter

        variance, _ = self._variance_and_mean()
        square = variance + self._bias_square()
        plane = square.mean(axis=1).reshape(self.height, self.width)
        if self.passes >= 2:
            plane = uniform_filter(plane, _ERROR_WINDOW, mode="nearest")
        error = self.exposure * np.sqrt(np.maximum(plane, 0.0))
        return error[..., None].astype(np.float32)

    def _of(self, name: str) -> NDArray[np.float64]:
        """The sums (n, channels) of one field of the samples."""
        fields = SAMPLE.fields
        assert fields is not None
        kind, first = fields[name][:2]
        start = first // 8
        return self._sum[:, start : start + kind.itemsize // 8]

    def variance(self) -> NDArray[np.float64]:
        """Variance of the mean of the combined layer: (height, width, 3); inf below 2 passes.

        Passes of one replicate are stratified against each other, so their scatter would
        say too much; the replicates are independent, so theirs is honest.
        """
        return self._variance_and_mean()[0].reshape(self.height, self.width, 3)

    def scatter_of_paths(
        self, caustics: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(Variance of one path's light, mean light), (n,) each, over channels' sum.

        Of the variance of caustics only the part ``caustics``; the rest is the photons'.
        """
        variance = np.zeros(len(self._count))
        parts = self._part_sum, self._part_caustics, self._part_count
        scatter_of_parts(*parts, caustics, variance)
        light = self._part_sum.sum(axis=(0, 2)) / np.maximum(self._count, 1)
        return variance, light

    def _variance_and_mean(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        variance = np.zeros((len(self._count), 3))
        mean = np.zeros_like(variance)
        variance_of_mean(self._part_sum, self._part_count, variance, mean)
        return variance, mean

    def _bias_square(self) -> NDArray[np.float64]:
        square = np.zeros((len(self._count), 3))
        bias_square(self._shrink, self._part_count, BIAS_FACTOR, square)
        return square

    def stated_error(self) -> StatedError:
        """How wrong the combined layer still is; infinite before the second pass.

        relMSE = mean((x - ref)^2 / (ref^2 + 0.01 mean(ref)^2)), with the variance of the
        film's mean, plus the squared bias of the density estimates, in place of the squared
        difference. In place of ``ref``: a pixel's own mean makes rare bright samples weigh
        themselves down; the other replicates' (``crossed_means``) makes pixels whose light
        has not come there yet weigh too much. Noise is a geometric mean of both; bias, which
        is a product of two replicates, is weighed by the others. What no path has found yet
        cannot be known. A black image has no error.
        """
        if self.passes < 2:
            return UNKNOWN
        variance, mean = self._variance_and_mean()
        if self.passes < REPLICATES:
            noise = relative_mean(variance, mean, SKEW)
            lost = relative_mean(self._bias_square(), mean, 0.0) / BIAS_FACTOR**2
        else:
            crossed, lost = crossed_means(
                self._part_sum, self._part_count, self._shrink, SHARPEN
            )
            own = relative_mean(variance, mean, 0.0)
            noise = own ** (1.0 - CROSSED) * max(0.0, crossed) ** CROSSED
        return StatedError(math.sqrt(noise), BIAS_FACTOR * math.sqrt(max(0.0, lost)))

    def relative_error(self) -> float:
        """Square root of the estimated relMSE, noise and bias together."""
        return self.stated_error().relative_error
