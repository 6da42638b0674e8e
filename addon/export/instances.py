"""Walks the objects and instances of a depsgraph once, and adds what can be rendered."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.builder import SceneBuilder
from ..report import ExportLog
from .lights import add_light
from .materials import MaterialTable
from .mesh import MESH_TYPES, MeshArrays, read_mesh

#: Types with a surface or a volume that cannot be rendered yet.
_UNSUPPORTED = ("CURVES", "POINTCLOUD", "VOLUME", "GPENCIL", "GREASEPENCIL")


class ExportCancelledError(Exception):
    """The user stopped the export."""


def add_objects(
    builder: SceneBuilder,
    depsgraph: Any,
    materials: MaterialTable,
    log: ExportLog,
    stopped: Callable[[], bool],
) -> None:
    """Add every visible mesh and lamp, each mesh converted once however often it appears.

    The depsgraph leaves out what is hidden from renders or from the view layer. Raises
    ``ExportCancelledError`` when ``stopped()`` turns true.
    """
    meshes = _MeshCache()
    for instance in depsgraph.object_instances:
        if stopped():
            raise ExportCancelledError
        if not instance.show_self:
            continue
        obj = instance.object
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        if obj.type == "LIGHT":
            add_light(builder, obj, matrix, log)
        elif obj.type in MESH_TYPES:
            _add_mesh(builder, obj, matrix, materials, meshes, log)
        elif obj.type in _UNSUPPORTED:
            log.warn(
                f"object '{obj.name}' is left out: {obj.type.lower()} is not supported yet"
            )


def _add_mesh(
    builder: SceneBuilder,
    obj: Any,
    matrix: NDArray[np.float64],
    materials: MaterialTable,
    meshes: _MeshCache,
    log: ExportLog,
) -> None:
    _warn_ignored(obj, log)
    arrays, mesh_materials = meshes.get(obj)
    if arrays is None or not len(arrays.faces):
        return
    if not np.isfinite(matrix).all():
        log.warn(f"object '{obj.name}' is left out: its transform is not finite")
        return
    slots = [slot.material for slot in obj.material_slots] or mesh_materials
    vertices, faces, normals = arrays.placed(matrix)
    rows = materials.face_rows(obj.name, slots, arrays.slots)
    builder.add_mesh(obj.name, vertices, faces, rows, normals)


class _MeshCache:
    """Converted meshes by evaluated data, alive for one export.

    Only meshes are shared: the surface of a curve also depends on its object's modifiers.
    """

    def __init__(self) -> None:
        self._meshes: dict[tuple[int, int], tuple[MeshArrays | None, list[Any]]] = {}

    def get(self, obj: Any) -> tuple[MeshArrays | None, list[Any]]:
        """Arrays of ``obj`` (None without a surface) and its data's materials."""
        owner = 0 if obj.type == "MESH" else obj.original.session_uid
        key = (obj.data.as_pointer(), owner)
        if key not in self._meshes:
            self._meshes[key] = self._convert(obj)
        return self._meshes[key]

    @staticmethod
    def _convert(obj: Any) -> tuple[MeshArrays | None, list[Any]]:
        mesh = obj.to_mesh()
        if mesh is None:
            return None, []
        try:
            return read_mesh(mesh), list(mesh.materials)
        finally:
            obj.to_mesh_clear()


def _warn_ignored(obj: Any, log: ExportLog) -> None:
    """Say which switches of the object have no effect."""
    name = f"object '{obj.name}'"
    flags = ("visible_camera", "visible_diffuse", "visible_glossy", "visible_transmission")
    if not all(getattr(obj, flag) for flag in (*flags, "visible_shadow")):
        log.warn_group("ray visibility is ignored for objects with faces", name)
    if obj.is_holdout or obj.is_shadow_catcher:
        log.warn_group("holdouts and shadow catchers are rendered as usual", name)
    if any(system.settings.render_type == "PATH" for system in obj.particle_systems):
        log.warn_group("hair is left out", name)
