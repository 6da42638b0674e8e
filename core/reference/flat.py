"""A ``Scene`` as the plain float64 tables that the reference kernels loop over."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..scene.scene import Scene
from .nodes import plain_tables

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: One triangle: first corner, the two edges from it, unit normal by winding, corner
#: normals, and the density per area with which light sampling picks its points.
FACE = np.dtype(
    [
        ("base", "f8", 3),
        ("edge_1", "f8", 3),
        ("edge_2", "f8", 3),
        ("normal", "f8", 3),
        ("corner_normal", "f8", 9),
        ("smooth", "i8"),
        ("material", "i8"),
        ("density", "f8"),
    ],
    align=True,
)

#: Consecutive faces that share one bounding box: the only acceleration there is.
GROUP = np.dtype([("low", "f8", 3), ("high", "f8", 3), ("start", "i8"), ("stop", "i8")])
GROUP_SIZE = 16


class Flat(NamedTuple):
    """The scene's tables; faces sorted into groups, ``emitter`` the ids of emissive ones."""

    faces: NDArray[np.void]  # FACE
    groups: NDArray[np.void]  # GROUP
    materials: NDArray[np.void]
    lobes: NDArray[np.void]
    bounces: Floats  # (lobes, 2, NODES, 3), factors for light between facets
    lamps: NDArray[np.void]
    emitter: Ints
    emitter_cdf: Floats
    sky: Floats
    sky_picture: NDArray[np.float32]
    sky_turn: Floats
    sky_visibility: int
    tiny: float  # no hit is nearer


def flatten(scene: Scene) -> Flat:
    """The tables of ``scene``."""
    order = _order(scene)
    corners = scene.vertices[scene.faces[order]]
    faces = np.zeros(len(order), FACE)
    faces["base"] = corners[:, 0]
    faces["edge_1"] = corners[:, 1] - corners[:, 0]
    faces["edge_2"] = corners[:, 2] - corners[:, 0]
    cross = np.cross(faces["edge_1"], faces["edge_2"])
    twice_area = np.linalg.norm(cross, axis=1)
    normals = scene.corner_normals[order].astype(np.float64)
    faces["normal"] = cross / twice_area[:, None]
    faces["corner_normal"] = normals.reshape(-1, 9)
    faces["smooth"] = (np.linalg.norm(normals, axis=2) > 0.5).all(axis=1)
    faces["material"] = scene.face_material[order]
    strength = scene.materials["emission"].mean(axis=1)[faces["material"]]
    emitter = np.flatnonzero(strength > 0)
    share = (strength * twice_area / 2)[emitter]
    if len(emitter):
        faces["density"][emitter] = strength[emitter] / share.sum()
    materials, lobes, bounces = plain_tables(scene)
    return Flat(
        faces=faces,
        groups=_groups(corners),
        materials=materials,
        lobes=lobes,
        bounces=bounces,
        lamps=scene.lights,
        emitter=emitter.astype(np.int64),
        emitter_cdf=np.cumsum(share) / share.sum() if len(emitter) else np.zeros(0),
        sky=scene.world,
        sky_picture=scene.world_map,
        sky_turn=scene.world_rotation,
        sky_visibility=int(scene.world_visibility[0]),
        tiny=1e-10 * float(np.ptp(corners.reshape(-1, 3), axis=0).max()) if len(faces) else 0.0,
    )


def _order(scene: Scene) -> Ints:
    """Faces by object and there along a Morton curve, so that a group's box stays small."""
    if not len(scene.faces):
        return np.zeros(0, np.int64)
    centre = scene.vertices[scene.faces].mean(axis=1)
    key = np.zeros(len(centre), np.int64)
    for part in range(int(scene.face_object.max()) + 1):
        rows = scene.face_object == part
        if not rows.any():
            continue
        span = np.maximum(np.ptp(centre[rows], axis=0), 1e-300)
        cell = ((centre[rows] - centre[rows].min(axis=0)) / span * 7.999).astype(np.int64)
        key[rows] = part * 512
        for axis in range(3):
            for bit in range(3):
                key[rows] += ((cell[:, axis] >> bit) & 1) << (3 * bit + axis)
    return np.argsort(key, kind="stable")


def _groups(corners: Floats) -> NDArray[np.void]:
    groups = np.zeros(-(-len(corners) // GROUP_SIZE), GROUP)
    for g, group in enumerate(groups):
        start, stop = g * GROUP_SIZE, min((g + 1) * GROUP_SIZE, len(corners))
        points = corners[start:stop].reshape(-1, 3)
        # Widened: rounding in the slab test must not lose a flat group.
        pad = 1e-9 * max(1e-300, float(np.abs(points).max()))
        group["low"], group["high"] = points.min(axis=0) - pad, points.max(axis=0) + pad
        group["start"], group["stop"] = start, stop
    return groups
