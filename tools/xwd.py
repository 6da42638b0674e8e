"""Dumps of an X display, as `xwd` writes them."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np


def read_xwd(path: Path) -> np.ndarray:
    """Pixels (H, W, 3) uint8 of an X window dump of 24 or 32 bits."""
    data = path.read_bytes()
    head = struct.unpack(">25I", data[:100])
    start, width, height = head[0] + 12 * head[19], head[4], head[5]
    lines = np.frombuffer(data, np.uint8, head[12] * height, start).reshape(height, head[12])
    bytes_each = head[11] // 8
    pixels = lines[:, : width * bytes_each].reshape(height, width, bytes_each)
    return pixels[..., 2::-1] if head[7] == 0 else pixels[..., -3:]
