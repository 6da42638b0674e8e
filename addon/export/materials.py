"""Materials of the scene: one row of the core's table for each one in use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.builder import SceneBuilder, diffuse
from ..report import ExportLog
from .aovs import material_aovs
from .folding import ShaderFolder, Shading
from .memory import ExportMemory
from .nodes import shader_of
from .pictures import PictureTable
from .trees import tree_of
from .values import ValueReader
from .volumes import absorption

#: Albedo of faces without a material, the one of Blender's new materials.
DEFAULT_ALBEDO = 0.8

#: Instead of a row: the material has no surface, its faces are not seen.
NO_SURFACE = -1


class MaterialTable:
    """Gives each material its row in ``builder``, and converts it when first asked for."""

    def __init__(
        self,
        builder: SceneBuilder,
        log: ExportLog,
        override: Any = None,
        memory: ExportMemory | None = None,
        aovs: Mapping[str, str] | None = None,
    ) -> None:
        self.builder = builder
        self.log = log
        self.override = override
        self.aovs = aovs or {}
        self.pictures = PictureTable(builder, log, memory)
        self._rows: dict[int | None, int] = {}
        self._refracting: set[int] = set()
        self._holdouts: set[int] = set()

    def row(self, material: Any | None) -> int:
        """The row of ``material``, None = the default grey; the view layer may override."""
        material = self.override or material
        key = None if material is None else material.as_pointer()
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

    def holds_out(self, rows: NDArray[np.int32]) -> NDArray[np.bool_]:
        """Which of ``rows`` are materials that are holes in the picture."""
        return np.isin(rows, list(self._holdouts))

    def _add(self, material: Any | None) -> int:
        if material is None:
            return self.builder.add_material("(none)", [diffuse(DEFAULT_ALBEDO)])
        if only_volume(material):
            self.log.warn(
                f"material '{material.name}': volume is not supported yet, what has nothing "
                "else is left out"
            )
            return NO_SURFACE
        tree = tree_of(material)
        if tree is None:
            color = np.clip(np.array(material.diffuse_color[:3], dtype=np.float64), 0.0, 1.0)
            return self.builder.add_material(
                material.name, [diffuse(color)], index=material.pass_index
            )
        return self._add_shaders(material, tree, tree.get_output_node("CYCLES"))

    def _add_shaders(self, material: Any, tree: Any, output: Any | None) -> int:
        """Add a material by its nodes: as constant lobes where they say all there is."""
        name, owner = material.name, f"material '{material.name}'"
        if output is None:
            self.log.warn(f"{owner} has no output node; it is black")
            return self.builder.add_material(name, index=material.pass_index)
        displacement = output.inputs.get("Displacement")
        if displacement is not None and displacement.is_linked:
            self.log.warn(f"{owner}: displacement is not supported yet and ignored")
        reader = ValueReader(owner, self.log, self.pictures)
        shading = ShaderFolder(reader).fold(output.inputs["Surface"])
        others = self._body(reader, material, shading, output.inputs.get("Volume"))
        others["aovs"] = material_aovs(reader, tree, self.aovs)
        lobes = shading.lobes()
        if lobes is not None:
            row = self.builder.add_material(name, lobes, shading.emission, **others)
        else:
            others |= self._normal(owner, shading)
            row = self.builder.add_material(
                name,
                emission=shading.emission,
                closures=shading.rows(),
                passes=shading.passes,
                **others,
            )
        if shading.ior > 0:
            self._refracting.add(row)
        if shading.is_holdout:
            self._holdouts.add(row)
        elif shading.holdouts:
            self.log.warn(
                f"{owner}: Holdout cuts no hole where it is mixed with something, its part is "
                "black"
            )
        return row

    def _body(
        self, reader: ValueReader, material: Any, shading: Shading, volume: Any | None
    ) -> dict[str, Any]:
        """What fills the space behind the surface."""
        inside = np.zeros(3) if volume is None else absorption(reader, volume)
        if inside.any() and not shading.ior > 0:
            self.log.warn(
                f"{reader.owner}: volume absorption is ignored, its surface has to refract"
            )
            inside = np.zeros(3)
        own = getattr(material, "photon_map", None)
        return {
            "ior": shading.ior,
            "absorption": inside,
            "priority": 0 if own is None else own.priority,
            "index": material.pass_index,
        }

    def _normal(self, owner: str, shading: Shading) -> dict[str, Any]:
        """Fields of the bent normal: that of the first shader which has one."""
        bent = [normal for normal in shading.normals if normal is not None]
        if not bent:
            return {}
        if len(shading.normals) > 1:
            self.log.warn(f"{owner}: its shaders' normals differ, all get that of the first")
        return asdict(bent[0])


def only_volume(material: Any) -> bool:
    """Whether ``material`` has a volume and no surface, as fog and smoke have."""
    tree = tree_of(material)
    output = None if tree is None else tree.get_output_node("CYCLES")
    if output is None or shader_of(output.inputs["Surface"]) is not None:
        return False
    return shader_of(output.inputs["Volume"]) is not None
