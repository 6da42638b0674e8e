"""What a scene says of its objects, for the layers of data (``first_hit``)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..film.mattes import name_numbers
from ..scene.scene import Scene
from ..scene.tables import AOV


class FirstHitTables(NamedTuple):
    """Numbers of objects and materials; shapes as in ``Scene``.

    ``origin`` (3,): place of the centred scene; ``numbers_*``: what names are in mattes;
    ``aovs`` (A, M), ``world_aovs`` (A,): those that are asked for, in that order; what no
    material has is nowhere.
    """

    face_object: NDArray[np.int32]
    object_index: NDArray[np.int32]
    numbers_object: NDArray[np.float32]
    numbers_asset: NDArray[np.float32]
    numbers_material: NDArray[np.float32]
    origin: NDArray[np.float64]
    mist: NDArray[np.float64]
    shown_uv: int
    aovs: NDArray[np.void]
    world_aovs: NDArray[np.void]

    @staticmethod
    def of(
        scene: Scene, origin: NDArray[np.float64], aovs: tuple[str, ...] = ()
    ) -> FirstHitTables:
        """Copies for the kernels, which want writable arrays."""
        table = np.zeros((len(aovs), len(scene.materials)), AOV)
        world = np.zeros(len(aovs), AOV)
        for k, name in enumerate(aovs):
            if name in scene.aov_names:
                row = scene.aov_names.index(name)
                table[k], world[k] = scene.aovs[row], scene.world_aovs[row]
        return FirstHitTables(
            scene.face_object.copy(),
            scene.object_index.copy(),
            name_numbers(scene.object_names),
            name_numbers(scene.object_assets),
            name_numbers(scene.material_names),
            origin.copy(),
            scene.mist.copy(),
            int(scene.shown_uv[0]),
            table,
            world,
        )
