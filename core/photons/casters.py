"""Which materials cast caustics, and which ones show them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.scene import Scene
from ..scene.tables import SPECULAR_MODELS


def caster_materials(scene: Scene) -> NDArray[np.bool_]:
    """Which materials (M,) have a specular lobe of some weight."""
    return _with_lobes(scene, specular=True)


def receiver_materials(scene: Scene) -> NDArray[np.bool_]:
    """Which materials (M,) have a non-specular lobe of some weight."""
    return _with_lobes(scene, specular=False)


def _with_lobes(scene: Scene, specular: bool) -> NDArray[np.bool_]:
    found = np.zeros(len(scene.materials), np.bool_)
    for k, row in enumerate(scene.materials):
        lobes = scene.lobes[row["lobe_start"] : row["lobe_start"] + row["lobe_count"]]
        kind = np.isin(lobes["model"], SPECULAR_MODELS) == specular
        found[k] = bool((kind & (lobes["weight"].max(axis=1) > 0)).any())
    return found
