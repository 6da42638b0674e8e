"""Puts a ``Scene`` together piece by piece; the exporter, scripts and tests use it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .camera_data import CameraData
from .closures import lets_pass, medium_of
from .image_tables import ImageTables, stacked_uvs
from .light_builder import LightBuilder, rgb
from .lobes import Lobe as Lobe
from .lobes import dielectric as dielectric
from .lobes import diffuse as diffuse
from .lobes import lobe_row
from .lobes import mirror as mirror
from .lobes import phong as phong
from .lobes import refraction as refraction
from .lobes import translucent as translucent
from .lobes import transparent as transparent
from .scene import Scene, SceneError
from .tables import (
    AOV,
    CLOSURE,
    LOBE,
    MATERIAL,
    Model,
    Visibility,
)


class SceneBuilder(LightBuilder):
    """Collects meshes, materials, lights and the camera; ``build`` freezes them.

    Faces that are degenerate (zero area, NaN or infinite corner) are dropped and counted
    in ``dropped_faces``: they cannot be seen, and would poison everything they touch.
    ``pictures`` takes images and textures, whose rows materials refer to.
    """

    def __init__(self, name: str = "scene") -> None:
        self.name = name
        self.dropped_faces = 0
        self.pictures = ImageTables()
        self._vertices: list[NDArray[np.float64]] = []
        self._faces: list[NDArray[np.int32]] = []
        self._normals: list[NDArray[np.float32]] = []
        self._uvs: list[NDArray[np.float32]] = []
        self._face_material: list[NDArray[np.int32]] = []
        self._face_object: list[NDArray[np.int32]] = []
        self._vertex_count = 0
        self._objects: list[str] = []
        self._assets: list[str] = []
        self._indices: list[int] = []
        self._visibility: list[int] = []
        self._materials: list[NDArray[np.void]] = []
        self._closures: list[np.void] = []
        self._material_names: list[str] = []
        self._aovs: list[dict[str, np.void]] = []
        self._world_aovs: dict[str, np.void] = {}
        self._lobes: list[tuple] = []
        super().__init__()
        self._shown_uv: int = -1
        self._mist: Sequence[float] = (0.0, 100.0, 1.0)
        self._camera: CameraData | None = None

    def add_material(
        self,
        name: str,
        lobes: Sequence[Lobe] = (),
        emission: ArrayLike = 0.0,
        closures: Sequence[np.void] = (),
        aovs: Mapping[str, np.void] | None = None,
        **others: Any,
    ) -> int:
        """Add a material that emits radiance ``emission``; its row.

        It is made of ``lobes``, or of ``closures`` (rows of ``tables.CLOSURE``) that are
        resolved at each hit. ``aovs``: rows of ``closures.param`` by the names of
        the user's own values. ``others``: more fields of ``tables.MATERIAL``, such as
        ``absorption``, ``priority``, or ``ior`` of the medium behind the surface (without
        it the index of the first refracting lobe or closure).
        """
        row = np.zeros((), MATERIAL)
        iors = [b.ior for b in lobes if b.model in (Model.DIELECTRIC, Model.REFRACTION)]
        iors += [medium_of(c) for c in closures if medium_of(c) > 0.0]
        values: dict[str, Any] = {
            "lobe_start": len(self._lobes),
            "lobe_count": len(lobes),
            "closure_start": len(self._closures),
            "closure_count": len(closures),
            "emission": rgb(emission),
            "ior": iors[0] if iors else 0.0,
            "passes": any(b.model == Model.TRANSPARENT for b in lobes)
            or any(lets_pass(c) for c in closures),
            "normal_texture": -1,
            "bump_texture": -1,
            **others,
        }
        for field_name, value in values.items():
            row[field_name] = value
        self._lobes += [lobe_row(b) for b in lobes]
        self._closures += list(closures)
        self._materials.append(row)
        self._material_names.append(name)
        self._aovs.append(dict(aovs or {}))
        return len(self._materials) - 1

    def add_mesh(
        self,
        name: str,
        vertices: ArrayLike,
        faces: ArrayLike,
        material: ArrayLike,
        corner_normals: ArrayLike | None = None,
        uvs: ArrayLike | None = None,
        visibility: Visibility = Visibility.ALL,
        asset: str = "",
        index: int = 0,
    ) -> None:
        """Add one object's triangles.

        vertices (V, 3) world metres; faces (F, 3); material: a row or one per face;
        corner_normals: (F, 3, 3) unit, zeros where flat, None for an all-flat mesh;
        uvs: (K, F, 3, 2) sets of texture coordinates, or one set (F, 3, 2);
        visibility: which rays see it; asset: what it is a part of, itself by default;
        index: a number of the user's.
        """
        points = np.asarray(vertices, dtype=np.float64).reshape(-1, 3)
        triangles = np.asarray(faces, dtype=np.int64).reshape(-1, 3)
        if triangles.size and (triangles.min() < 0 or triangles.max() >= len(points)):
            raise SceneError(f"object '{name}': a face uses a vertex that does not exist")
        rows = np.broadcast_to(np.asarray(material, dtype=np.int32), (len(triangles),))
        normals = (
            np.zeros((len(triangles), 3, 3), np.float32)
            if corner_normals is None
            else np.asarray(corner_normals, dtype=np.float32).reshape(-1, 3, 3)
        )
        if len(normals) != len(triangles):
            raise SceneError(f"object '{name}': one normal per face corner is needed")
        sets = np.zeros((0, len(triangles), 3, 2)) if uvs is None else np.asarray(uvs)
        sets = sets[None] if sets.ndim == 3 else sets
        if sets.shape[1:] != (len(triangles), 3, 2):
            raise SceneError(f"object '{name}': one coordinate per face corner is needed")
        good = _well_formed(points, triangles)
        self.dropped_faces += int(len(good) - good.sum())
        triangles, rows, normals = triangles[good], rows[good], normals[good]
        normals = np.where(np.isfinite(normals).all(axis=(1, 2), keepdims=True), normals, 0)
        points = np.where(np.isfinite(points).all(axis=1, keepdims=True), points, 0.0)
        self._vertices.append(points)
        self._faces.append((triangles + self._vertex_count).astype(np.int32))
        self._normals.append(normals.astype(np.float32))
        self._uvs.append(np.where(np.isfinite(sets), sets, 0)[:, good].astype(np.float32))
        self._face_material.append(rows.astype(np.int32))
        self._face_object.append(np.full(len(triangles), len(self._objects), np.int32))
        self._objects.append(name)
        self._assets.append(asset or name)
        self._indices.append(index)
        self._visibility.append(int(visibility))
        self._vertex_count += len(points)

    def set_shown(self, uv: int, mist: Sequence[float]) -> None:
        """The set of coordinates and the mist (start, depth, exponent) of their layers."""
        self._shown_uv, self._mist = uv, mist

    def set_world_aovs(self, values: Mapping[str, np.void]) -> None:
        """Values of the user's own of the surroundings, as of a material; no textures."""
        self._world_aovs = dict(values)

    def set_camera(self, camera: CameraData) -> None:
        """The camera to render with."""
        self._camera = camera

    def build(self) -> Scene:
        """The frozen scene; raises ``SceneError`` when something does not fit."""
        others: dict[str, Any] = {**self.pictures.arrays(), **self.light_tables()}
        told = (*self._aovs, self._world_aovs)
        names = tuple(sorted({name for values in told for name in values}))
        return Scene(
            name=self.name,
            vertices=_stack(self._vertices, (0, 3), np.float64),
            faces=_stack(self._faces, (0, 3), np.int32),
            corner_normals=_stack(self._normals, (0, 3, 3), np.float32),
            face_material=_stack(self._face_material, (0,), np.int32),
            face_object=_stack(self._face_object, (0,), np.int32),
            materials=np.array(self._materials, dtype=MATERIAL),
            closures=np.array(self._closures, dtype=CLOSURE),
            uvs=stacked_uvs(self._uvs),
            lobes=np.array(self._lobes, dtype=LOBE),
            camera=self._camera,
            object_visibility=np.array(self._visibility, dtype=np.int32),
            object_index=np.array(self._indices, dtype=np.int32),
            shown_uv=np.array([self._shown_uv], dtype=np.int32),
            mist=np.array(self._mist, dtype=np.float64),
            object_names=tuple(self._objects),
            object_assets=tuple(self._assets),
            material_names=tuple(self._material_names),
            aovs=_aov_table(names, self._aovs),
            world_aovs=_aov_table(names, [self._world_aovs])[:, 0].copy(),
            aov_names=names,
            **others,
        )


def _aov_table(names: Sequence[str], owners: Sequence[Mapping[str, np.void]]) -> NDArray:
    """Rows (A, n) of ``tables.AOV`` for what each of n materials has."""
    table = np.zeros((len(names), len(owners)), AOV)
    table["param"]["texture"] = -1
    for k, values in enumerate(owners):
        for name, value in values.items():
            table[names.index(name), k] = (value, 1)
    return table


def _stack(parts: list, empty: tuple[int, ...], dtype: type) -> NDArray:
    return np.concatenate(parts) if parts else np.zeros(empty, dtype)


def _well_formed(points: NDArray, triangles: NDArray) -> NDArray[np.bool_]:
    """Which triangles have finite corners and an area above rounding."""
    corners = points[triangles]
    finite = np.isfinite(corners).all(axis=(1, 2))
    corners = np.where(finite[:, None, None], corners, 0.0)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return finite & (np.linalg.norm(cross, axis=1) > 0)
