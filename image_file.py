"""Image files of the command line: linear EXR with every layer, plain sRGB PNG."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Channel names of a layer by its channel count; a layer not named here is a colour.
_CHANNELS = {
    "combined": "RGBA",
    "depth": "Z",
    "normal": "XYZ",
    "error": "V",
    "photon_density": "V",
}

#: Chromaticities (x, y) of red, green, blue and white of Rec. 709, Blender's linear space.
_REC709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)


class Frame(NamedTuple):
    """The whole image that a region belongs to, and where its lower left pixel lies there."""

    width: int
    height: int
    x: int
    y: int


def write_exr(
    path: str | os.PathLike[str],
    layers: Mapping[str, NDArray[np.float32]],
    metadata: Mapping[str, str],
    frame: Frame | None = None,
) -> None:
    """Write ``layers`` (h, w, c), row 0 at the bottom, as float32 scene-linear channels.

    ``combined`` becomes R G B A (premultiplied), ``depth`` ``depth.Z``, ``error``
    ``error.V``, ``photon_density`` ``photon_density.V``, ``normal`` ``normal.X/.Y/.Z``, every
    other layer ``<layer>.R/.G/.B``, and ``.A`` where it has four channels. ``metadata`` becomes
    string attributes. ``frame`` says where in a larger image the layers lie: they become the
    data window, and the larger image the display window.
    Raises ``OSError`` when the file cannot be written.
    """
    import OpenEXR

    channels: dict[str, NDArray[np.float32]] = {}
    for layer, pixels in layers.items():
        prefix = "" if layer == "combined" else f"{layer}."
        letters = _CHANNELS.get(layer, "RGBA" if pixels.shape[2:] == (4,) else "RGB")
        if pixels.ndim != 3 or pixels.shape[2] != len(letters):
            raise ValueError(f"layer '{layer}' of shape {pixels.shape}, wanted {letters}")
        for index, letter in enumerate(letters):
            plane = pixels[::-1, :, index].astype(np.float32)
            channels[prefix + letter] = np.ascontiguousarray(plane)
    header: dict[str, Any] = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "chromaticities": _REC709,
        **metadata,
    }
    if frame is not None:
        height, width = next(iter(layers.values())).shape[:2]
        left, top = frame.x, frame.height - frame.y - height
        header["dataWindow"] = _window(left, top, width, height)
        header["displayWindow"] = _window(0, 0, frame.width, frame.height)
    try:
        OpenEXR.File(header, channels).write(os.fspath(path))
    except RuntimeError as error:
        raise OSError(f"cannot write '{os.fspath(path)}': {error}") from error


def _window(left: int, top: int, width: int, height: int) -> tuple[NDArray, NDArray]:
    """First and last pixel, as EXR has it: rows count downwards."""
    first = np.array([left, top], dtype=np.int32)
    return first, first + np.array([width - 1, height - 1], dtype=np.int32)


def write_png(
    path: str | os.PathLike[str],
    combined: NDArray[np.float32],
    metadata: Mapping[str, str],
) -> None:
    """Write premultiplied linear ``combined`` (h, w, 4), row 0 at the bottom, as 8-bit sRGB.

    An alpha channel is written when some pixel is not opaque; colour is then divided by
    alpha, as PNG wants it. Raises ``OSError`` when the file cannot be written.
    """
    from PIL import Image, PngImagePlugin

    pixels = np.nan_to_num(combined[::-1].astype(np.float64), nan=0.0)
    alpha = pixels[..., 3:].clip(0.0, 1.0)
    covered = np.where(alpha > 0.0, alpha, 1.0)
    straight = np.concatenate((srgb(pixels[..., :3] / covered), alpha), axis=-1)
    bytes_ = np.rint(straight * 255.0).astype(np.uint8)
    if (bytes_[..., 3] == 255).all():
        bytes_ = bytes_[..., :3]
    text = PngImagePlugin.PngInfo()
    for key, value in metadata.items():
        text.add_text(key, value)
    Image.fromarray(np.ascontiguousarray(bytes_)).save(path, format="PNG", pnginfo=text)


def srgb(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """Display value in 0..1 of a linear one, clipped; IEC 61966-2-1, equation for sRGB."""
    value = linear.clip(0.0, 1.0)
    high = 1.055 * np.maximum(value, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(value <= 0.0031308, 12.92 * value, high)
