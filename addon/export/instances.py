"""Walks the objects and instances of a depsgraph once, and adds what can be rendered."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.builder import SceneBuilder
from ...core.scene.tables import Visibility
from ..report import ExportLog
from .lights import add_light
from .materials import NO_SURFACE, MaterialTable
from .memory import ExportMemory
from .mesh import MeshArrays, open_faces, read_mesh
from .unsupported import warn_linking, warn_object
from .visibility import object_visibility

#: Types with a surface or a volume that cannot be rendered yet.
_UNSUPPORTED = {
    "CURVES": "hair curves are", "POINTCLOUD": "point clouds are", "VOLUME": "volumes are",
    "GPENCIL": "grease pencil is", "GREASEPENCIL": "grease pencil is",
}  # fmt: skip


class ExportCancelledError(Exception):
    """The user stopped the export."""


def add_objects(
    builder: SceneBuilder,
    depsgraph: Any,
    materials: MaterialTable,
    log: ExportLog,
    stopped: Callable[[], bool],
    memory: ExportMemory | None = None,
) -> None:
    """Add every visible mesh and lamp, each mesh converted once however often it appears.

    The depsgraph leaves out what is hidden from renders or from the view layer. It presents
    the surfaces of curves, texts and metaballs as instances of type MESH beside the objects
    themselves: taken from both, every face would lie on a twin. ``memory`` has the meshes of
    an earlier export. Raises ``ExportCancelledError`` when ``stopped()`` turns true.

    A final render runs beside the user's edits: what an evaluated object was made from may be
    deleted meanwhile, so nothing here asks for an ``original``.
    """
    meshes = _MeshCache(memory, depsgraph.mode == "RENDER")
    for instance in depsgraph.object_instances:
        if stopped():
            raise ExportCancelledError
        if not instance.show_self:
            continue
        obj = instance.object
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        if obj.type == "LIGHT":
            add_light(builder, obj, matrix, log)
            warn_linking(obj, log)
        elif obj.type == "MESH":
            warn_object(obj, log)
            parent = instance.parent if instance.is_instance else None
            seen_by = object_visibility(obj, depsgraph.view_layer_eval, parent)
            arrays, own = meshes.get(obj, bool(instance.is_instance))
            if arrays is not None and len(arrays.faces):
                _add_mesh(builder, obj, arrays, own, matrix, seen_by, materials, log)
        elif obj.type in _UNSUPPORTED:
            log.warn(f"object '{obj.name}' is left out: {_UNSUPPORTED[obj.type]} not supported")


def _add_mesh(
    builder: SceneBuilder,
    obj: Any,
    arrays: MeshArrays,
    mesh_materials: list[Any],
    matrix: NDArray[np.float64],
    seen_by: Visibility,
    materials: MaterialTable,
    log: ExportLog,
) -> None:
    if not np.isfinite(matrix).all():
        log.warn(f"object '{obj.name}' is left out: its transform is not finite")
        return
    slots = [slot.material for slot in obj.material_slots] or mesh_materials
    vertices, faces, normals = arrays.placed(matrix)
    rows = materials.face_rows(obj.name, slots, arrays.slots)
    # After the materials, which say what UV maps there are to be.
    uvs = arrays.placed_uvs(matrix, materials.pictures.uv_names)
    seen = rows != NO_SURFACE
    if not seen.all():
        faces, rows = faces[seen], rows[seen]
        normals = None if normals is None else normals[seen]
        uvs = None if uvs is None else uvs[:, seen]
    refracts = materials.refracts(rows)
    if refracts.any():
        # What encloses a volume alone is no wall of the glass.
        ends = arrays.open_faces if seen.all() else open_faces(arrays.vertices, faces)
        warn_open_glass(obj.name, ends & refracts, log)
    # A hole is a matter of the object: those faces become one of their own.
    held = materials.holds_out(rows)
    for part, bits in ((~held, seen_by), (held, seen_by | Visibility.HOLDOUT)):
        if not part.any():
            continue
        builder.add_mesh(
            obj.name,
            vertices,
            faces[part],
            rows[part],
            None if normals is None else normals[part],
            None if uvs is None else uvs[:, part],
            bits,
            asset=_root(obj).name,
            index=obj.pass_index,
        )


def warn_open_glass(name: str, ends: NDArray[np.bool_], log: ExportLog) -> None:
    """Warn when a surface that refracts has an open edge (``ends``: there and refracting).

    There is no telling inside from outside then: behind a single sheet of glass, all counts
    as in glass, and other things of the same glass vanish.
    """
    if ends.any():
        log.warn_group(
            "glass that is no closed body, all behind it counts as inside of it",
            f"object '{name}'",
        )


def _root(obj: Any) -> Any:
    """The object at the top of those that ``obj`` is parented to."""
    while obj.parent is not None:
        obj = obj.parent
    return obj


class _MeshCache:
    """Converted meshes by evaluated data, alive for one export; ``memory`` lives longer.

    ``in_place``: read evaluated meshes themselves, of which a viewport may have but the cage.
    """

    def __init__(self, memory: ExportMemory | None, in_place: bool) -> None:
        self._meshes: dict[int, tuple[MeshArrays | None, list[Any]]] = {}
        self._memory = memory
        self._in_place = in_place

    def get(self, obj: Any, is_instance: bool) -> tuple[MeshArrays | None, list[Any]]:
        """Arrays of ``obj`` (None without a surface) and its data's materials."""
        key = obj.data.as_pointer()
        if key not in self._meshes:
            self._meshes[key] = self._convert(obj, is_instance)
        return self._meshes[key]

    def _convert(self, obj: Any, is_instance: bool) -> tuple[MeshArrays | None, list[Any]]:
        # Instances may be made by nodes, from a mesh that has no object of its own.
        memory = None if is_instance else self._memory
        known = memory.mesh(obj) if memory is not None else None
        if known is not None:
            return known, list(obj.data.materials)
        if self._in_place and not obj.data.is_editmode:
            return read_mesh(obj.data), list(obj.data.materials)
        mesh = obj.to_mesh()
        if mesh is None:
            return None, []
        try:
            arrays = read_mesh(mesh)
            materials = list(mesh.materials)
        finally:
            obj.to_mesh_clear()
        if memory is not None:
            memory.keep_mesh(obj, arrays)
        return arrays, materials
