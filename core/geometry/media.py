"""What a ray is inside of: a stack of dielectric materials.

A path's ``media`` holds material rows, innermost last, ``media_count`` of them. A mesh
that is left without having been entered (open, flipped, or the path began inside) is
taken as if the path had been inside it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..jit import Row, Table, kernel
from .intersector import Intersector
from .mesh import Mesh
from .vector import Vector

#: Deepest nesting that is told apart; a deeper medium is passed as if it were not there.
STACK = 8

#: Unit directions in which the surroundings of a point are explored: upwards, because open
#: water has no other surface.
_WAYS = tuple(
    np.array(way) / np.linalg.norm(way)
    for way in ((0.11, 0.07, 1.0), (0.9, 0.3, 1.0), (-0.5, -0.8, 1.0))
)


@kernel
def medium_around(materials: Table, path: Row, material: int, entering: bool) -> int:
    """Row of the medium on the far side of ``material``'s own one, -1 where there is none.

    Of overlapping media the one with the highest priority counts, of equals the innermost
    (Schmidt & Budge 2002, "Simple nested dielectrics in ray traced images").
    """
    own = -1
    if not entering:
        # The topmost entry of this material is the one being left.
        for k in range(path.media_count - 1, -1, -1):
            if path.media[k] == material:
                own = k
                break
    best = -1
    for k in range(path.media_count):
        row = path.media[k]
        if k != own and (best < 0 or materials[row].priority >= materials[best].priority):
            best = row
    return best


@kernel
def ior_around(materials: Table, path: Row, material: int, entering: bool) -> float:
    """Index on the far side of ``material``'s own medium at its surface."""
    row = medium_around(materials, path, material, entering)
    return 1.0 if row < 0 else materials[row].ior


@kernel
def is_hidden(materials: Table, path: Row, material: int, entering: bool) -> bool:
    """Whether the surface of ``material`` lies inside a medium that counts more.

    That is one of higher priority, or of the same if it was entered later than the one
    that is being left: the path is in that medium before and after.
    """
    if materials[material].ior <= 0.0:
        return False
    own = materials[material].priority
    for k in range(path.media_count - 1, -1, -1):
        row = path.media[k]
        if not entering and row == material:
            # What was entered before counts only by a higher priority.
            entering = True
        elif materials[row].priority > own:
            return True
        elif not entering and materials[row].priority == own and holds(path, k, material):
            return True
    return False


@kernel
def holds(path: Row, count: int, material: int) -> bool:
    """Whether ``material`` is among the first ``count`` media of ``path``."""
    for k in range(count):
        if path.media[k] == material:
            return True
    return False


@kernel
def transmittance(materials: Table, row: int, way: float) -> Vector:
    """What ``way`` [m] through the medium ``row`` (-1: none) leaves (Beer 1852)."""
    if row < 0:
        return 1.0, 1.0, 1.0
    a = materials[row].absorption
    return math.exp(-a[0] * way), math.exp(-a[1] * way), math.exp(-a[2] * way)


@kernel
def current_medium(materials: Table, path: Row) -> int:
    """Row of the medium that a path is in, -1 in the open."""
    return medium_around(materials, path, -1, True)


@kernel
def cross_surface(path: Row, material: int, entering: bool) -> None:
    """Push or remove ``material`` after a refraction through its surface."""
    if entering:
        if path.media_count < STACK:
            path.media[path.media_count] = material
            path.media_count += 1
        return
    for k in range(path.media_count - 1, -1, -1):
        if path.media[k] == material:
            for j in range(k, path.media_count - 1):
                path.media[j] = path.media[j + 1]
            path.media_count -= 1
            return


@kernel
def copy_media(target: Row, source: Row) -> None:
    """Copy a path's stack to another record."""
    target.media_count = source.media_count
    for k in range(source.media_count):
        target.media[k] = source.media[k]


def enclosing_media(
    intersector: Intersector,
    mesh: Mesh,
    materials: NDArray[np.void],
    point: NDArray[np.float64],
) -> list[int]:
    """Dielectrics around ``point`` (3,), outermost first: what a path from there is in.

    Walks along rays to the outside: a medium that is left more often than it was entered
    on the way lies around the point. All rays have to agree on a medium, or a pane
    somewhere above would count as a body of glass.
    """
    found = [_left_on_the_way(intersector, mesh, materials, point, d) for d in _WAYS]
    agreed = [row for row in found[0] if all(row in other for other in found)]
    return agreed[-STACK:]


def _left_on_the_way(
    intersector: Intersector,
    mesh: Mesh,
    materials: NDArray[np.void],
    point: NDArray[np.float64],
    direction: NDArray[np.float64],
) -> list[int]:
    """Media that a ray leaves without having entered them, last one first."""
    position = np.array(point, dtype=np.float64)
    balance: dict[int, int] = {}
    left: list[int] = []
    for _ in range(1024):
        hits = intersector.nearest(
            position[None].astype(np.float32), direction[None].astype(np.float32)
        )
        face = int(hits.face[0])
        if face < 0:
            break
        a, b, c = mesh.vertices[mesh.faces[face]].astype(np.float64)
        u, v = float(hits.u[0]), float(hits.v[0])
        hit = (1 - u - v) * a + u * b + v * c
        normal = np.cross(b - a, c - a)
        row = int(mesh.material[face])
        if materials["ior"][row] > 0:
            if normal @ direction > 0:
                if balance.get(row, 0) > 0:
                    balance[row] -= 1
                else:
                    left.append(row)
            else:
                balance[row] = balance.get(row, 0) + 1
        step = 2e-6 * max(np.abs(mesh.vertices[mesh.faces[face]]).max(), np.abs(hit).max())
        position = hit + direction * max(step, 1e-12)
    return left[::-1]
