"""The triangles as kernels see them: centred, float32, with what a hit needs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene.scene import Scene


class Mesh(NamedTuple):
    """Merged triangles around ``Centre.origin``.

    vertices (V, 3) f4; faces (F, 3) i4; normals (F, 3, 3) f4 or zeros where flat;
    smooth (F,) bool; material (F,) i4; visible (F,) i4 ``Visibility`` bits.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32]
    smooth: NDArray[np.bool_]
    material: NDArray[np.int32]
    visible: NDArray[np.int32]


class Centre(NamedTuple):
    """Where the centred scene lies: world = origin + centred, ``radius`` bounds it."""

    origin: NDArray[np.float64]
    radius: float


#: Median edge, relative to the scene's radius, below which the origin goes to the detail:
#: float32 would tilt such faces by more than 0.004 rad at the rim of the scene.
_FINE = 3e-5


def centre_of(scene: Scene) -> Centre:
    """Where rays are cut near the origin: float32 keeps 7 digits, wherever the scene stands.

    That is the middle of the scene's box (lights and camera left out); where most faces
    are tiny in a wide scene, the median of the vertices, which is among them. The radius
    bounds the scene about that point.
    """
    if len(scene.faces) == 0:
        return Centre(np.zeros(3), 1.0)
    used = scene.vertices[np.unique(scene.faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    origin = (low + high) / 2
    edge = scene.vertices[scene.faces[:, 1]] - scene.vertices[scene.faces[:, 0]]
    if np.median(np.linalg.norm(edge, axis=1)) < _FINE * np.linalg.norm(high - low) / 2:
        origin = np.median(used, axis=0)
    radius = float(np.sqrt(((used - origin) ** 2).sum(axis=1).max()))
    return Centre(origin, radius if radius > 0 else 1.0)


def centred_mesh(scene: Scene, centre: Centre) -> Mesh:
    """The scene's triangles relative to ``centre``."""
    if len(scene.faces) == 0:
        return _empty_mesh()
    return Mesh(
        vertices=np.ascontiguousarray(scene.vertices - centre.origin, dtype=np.float32),
        faces=np.ascontiguousarray(scene.faces),
        normals=np.ascontiguousarray(scene.corner_normals),
        smooth=np.abs(scene.corner_normals).sum(axis=2).min(axis=1) > 0,
        material=np.ascontiguousarray(scene.face_material),
        visible=scene.object_visibility[scene.face_object],
    )


def _empty_mesh() -> Mesh:
    """No triangle; kernels never index it because nothing is ever hit."""
    mesh = Mesh(
        vertices=np.zeros((0, 3), np.float32),
        faces=np.zeros((0, 3), np.int32),
        normals=np.zeros((0, 3, 3), np.float32),
        smooth=np.zeros(0, np.bool_),
        material=np.zeros(0, np.int32),
        visible=np.zeros(0, np.int32),
    )
    # As those of a scene are: kernels would be compiled once more for arrays to write to.
    for part in (mesh.faces, mesh.normals, mesh.material):
        part.setflags(write=False)
    return mesh
