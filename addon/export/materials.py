"""Materials of the scene: one row of the core's table for each one in use."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.builder import SceneBuilder, diffuse
from ..report import ExportLog
from .nodes import NodeReader, shader_of, tree_of
from .shaders import ShaderFolder, Shading

#: Albedo of faces without a material, the one of Blender's new materials.
DEFAULT_ALBEDO = 0.8

#: Instead of a row: the material has no surface, its faces are not seen.
NO_SURFACE = -1


class MaterialTable:
    """Gives each material its row in ``builder``, and converts it when first asked for."""

    def __init__(self, builder: SceneBuilder, log: ExportLog, override: Any = None) -> None:
        self.builder = builder
        self.log = log
        self.override = override
        self._rows: dict[int | None, int] = {}
        self._refracting: set[int] = set()

    def row(self, material: Any | None) -> int:
        """The row of ``material``, None = the default grey; the view layer may override."""
        material = self.override or material
        key = None if material is None else material.original.session_uid
        if key not in self._rows:
            self._rows[key] = self._add(material)
        return self._rows[key]

    def face_rows(
        self, name: str, slots: list[Any | None], indices: NDArray[np.int32]
    ) -> NDArray[np.int32]:
        """Rows (F,) of the faces of object ``name`` from their material ``indices`` (F,).

        ``NO_SURFACE`` where a face only encloses a volume.
        """
        if not slots:
            return np.full(len(indices), self.row(None), np.int32)
        # As in Blender, an index past the end means the last slot.
        used = np.clip(indices, 0, len(slots) - 1)
        rows = np.zeros(len(slots), np.int32)
        for slot in np.unique(used):
            if slots[slot] is None and self.override is None:
                self.log.warn(
                    f"object '{name}': material slot {slot + 1} is empty, its faces are grey"
                )
            rows[slot] = self.row(slots[slot])
        return rows[used]

    def refracts(self, rows: NDArray[np.int32]) -> NDArray[np.bool_]:
        """Which of ``rows`` are materials that light passes through."""
        return np.isin(rows, list(self._refracting))

    def _add(self, material: Any | None) -> int:
        if material is None:
            return self.builder.add_material("(none)", [diffuse(DEFAULT_ALBEDO)])
        if only_volume(material):
            self.log.warn(
                f"material '{material.name}': volume is not supported yet, what has nothing "
                "else is left out"
            )
            return NO_SURFACE
        shading = fold_material(material, self.log)
        row = self.builder.add_material(material.name, shading.lobes, shading.emission)
        if any(lobe.ior > 0 for lobe in shading.lobes):
            self._refracting.add(row)
        return row


def only_volume(material: Any) -> bool:
    """Whether ``material`` has a volume and no surface, as fog and smoke have."""
    tree = tree_of(material)
    output = None if tree is None else tree.get_output_node("CYCLES")
    if output is None or shader_of(output.inputs["Surface"]) is not None:
        return False
    return shader_of(output.inputs["Volume"]) is not None


def fold_material(material: Any, log: ExportLog) -> Shading:
    """Lobes and emission of one material."""
    tree = tree_of(material)
    if tree is None:
        color = np.clip(np.array(material.diffuse_color[:3], dtype=np.float64), 0.0, 1.0)
        return Shading((diffuse(color),))
    owner = f"material '{material.name}'"
    output = tree.get_output_node("CYCLES")
    if output is None:
        log.warn(f"{owner} has no output node; it is black")
        return Shading()
    for name in ("Volume", "Displacement"):
        socket = output.inputs.get(name)
        if socket is not None and socket.is_linked:
            log.warn(f"{owner}: {name.lower()} is not supported yet and ignored")
    return ShaderFolder(NodeReader(owner, log)).fold(output.inputs["Surface"])
