"""Which pixels are rendered, and by which of their paths."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene.camera_data import CameraData
from ..settings import Settings


class Region(NamedTuple):
    """The pixels that are rendered: corner, size, and the width of the whole image."""

    x0: int
    y0: int
    width: int
    height: int
    image_width: int

    @staticmethod
    def of(camera: CameraData, settings: Settings) -> Region:
        """The border of ``settings`` cut to the image of ``camera``, or all of it."""
        x0, y0, x1, y1 = settings.region or (0, 0, camera.width, camera.height)
        x1, y1 = min(x1, camera.width), min(y1, camera.height)
        return Region(x0, y0, max(0, x1 - x0), max(0, y1 - y0), camera.width)


class Pixels(NamedTuple):
    """Camera paths: the pixel of the region that each begins in, and which of its paths it is.

    ``ids`` (n,) i4, ascending, a pixel as often as it has paths. ``numbers`` (n,) i4: the
    pass that a path would belong to if each pass had one of the pixel, so that the points of
    one replicate follow each other without a gap.
    """

    ids: NDArray[np.int32]
    numbers: NDArray[np.int32]

    @staticmethod
    def spread(i: int, count: int, start: int = 0, stride: int = 1) -> Pixels:
        """Path ``i`` of ``count`` pixels from ``start`` by ``stride``."""
        ids = start + stride * np.arange(count, dtype=np.int32)
        return Pixels(ids.astype(np.int32), np.full(count, i, np.int32))

    @property
    def paths(self) -> int:
        """How many paths there are."""
        return len(self.ids)
