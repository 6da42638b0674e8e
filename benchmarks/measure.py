"""Linear images from and to EXR, and the error measure of every benchmark.

OpenEXR is imported where it is used: beside LuxCore's own copy the process would abort.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float64]


def read_exr(path: Path) -> Image:
    """Colour of an EXR as (h, w, 3), row 0 at the top.

    Takes the channels R G B, of a bare or of Blender's layered naming. Raises ``ValueError``
    when there is none.
    """
    import OpenEXR

    planes: dict[str, NDArray[np.generic]] = {}
    for name, channel in OpenEXR.File(str(path), separate_channels=True).channels().items():
        planes[name] = channel.pixels
    for prefix in ("", "ViewLayer.Combined.", "Combined.", "combined."):
        names = [prefix + letter for letter in "RGB"]
        if all(name in planes for name in names):
            return np.stack([planes[name] for name in names], axis=-1).astype(np.float64)
    raise ValueError(f"{path} has no R, G and B, only {', '.join(planes)}")


def write_exr(path: Path, image: Image, metadata: dict[str, str]) -> None:
    """Write (h, w, 3) as float32 channels R G B; the file appears whole or not at all."""
    import OpenEXR

    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        **metadata,
    }
    planes = {
        letter: np.ascontiguousarray(image[..., i], dtype=np.float32)
        for i, letter in enumerate("RGB")
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".part.exr")
    OpenEXR.File(header, planes).write(str(partial))
    partial.replace(path)


def weighted_square(square: Image, reference: Image) -> Image:
    """``square`` (a squared error or a variance) over ref^2 + 0.01 mean(ref)^2, per value."""
    weighted: Image = square / (reference**2 + 0.01 * reference.mean() ** 2)
    return weighted


def rel_mse(image: Image, reference: Image) -> float:
    """mean((x - ref)^2 / (ref^2 + 0.01 mean(ref)^2)), means over all pixels and channels."""
    if image.shape != reference.shape:
        raise ValueError(f"image {image.shape} and reference {reference.shape} differ in size")
    return float(weighted_square((image - reference) ** 2, reference).mean())
