"""How far what the camera sees moves in the image, from frame to frame."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..film.film import Film
from ..geometry.mesh import Centre
from ..scene.camera_data import CameraData
from ..scene.scene import Scene
from .perspective import camera_tables

#: The film's layer that this is worked out from.
PLACE_LAYER = "place"


def motion_vectors(
    film: Film, scene: Scene, before: Scene, after: Scene
) -> NDArray[np.float32]:
    """Pixels (h, w, 4) that each place of ``film``'s image has gone and will go, (x, y) each.

    From its pixel in the frame ``before`` towards that in ``scene``: the older place minus
    the one of now, then the one of now minus the next, as Cycles has it. Zeros where nothing
    is seen. What the other frame does not have with as many faces counts as at rest there.
    """
    place = film.resolve(PLACE_LAYER).reshape(-1, 3)
    found = np.zeros((len(place), 4), np.float32)
    seen = np.flatnonzero(place[:, 0] > 0)
    if len(seen):
        faces = place[seen, 0].astype(np.int64) - 1
        u, v = place[seen, 1].astype(np.float64), place[seen, 2].astype(np.float64)
        now = places_on(scene, faces, u, v)
        middle = raster(_camera(scene), now)
        for k, (other, sign) in enumerate(((before, 1.0), (after, -1.0))):
            there = now.copy()
            same = same_faces(scene, other)[faces]
            kept = same >= 0
            there[kept] = places_on(other, same[kept], u[kept], v[kept])
            found[seen, 2 * k : 2 * k + 2] = sign * (raster(_camera(other), there) - middle)
    return found.reshape(film.height, film.width, 4)


def raster(camera: CameraData, places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels (N, 2) from the bottom left at which ``camera`` sees ``places`` (N, 3) [world].

    Meaningless in the plane of the camera itself, but finite.
    """
    tables = camera_tables(camera, Centre(np.zeros(3), 1.0), np.zeros((2, 0)))
    right, up, forward = ((places - tables.position) @ tables.axes.T).T
    far = np.ones_like(forward) if tables.orthographic else forward
    far = np.where(np.abs(far) < 1e-12, 1e-12, far)
    x = (right / far - tables.left) / tables.step_x
    y = (up / far - tables.bottom) / tables.step_y
    return np.column_stack([x, y])


def places_on(
    scene: Scene, faces: NDArray[np.int64], u: NDArray[np.float64], v: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Points (N, 3) of ``faces`` (N,); ``u``, ``v``: barycentrics of corners 1 and 2."""
    corners = scene.vertices[scene.faces[faces]]
    weights = np.column_stack([1.0 - u - v, u, v])
    points: NDArray[np.float64] = np.einsum("nj,njc->nc", weights, corners)
    return points


def same_faces(scene: Scene, other: Scene) -> NDArray[np.int64]:
    """The number (F,) in ``other`` of each face of ``scene``, -1 where it has none.

    Objects are the same that have one name, the first of it the first there, and as many
    faces.
    """
    there = {key: (start, count) for key, start, count in _objects(other)}
    found = np.full(len(scene.faces), -1, np.int64)
    for key, start, count in _objects(scene):
        its, as_many = there.get(key, (0, -1))
        if count == as_many:
            found[start : start + count] = np.arange(its, its + count)
    return found


def _objects(scene: Scene) -> list[tuple[tuple[str, int], int, int]]:
    """(name and how many of it came before, first face, faces) of each object."""
    numbers = np.arange(len(scene.object_names))
    starts = np.searchsorted(scene.face_object, numbers)
    ends = np.searchsorted(scene.face_object, numbers, side="right")
    met: dict[str, int] = {}
    found = []
    for name, start, end in zip(scene.object_names, starts, ends, strict=True):
        met[name] = met.get(name, -1) + 1
        found.append(((name, met[name]), int(start), int(end - start)))
    return found


def _camera(scene: Scene) -> CameraData:
    assert scene.camera is not None
    return scene.camera
