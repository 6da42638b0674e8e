"""Meshes as kernels see them, from vertices and faces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from photon_map.core.geometry.borders import Borders, border_sides, borders_of
from photon_map.core.geometry.intersector import Intersector
from photon_map.core.geometry.mesh import Mesh
from photon_map.core.geometry.surfaces import Surfaces


def mesh_of(vertices: ArrayLike, faces: ArrayLike) -> Mesh:
    """A flat mesh that all rays see."""
    faces = np.asarray(faces, np.int32)
    count = len(faces)
    return Mesh(
        vertices=np.asarray(vertices, np.float32),
        faces=faces,
        normals=np.zeros((count, 3, 3), np.float32),
        smooth=np.zeros(count, np.bool_),
        material=np.zeros(count, np.int32),
        visible=np.full(count, 31, np.int32),
    )


def joined(*parts: tuple[ArrayLike, ArrayLike]) -> Mesh:
    """One mesh of (vertices, faces) pairs that share no corner."""
    starts = np.cumsum([0, *(len(np.asarray(vertices)) for vertices, _ in parts)])
    faces = [
        np.asarray(faces) + start for (_, faces), start in zip(parts, starts, strict=False)
    ]
    return mesh_of(np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces))


def all_borders(
    mesh: Mesh, longest: float, most: int = 10**6, holds: ArrayLike | None = None
) -> Borders:
    """``borders_of`` of the faces that ``holds``: all of them when it is None."""
    chosen = np.ones(len(mesh.faces), np.bool_) if holds is None else np.asarray(holds, bool)
    sides = border_sides(surfaces_of(mesh), chosen)
    return borders_of(mesh, sides, chosen, Intersector(mesh), longest, most)


def surfaces_of(mesh: Mesh, parts: Sequence[int] = ()) -> Surfaces:
    """``Surfaces`` of objects of ``parts`` faces each: of one object when there are none."""
    counts = list(parts) or [len(mesh.faces)]
    return Surfaces(mesh, np.repeat(np.arange(len(counts), dtype=np.int32), counts))
