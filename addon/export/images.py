"""Blender's images to texels, as Cycles stores them.

Bytes stay bytes in their encoding, sRGB or linear; what Blender keeps as float (EXR, HDR,
16 bits) is scene-linear float32. Colours of images with an alpha channel are multiplied by
it, unless the image is data or its alpha mode says otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mathutils
import numpy as np
from numpy.typing import NDArray

from ...core.scene.image_tables import ImageTables
from ...core.scene.tables import ImageKind
from ..report import ExportLog
from .memory import ExportMemory

#: What stands for an image that is not there, as in Cycles.
MISSING = (1.0, 0.0, 1.0, 1.0)

#: Images above this many bytes are worth telling the user [MB].
_LARGE = 512.0

#: Names of the linear space that Blender works in, in its releases.
_LINEAR = ("Linear", "Linear Rec.709", "scene_linear", "linear")

#: Linear spaces of other primaries, and what of ``mathutils.Color`` converts from them.
_PRIMARIES = {
    "ACES2065-1": "from_aces_to_scene_linear",
    "ACEScg": "from_acescg_to_scene_linear",
    "Linear ACES": "from_aces_to_scene_linear",
    "Linear ACEScg": "from_acescg_to_scene_linear",
    "Linear Rec.2020": "from_rec2020_linear_to_scene_linear",
    "Linear CIE-XYZ D65": "from_xyz_d65_to_scene_linear",
}

#: Most texels that the mean colour is taken from.
_MEAN_TEXELS = 1 << 18


@dataclass(frozen=True, eq=False)
class StoredImage:
    """Row in the image table, whether alpha is multiplied in, and the mean colour (4,)."""

    row: int
    is_associated: bool
    mean: NDArray[np.float64]


class ImageTable:
    """Gives each image its row in ``pictures``, and converts it when first asked for."""

    def __init__(
        self, pictures: ImageTables, log: ExportLog, memory: ExportMemory | None = None
    ) -> None:
        self.memory = memory
        self.pictures = pictures
        self.log = log
        self._stored: dict[tuple[int | None, bool], StoredImage] = {}

    def image(self, node: Any, owner: str, flip_green: bool = False) -> StoredImage:
        """The image that the texture ``node`` of ``owner`` shows; magenta when missing.

        ``flip_green``: with its green channel inverted, for normal maps made for DirectX.
        """
        image = node.image
        if image is not None:
            self._warn_about(image, owner)
        if image is None or 0 in image.size or not len(image.pixels):
            name = "an image" if image is None else f"image '{image.name}'"
            where = "" if image is None or not image.filepath else f" ({image.filepath})"
            self.log.warn(
                f"{owner}: {name} of node '{node.label or node.name}' is missing{where}, it "
                "is magenta"
            )
            return self._store(
                (None, False), np.full((1, 1, 4), MISSING), ImageKind.FLOATS, False
            )
        key = (image.session_uid, flip_green)
        if key not in self._stored:
            self._convert(key, image, owner)
        return self._stored[key]

    def _read(self, image: Any) -> NDArray[np.float32]:
        pixels = self.memory.pixels(image) if self.memory is not None else None
        if pixels is None:
            pixels = read_pixels(image)
            if self.memory is not None:
                self.memory.keep_pixels(image, pixels)
        return pixels

    def _convert(self, key: tuple[int | None, bool], image: Any, owner: str) -> StoredImage:
        pixels = self._read(image)
        data = bool(image.colorspace_settings.is_data)
        associated = not data and image.alpha_mode not in ("NONE", "CHANNEL_PACKED")
        # Blender makes premultiplied bytes of a file straight when it loads them; Cycles
        # reads the file itself, but takes the bytes as they are from Blender when packed.
        from_file = image.source != "GENERATED" and not image.packed_file
        premultiplied = image.alpha_mode == "PREMUL"
        straight = associated and (from_file or not premultiplied)
        if image.alpha_mode == "NONE":
            pixels[..., 3] = 1.0
        if key[1]:
            pixels[..., 1] = 1.0 - pixels[..., 1]
        name = image.colorspace_settings.name
        if image.is_float:
            # Of a file in sRGB, 16 bits say, Cycles mixes the numbers in the file.
            encoded = from_file and name == "sRGB"
            if encoded:
                pixels[..., :3] = linear_to_srgb(pixels[..., :3])
            kind = ImageKind.SRGB_FLOATS if encoded else ImageKind.FLOATS
            return self._store(key, pixels, kind, associated)
        if name in _PRIMARIES:
            pixels[..., :3] = pixels[..., :3] @ primaries_matrix(name).T.astype(np.float32)
            if straight:
                pixels[..., :3] *= pixels[..., 3:]
            return self._store(key, pixels, ImageKind.FLOATS, associated)
        if not data and name not in ("sRGB", *_LINEAR):
            self.log.warn(
                f"{owner}: colour space '{name}' of image '{image.name}' is not supported, "
                "it is read as sRGB"
            )
        kind = ImageKind.BYTES if data or name in _LINEAR else ImageKind.SRGB_BYTES
        texels = np.clip(np.rint(pixels * 255.0), 0, 255).astype(np.uint8)
        if straight:  # rounded down, as Cycles does
            half = 127 if premultiplied else 0
            whole = texels[..., :3].astype(np.uint16) * texels[..., 3:] + half
            texels[..., :3] = whole // 255
        return self._store(key, texels, kind, associated)

    def _store(
        self, key: tuple[int | None, bool], pixels: NDArray, kind: ImageKind, associated: bool
    ) -> StoredImage:
        row = self.pictures.add_image(pixels, kind)
        self._stored[key] = StoredImage(row, associated, mean_color(pixels, kind))
        return self._stored[key]

    def _warn_about(self, image: Any, owner: str) -> None:
        """Say what is not shown of an image, or that it is very large."""
        what = {
            "TILED": "UDIM tiles are not supported yet, the first tile is shown everywhere",
            "MOVIE": "movies are not supported yet, one frame is shown if there is any",
            "SEQUENCE": "sequences are not supported yet, one frame is shown if there is any",
        }.get(image.source)
        if what:
            self.log.warn(f"{owner}: image '{image.name}': {what}")
        width, height = image.size
        megabytes = width * height * (16 if image.is_float else 4) / 1e6
        if megabytes > _LARGE:
            self.log.warn(
                f"image '{image.name}' of {width} x {height} takes {megabytes:.0f} MB of memory"
            )


def read_pixels(image: Any) -> NDArray[np.float32]:
    """Texels (H, W, 4) of an image as Blender stores them, the bottom row first."""
    width, height = image.size
    channels = len(image.pixels) // (width * height)
    flat = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(flat)
    stored = flat.reshape(height, width, channels)
    if channels == 4:
        return stored
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = stored[..., :3] if channels >= 3 else stored[..., :1]
    if channels == 2:
        pixels[..., 3] = stored[..., 1]
    return pixels


def linear_to_srgb(c: NDArray[np.float32]) -> NDArray[np.float32]:
    """Components encoded by the sRGB curve, 0 below 0."""
    c = np.maximum(c, 0.0)
    return np.where(c < 0.0031308, c * 12.92, 1.055 * c ** (1 / 2.4) - 0.055)


def primaries_matrix(name: str) -> NDArray[np.float64]:
    """Matrix (3, 3) from a linear colour space to Blender's own, by Blender's conversion."""
    columns = []
    for axis in np.eye(3):
        color = mathutils.Color(axis)
        columns.append(getattr(color, _PRIMARIES[name])())
    return np.array(columns, dtype=np.float64).T


def mean_color(pixels: NDArray, kind: ImageKind) -> NDArray[np.float64]:
    """Mean scene-linear colour and alpha (4,) of texels; large images are sampled."""
    flat = pixels.reshape(-1, 4)
    flat = flat[:: max(1, len(flat) // _MEAN_TEXELS)].astype(np.float64)
    if kind in (ImageKind.BYTES, ImageKind.SRGB_BYTES):
        flat /= 255.0
    if kind in (ImageKind.SRGB_BYTES, ImageKind.SRGB_FLOATS):
        c = flat[:, :3]
        flat[:, :3] = np.where(c < 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.nan_to_num(flat).mean(axis=0))
