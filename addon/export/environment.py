"""Pictures of the surroundings: their texels, and how a direction looks them up."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: What Blender shows for an image that it does not find.
MAGENTA = (1.0, 0.0, 1.0)

#: Colour spaces whose values are light already.
_LINEAR = ("Linear Rec.709", "Linear", "Non-Color", "Raw")


@dataclass(frozen=True)
class Lookup:
    """A direction d looks a picture up with ``linear`` d + ``offset``; its length is free."""

    linear: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))
    offset: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))

    def rotation(self) -> NDArray[np.float64] | None:
        """The orthogonal matrix (3, 3) that does the same, None when there is none."""
        size = abs(float(np.linalg.det(self.linear))) ** (1.0 / 3.0)
        if self.offset.any() or size == 0:
            return None
        turn = self.linear / size
        return turn if np.allclose(turn @ turn.T, np.eye(3), atol=1e-6) else None


def image_texels(image: Any | None) -> NDArray[np.float32] | None:
    """Scene-linear colours (h, w, 3) of ``image``, the bottom row first; None: missing."""
    if image is None or image.size[0] == 0 or image.size[1] == 0 or len(image.pixels) == 0:
        return None
    width, height = image.size
    values = np.zeros(width * height * image.channels, np.float32)
    image.pixels.foreach_get(values)
    texels = values.reshape(height, width, image.channels)
    if image.channels < 3:
        texels = np.repeat(texels[:, :, :1], 3, axis=2)
    texels = texels[:, :, :3]
    if not image.is_float and image.colorspace_settings.name not in _LINEAR:
        texels = np.where(
            texels <= 0.04045, texels / 12.92, ((texels + 0.055) / 1.055) ** np.float32(2.4)
        )
    texels = np.nan_to_num(texels, nan=0.0, posinf=65504.0, neginf=0.0)
    return np.ascontiguousarray(np.maximum(texels, 0.0), dtype=np.float32)


def redrawn(
    texels: NDArray[np.float32], lookup: Lookup, mirror_ball: bool
) -> NDArray[np.float32]:
    """An equirectangular picture that shows what ``lookup`` finds in ``texels`` (h, w, 3)."""
    height = max(256, min(2048, texels.shape[0]))
    width = 2 * height
    azimuth = (0.5 - (np.arange(width) + 0.5) / width) * 2 * math.pi
    out = np.zeros((height, width, 3), np.float32)
    for row in range(height):
        latitude = ((row + 0.5) / height - 0.5) * math.pi
        directions = np.stack(
            [
                math.cos(latitude) * np.cos(azimuth),
                math.cos(latitude) * np.sin(azimuth),
                np.full(width, math.sin(latitude)),
            ]
        )
        q = lookup.linear @ directions + lookup.offset[:, None]
        q /= np.maximum(np.linalg.norm(q, axis=0), 1e-30)
        out[row] = bilinear(texels, *(on_ball(q) if mirror_ball else on_rectangle(q)))
    return out


def on_rectangle(q: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Place in [0, 1]^2 of unit vectors (3, n) on an equirectangular picture."""
    column = 0.5 - np.arctan2(q[1], q[0]) / (2 * math.pi)
    return column, 0.5 + np.arctan2(q[2], np.hypot(q[0], q[1])) / math.pi


def on_ball(q: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Place in [0, 1]^2 of unit vectors (3, n) on a mirror ball photographed along +y."""
    y = q[1] - 1.0
    size = np.maximum(2.0 * np.sqrt(np.maximum(-0.5 * y, 0.0)), 1e-12)
    return 0.5 * (q[0] / size + 1.0), 0.5 * (q[2] / size + 1.0)


def bilinear(
    texels: NDArray[np.float32], u: NDArray[np.float64], v: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Interpolated colours (n, 3) at places in [0, 1]^2; the picture repeats."""
    height, width = texels.shape[:2]
    x, y = u * width - 0.5, v * height - 0.5
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    s, t = (x - x0)[:, None], (y - y0)[:, None]
    a, b = x0 % width, (x0 + 1) % width
    c, d = y0 % height, (y0 + 1) % height
    low = texels[c, a] * (1 - s) + texels[c, b] * s
    high = texels[d, a] * (1 - s) + texels[d, b] * s
    colors: NDArray[np.float32] = (low * (1 - t) + high * t).astype(np.float32)
    return colors
