"""Data of the surfaces that the camera sees at once: kept for the layers asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .layers import DENSITY_LAYER, END_LAYERS, MATTE_LAYERS, MEAN_LAYERS, SINGLE_LAYERS
from .mattes import add_mattes, ranked

#: Distance of a pixel that sees nothing [m].
NOTHING = 1e10
#: Surfaces of one path that mattes take in: what lies behind so many is left out.
MOST_MATTES = 4

_WIDTHS = {**MEAN_LAYERS, **SINGLE_LAYERS}
#: What one path adds, all float64. ``found``: 1 where ``SINGLE_LAYERS`` are known; ``ended``:
#: 1 where ``END_LAYERS`` are. ``mist``: what mist leaves to see. ``emission`` and ``direct``
#: take the light of lamps and faces on the way (``camera_pass.seen``). ``photon_density`` is a
#: sum over ``gathered`` places.
FIRST_HIT = np.dtype(
    [(name, "f8", (3,) if width == 3 else ()) for name, width in _WIDTHS.items()]
    + [("end_normal", "f8", 3), ("end_depth", "f8"), ("end_albedo", "f8", 3)]
    + [("found", "f8"), ("ended", "f8")]
    + [("emission", "f8", 3), ("direct", "f8", 3), ("matte_count", "f8")]
    + [(name, "f8", MOST_MATTES) for name in (*MATTE_LAYERS, "matte_weight")]
    + [(DENSITY_LAYER, "f8"), ("gathered", "f8")],
    align=True,
)


class FirstHits:
    """The data of ``count`` pixels; of different passes they add up.

    Memory: 8 bytes a channel, 12 bytes a rank of a matte, per pixel, and 12 more.
    """

    def __init__(self, count: int, layers: tuple[str, ...], ranks: int) -> None:
        self.layers = layers
        self._count = np.zeros(count, np.int32)
        self._ended = np.zeros(count, np.int32)
        #: Of which pass the single layers are: the first one.
        self._single_pass = np.full(count, np.iinfo(np.int32).max, np.int32)
        self._single = {
            name: np.full((count, width), NOTHING if name == "distance" else 0.0)
            for name, width in SINGLE_LAYERS.items()
            if name in layers
        }
        summed = {**MEAN_LAYERS, **END_LAYERS, DENSITY_LAYER: 1}
        self._sum = {
            name: np.zeros((count, width)) for name, width in summed.items() if name in layers
        }
        self._gathered = np.zeros(count if DENSITY_LAYER in layers else 0)
        self._mattes = {
            name: (np.zeros((count, ranks), np.float32), np.zeros((count, ranks)))
            for name in MATTE_LAYERS
            if name in layers
        }

    @property
    def nbytes(self) -> int:
        """Memory [bytes]."""
        parts: list[NDArray[Any]] = [self._count, self._ended, self._single_pass]
        parts.append(self._gathered)
        parts += [*self._single.values(), *self._sum.values()]
        parts += [array for pair in self._mattes.values() for array in pair]
        return sum(part.nbytes for part in parts)

    def add(self, i: int, part: NDArray[np.int32], rows: NDArray[np.void]) -> None:
        """Add pass ``i``'s ``rows`` (n,) ``FIRST_HIT`` to as many pixels ``part`` (n,).

        Like the film, a path with a NaN or infinity counts as one that saw nothing.
        """
        numbers = rows.view(np.float64).reshape(len(rows), -1)
        bad = ~np.isfinite(numbers).all(axis=1)
        if bad.any():
            rows = rows.copy()
            rows[bad] = 0
        self._count[part] += 1
        self._ended[part] += rows["ended"] > 0
        for name, total in self._sum.items():
            total[part] += rows[name].reshape(len(rows), -1)
        if DENSITY_LAYER in self.layers:
            self._gathered[part] += rows["gathered"]
        first = self._single_pass[part] > i
        self._single_pass[part[first]] = i
        known = rows["found"] > 0
        for name, single in self._single.items():
            nothing = NOTHING if name == "distance" else 0.0
            values = np.where(known[:, None], rows[name].reshape(len(rows), -1), nothing)
            single[part[first]] = values[first]
        for name, (numbers32, weights) in self._mattes.items():
            ranks = numbers32[part], weights[part]
            add_mattes(
                *ranks, rows[name].astype(np.float32),
                np.ascontiguousarray(rows["matte_weight"]),
            )  # fmt: skip
            numbers32[part], weights[part] = ranks

    def merge(self, other: FirstHits) -> None:
        """Add other passes of the same pixels and layers."""
        if other.layers != self.layers:
            raise ValueError(f"layers {self.layers} and {other.layers} cannot be merged")
        self._count += other._count
        self._ended += other._ended
        self._gathered += other._gathered
        for name, total in self._sum.items():
            total += other._sum[name]
        earlier = other._single_pass < self._single_pass
        self._single_pass[earlier] = other._single_pass[earlier]
        for name, single in self._single.items():
            single[earlier] = other._single[name][earlier]
        for name, (numbers, weights) in self._mattes.items():
            add_mattes(numbers, weights, *other._mattes[name])

    def resolve(self, layer: str) -> NDArray[np.float64] | NDArray[np.float32]:
        """A layer as (pixels, channels); raises ``ValueError`` when it was not asked for."""
        if layer not in self.layers:
            raise ValueError(f"layer '{layer}' was not rendered: ask for it in the settings")
        if layer in self._single:
            return self._single[layer]
        if layer in self._mattes:
            return ranked(*self._mattes[layer], self._count)
        total = self._sum[layer]
        if layer == DENSITY_LAYER:
            return total / np.where(self._gathered > 0.0, self._gathered, 1.0)[:, None]
        if layer in ("end_normal", "end_depth"):
            return total / np.maximum(self._ended, 1)[:, None]
        mean = total / np.maximum(self._count, 1)[:, None]
        return 1.0 - np.minimum(mean, 1.0) if layer == "mist" else mean
