"""Sums of what the passes saw, per pixel and layer; films of different passes add up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ..sampling.rng import REPLICATES

#: Layers whose sum is the picture.
LIGHT_LAYERS = ("emission", "direct", "caustics", "indirect")
#: Depth of a pixel that sees nothing [m].
NOTHING_DEPTH = 1e10

#: What one chunk of camera paths adds: one row per pixel, all float64.
SAMPLE = np.dtype(
    [(name, "f8", 3) for name in (*LIGHT_LAYERS, "normal", "albedo")]
    + [("depth", "f8"), ("hit", "f8"), ("alpha", "f8")],
    align=True,
)


@dataclass
class RenderStatistics:
    """Counts over all passes in the film."""

    photons_emitted: int = 0
    photons_stored: int = 0
    rays: int = 0
    non_finite: int = 0


class Film:
    """The picture so far, ``height`` rows from the bottom, ``width`` pixels each.

    Memory: 21 float64 sums, 12 for the error and 5 counters: 304 bytes a pixel.
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
    }

    def __init__(self, width: int, height: int) -> None:
        self.width = width
        self.height = height
        self.statistics = RenderStatistics()
        count = width * height
        self._sum = np.zeros(count, SAMPLE)
        self._count = np.zeros(count, np.int64)
        self._part_sum = np.zeros((REPLICATES, count, 3))
        self._part_count = np.zeros((REPLICATES, count), np.int64)

    @property
    def passes(self) -> int:
        """Whole passes in the film."""
        return int(self._count.min())

    def add(self, i: int, start: int, samples: NDArray[np.void]) -> None:
        """Add pass ``i``'s ``samples`` (n,) ``SAMPLE`` to the pixels from ``start`` on.

        A sample with a NaN or infinity is counted and replaced by black: one bad path may
        not spoil a pixel for good.
        """
        finite = np.ones(len(samples), np.bool_)
        for name in SAMPLE.names or ():
            value = samples[name]
            good = np.isfinite(value)
            finite &= good if value.ndim == 1 else good.all(axis=1)
        if not finite.all():
            self.statistics.non_finite += int(len(finite) - finite.sum())
            samples = np.where(finite, samples, np.zeros(1, SAMPLE))
        part = slice(start, start + len(samples))
        combined = np.zeros((len(samples), 3))
        for name in SAMPLE.names or ():
            self._sum[name][part] += samples[name]
            if name in LIGHT_LAYERS:
                combined += samples[name]
        self._count[part] += 1
        self._part_sum[i % REPLICATES, part] += combined
        self._part_count[i % REPLICATES, part] += 1

    def merge(self, other: Film) -> None:
        """Add the passes of ``other``, a film of the same size and other pass numbers."""
        if (other.width, other.height) != (self.width, self.height):
            raise ValueError(
                f"films of {self.width}x{self.height} and {other.width}x{other.height} "
                "pixels cannot be merged"
            )
        for name in SAMPLE.names or ():
            self._sum[name] += other._sum[name]
        self._count += other._count
        self._part_sum += other._part_sum
        self._part_count += other._part_count
        for name, value in vars(other.statistics).items():
            setattr(self.statistics, name, getattr(self.statistics, name) + value)

    def resolve(self, layer: str) -> NDArray[np.float32]:
        """The mean of a layer: (height, width, channels) float32, bottom row first.

        Light is radiance [W/(m^2 sr)], alpha premultiplied; depth is metres along the
        camera's axis, ``NOTHING_DEPTH`` where nothing was hit; normals are world space.
        """
        if layer not in self.LAYERS:
            raise ValueError(f"no layer '{layer}'; there are {', '.join(self.LAYERS)}")
        count = np.maximum(self._count, 1).astype(np.float64)
        if layer == "combined":
            out = np.empty((len(count), 4), np.float64)
            out[:, :3] = sum(self._sum[name] for name in LIGHT_LAYERS)
            out[:, 3] = self._sum["alpha"]
            out /= count[:, None]
        elif layer == "depth":
            hit = self._sum["hit"]
            depth = self._sum["depth"] / np.maximum(hit, 1)
            out = np.where(hit > 0, depth, NOTHING_DEPTH)[:, None]
        elif layer == "normal":
            out = self._sum[layer] / np.maximum(self._sum["hit"], 1)[:, None]
        else:
            out = self._sum[layer] / count[:, None]
        shape = (self.height, self.width, self.LAYERS[layer])
        return np.ascontiguousarray(out.reshape(shape), dtype=np.float32)

    def variance(self) -> NDArray[np.float64]:
        """Variance of the mean of the combined layer: (height, width, 3); inf below 2 passes.

        Passes of one replicate are stratified against each other, so their scatter would
        say too much; the replicates are independent, so theirs is honest.
        """
        count = self._part_count[:, :, None].astype(np.float64)
        total = np.maximum(count.sum(axis=0), 1.0)
        mean = self._part_sum.sum(axis=0) / total
        part = np.divide(
            self._part_sum, count, out=np.zeros_like(self._part_sum), where=count > 0
        )
        used = (count > 0).sum(axis=0)
        scatter = (count * (part - mean) ** 2).sum(axis=0)
        value = np.where(used > 1, scatter / (np.maximum(used - 1, 1) * total), np.inf)
        return value.reshape(self.height, self.width, 3)

    def relative_error(self) -> float:
        """Square root of the estimated relMSE; infinity before the second pass.

        relMSE = mean((x - ref)^2 / (ref^2 + 0.01 mean(ref)^2)), with the film's mean in
        place of ``ref`` and the variance of that mean in place of the squared difference.
        A black image has no error.
        """
        if self.passes < 2:
            return float("inf")
        variance = self.variance()
        mean = self.resolve("combined")[..., :3].astype(np.float64)
        floor = 0.01 * float(mean.mean()) ** 2
        scale = mean**2 + floor
        relative = np.divide(variance, scale, out=np.zeros_like(scale), where=scale > 0)
        return float(np.sqrt(relative.mean()))
