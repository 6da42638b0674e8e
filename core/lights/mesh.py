"""Emissive faces: all of them together are one light, chosen by emitted power."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bsdf.resolve import emitted_at
from ..geometry.mesh import Mesh
from ..geometry.triangles import normals_and_areas
from ..geometry.vector import Vector, cross, normalize, read, subtract, vector
from ..jit import Row, Table, kernel
from ..sampling.distributions import cumulative, sample_discrete
from ..sampling.warps import sample_triangle


class Emitters(NamedTuple):
    """Faces (E,) i4 that emit, their cumulative power, and its sum over both sides' mean.

    ``power`` is the sum of area times mean radiance, so a face's ``pdf_a`` is its mean
    radiance divided by ``power``.
    """

    faces: NDArray[np.int32]
    cdf: NDArray[np.float64]
    power: float


def emitters_of(mesh: Mesh, materials: NDArray[np.void]) -> Emitters:
    """Collect the faces whose material emits."""
    radiance = materials["emission"].mean(axis=1) if len(materials) else np.zeros(0)
    shining = np.flatnonzero(radiance > 0)
    faces = np.flatnonzero(np.isin(mesh.material, shining)).astype(np.int32)
    corners = mesh.vertices[mesh.faces[faces]].astype(np.float64)
    weight = normals_and_areas(corners)[1] * radiance[mesh.material[faces]]
    return Emitters(faces, cumulative(weight), float(weight.sum()))


@kernel
def sample_emitter(
    mesh: Row, emitters: Row, u_face: float, u: float, v: float
) -> tuple[int, Vector]:
    """A face by power and a point uniform on it (by the map ``sample_triangle``)."""
    face = emitters.faces[sample_discrete(emitters.cdf, u_face)]
    a = read(mesh.vertices, mesh.faces[face, 0])
    b = read(mesh.vertices, mesh.faces[face, 1])
    c = read(mesh.vertices, mesh.faces[face, 2])
    s, t = sample_triangle(u, v)
    w = 1.0 - s - t
    p = (
        w * a[0] + s * b[0] + t * c[0],
        w * a[1] + s * b[1] + t * c[1],
        w * a[2] + s * b[2] + t * c[2],
    )
    return face, p


@kernel
def glow(materials: Table, shading: Row, mesh: Row, face: int, u: float, v: float) -> Vector:
    """Radiance of a face at the weights ``u``, ``v`` of its second and third corner."""
    material = materials[mesh.material[face]]
    if material.closure_count == 0:
        return vector(material.emission)
    return emitted_at(material, shading, face, u, v)


@kernel
def face_normal(mesh: Row, face: int) -> Vector:
    """Unit geometric normal by winding."""
    a = read(mesh.vertices, mesh.faces[face, 0])
    b = read(mesh.vertices, mesh.faces[face, 1])
    c = read(mesh.vertices, mesh.faces[face, 2])
    return normalize(cross(subtract(b, a), subtract(c, a)))


@kernel
def pdf_area(materials: Table, emitters: Row, material: int) -> float:
    """``pdf_a`` of a point on a face of ``material``."""
    if emitters.power <= 0.0:
        return 0.0
    e = materials[material].emission
    return (e[0] + e[1] + e[2]) / 3.0 / emitters.power
