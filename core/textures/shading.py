"""Everything that kernels need to know what a surface is like at a hit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bsdf.albedo import AlbedoTables, shading_albedo
from ..scene.scene import Scene


class ShadingTables(NamedTuple):
    """The scene's tables of what varies over a surface; shapes as in ``Scene``."""

    closures: NDArray[np.void]
    textures: NDArray[np.void]
    images: NDArray[np.void]
    texels8: NDArray[np.uint8]
    texels32: NDArray[np.float32]
    uvs: NDArray[np.float32]
    albedo: AlbedoTables


def shading_tables(scene: Scene) -> ShadingTables:
    """Copies for the kernels, which want writable arrays."""
    return ShadingTables(
        closures=scene.closures.copy(),
        textures=scene.textures.copy(),
        images=scene.images.copy(),
        texels8=scene.texels8.copy(),
        texels32=scene.texels32.copy(),
        uvs=scene.uvs.copy(),
        albedo=shading_albedo(len(scene.closures)),
    )
