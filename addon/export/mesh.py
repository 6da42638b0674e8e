"""Evaluated geometry of one object as arrays in its own space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class MeshArrays:
    """Triangles in object space: vertices (V, 3) float64, faces (F, 3) int32, material
    slot (F,) int32, corner_normals (F, 3, 3) float64 with zeros where a face is flat; uvs:
    (F, 3, 2) float32 by the name of the UV map, "" for the one active for rendering."""

    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    slots: NDArray[np.int32]
    corner_normals: NDArray[np.float64] | None
    uvs: dict[str, NDArray[np.float32]] = field(default_factory=dict)

    @cached_property
    def open_faces(self) -> NDArray[np.bool_]:
        """Faces (F,) with an open edge."""
        return open_faces(self.vertices, self.faces)

    def placed_uvs(
        self, matrix: NDArray[np.float64], names: Sequence[str]
    ) -> NDArray[np.float32] | None:
        """Coordinates (K, F, 3, 2) of the UV maps ``names``, corners as ``placed`` has them.

        Zeros for a map that the mesh does not have, None without any names.
        """
        if not names:
            return None
        none = np.zeros((len(self.faces), 3, 2), np.float32)
        sets = np.stack([self.uvs.get(name, none) for name in names])
        mirrored = bool(np.linalg.det(matrix[:3, :3]) < 0)
        return sets[:, :, [0, 2, 1]] if mirrored else sets

    def placed(
        self, matrix: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64] | None]:
        """World-space vertices, faces and corner normals under ``matrix`` (4, 4).

        A mirroring matrix turns triangles inside out, so their winding is swapped back.
        Normals go by the cofactor matrix: the inverse transpose up to a positive factor
        where there is one, and still right when the object is scaled flat.
        """
        linear = matrix[:3, :3]
        vertices = self.vertices @ linear.T + matrix[:3, 3]
        mirrored = bool(np.linalg.det(linear) < 0)
        order = [0, 2, 1] if mirrored else [0, 1, 2]
        faces = np.ascontiguousarray(self.faces[:, order])
        if self.corner_normals is None:
            return vertices, faces, None
        cofactor = _cofactor(linear) * (-1.0 if mirrored else 1.0)
        normals = self.corner_normals[:, order] @ cofactor.T
        length = np.linalg.norm(normals, axis=2, keepdims=True)
        return (
            vertices,
            faces,
            np.divide(normals, length, np.zeros_like(normals), where=length > 0),
        )


def open_faces(vertices: NDArray[np.float64], faces: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Which faces have an edge that an odd number of faces share; seams count as welded."""
    _, welded = np.unique(vertices, axis=0, return_inverse=True)
    corners = welded.reshape(-1)[faces]
    edges = np.sort(
        np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    )
    _, edge, uses = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    odd: NDArray[np.bool_] = (uses[edge.reshape(-1)] % 2 == 1).reshape(3, -1).any(axis=0)
    return odd


def _cofactor(m: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([np.cross(m[1], m[2]), np.cross(m[2], m[0]), np.cross(m[0], m[1])])


def read_mesh(mesh: Any) -> MeshArrays:
    """Copy the triangles of a Blender mesh."""
    vertices = _read(mesh.vertices, "co", 3, np.float32).astype(np.float64)
    triangles = mesh.loop_triangles
    faces = _read(triangles, "vertices", 3, np.int32)
    slots = _read(triangles, "material_index", 1, np.int32).reshape(-1)
    return MeshArrays(vertices, faces, slots, _corner_normals(mesh), _uv_maps(mesh))


def _uv_maps(mesh: Any) -> dict[str, NDArray[np.float32]]:
    """Coordinates (F, 3, 2) of every UV map by name, and of the active one by ""."""
    if not len(mesh.uv_layers):
        return {}
    loops = _read(mesh.loop_triangles, "loops", 3, np.int32)
    maps: dict[str, NDArray[np.float32]] = {}
    for layer in mesh.uv_layers:
        maps[layer.name] = _read(layer.uv, "vector", 2, np.float32)[loops]
        if layer.active_render:
            maps[""] = maps[layer.name]
    return maps


def _corner_normals(mesh: Any) -> NDArray[np.float64] | None:
    """Shading normals of the triangles' corners, None when every face is flat."""
    custom = mesh.has_custom_normals
    if mesh.normals_domain == "FACE" and not custom:
        return None
    triangles = mesh.loop_triangles
    flat = ~_read(triangles, "use_smooth", 1, np.bool_).reshape(-1)
    if custom:  # they may bend flat faces too
        flat[:] = False
    if flat.all():
        return None
    loops = _read(triangles, "loops", 3, np.int32)
    vectors = _read(mesh.corner_normals, "vector", 3, np.float32).astype(np.float64)
    normals = vectors[loops]
    normals[flat] = 0.0
    return normals


def _read(collection: Any, name: str, width: int, dtype: Any) -> NDArray[Any]:
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width)
