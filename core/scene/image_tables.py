"""Collects images, their uses and texture coordinates for ``SceneBuilder``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .scene import SceneError
from .tables import IMAGE, TEXTURE, Extension, ImageKind

#: Coordinates as they are.
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


class ImageTables:
    """The tables ``images``, ``textures``, ``texels8`` and ``texels32`` of a scene."""

    def __init__(self) -> None:
        self._images: list[NDArray[np.void]] = []
        self._textures: list[NDArray[np.void]] = []
        self._bytes: list[NDArray[np.uint8]] = []
        self._floats: list[NDArray[np.float32]] = []

    def add_image(self, pixels: ArrayLike, kind: ImageKind) -> int:
        """Add texels (H, W, 4), the bottom row first; the image's row.

        Bytes as uint8, else float32; alpha is multiplied in where a use of the image does
        not say otherwise. Raises ``SceneError`` for another shape.
        """
        floats = kind in (ImageKind.FLOATS, ImageKind.SRGB_FLOATS)
        texels = np.asarray(pixels, dtype=np.float32 if floats else np.uint8)
        if texels.ndim != 3 or texels.shape[2] != 4 or not texels.size:
            raise SceneError(f"an image is {texels.shape}, it must be (height, width, 4)")
        if floats and not np.isfinite(texels).all():
            texels = np.nan_to_num(texels, nan=0.0, posinf=0.0, neginf=0.0)
        parts: list = self._floats if floats else self._bytes
        row = np.zeros((), IMAGE)
        row["start"] = sum(len(part) for part in parts)
        row["height"], row["width"] = texels.shape[:2]
        row["kind"] = int(kind)
        parts.append(texels.reshape(-1, 4))
        self._images.append(row)
        return len(self._images) - 1

    def add_texture(
        self,
        image: int,
        uv: int = 0,
        to_image: ArrayLike = IDENTITY,
        extension: Extension = Extension.REPEAT,
        closest: bool = False,
        unassociate: bool = False,
    ) -> int:
        """Add a use of ``image`` by the coordinates of set ``uv``; equal uses share a row."""
        row = np.zeros((), TEXTURE)
        row["image"], row["uv"], row["to_image"] = image, uv, np.asarray(to_image)
        row["extension"], row["interpolation"] = int(extension), int(closest)
        row["unassociate"] = int(unassociate)
        for k, other in enumerate(self._textures):
            if other.tobytes() == row.tobytes():
                return k
        self._textures.append(row)
        return len(self._textures) - 1

    def arrays(self) -> dict[str, NDArray]:
        """The tables by their names in ``Scene``."""
        return {
            "images": np.array(self._images, dtype=IMAGE),
            "textures": np.array(self._textures, dtype=TEXTURE),
            "texels8": _stack(self._bytes, np.dtype(np.uint8)),
            "texels32": _stack(self._floats, np.dtype(np.float32)),
        }


def _stack(parts: Sequence[NDArray], dtype: np.dtype) -> NDArray:
    return np.concatenate(parts) if parts else np.zeros((0, 4), dtype)


def stacked_uvs(parts: Sequence[NDArray[np.float32]]) -> NDArray[np.float32]:
    """Sets (K, F, 3, 2) of the whole scene from those of its meshes (k, f, 3, 2).

    A mesh with fewer sets than another has zeros in the rest.
    """
    most = max((len(part) for part in parts), default=0)
    faces = sum(part.shape[1] for part in parts)
    whole = np.zeros((most, faces, 3, 2), np.float32)
    start = 0
    for part in parts:
        whole[: len(part), start : start + part.shape[1]] = part
        start += part.shape[1]
    return whole
