"""The photons of one pass to look at: each with its power, its bounce, its light, its caster.

What a photon came through is in no photon map. It is found again here by tracing the pass
once more, so that looking costs renders nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera.perspective import CameraTables
from .geometry.intersector import Hits
from .photon_pass import Batch, photon_batches, trace_batch
from .photons.trace import PHOTON, Walk
from .plan import Plan
from .prepared import Prepared, prepare
from .scene.scene import Scene
from .settings import Settings

#: What lights are called that are no lamps.
OTHER_LIGHTS = ("glowing surfaces", "the world")


class PhotonView(NamedTuple):
    """N stored photons.

    position (N, 3) f8 [m, world]; direction (N, 3) f4 back to where each came from; normal
    (N, 3) f4; flux (N, 3) f4 [W]; caustic (N,) bool, else of the global map; path (N,) i8:
    its number among those of its kind; bounce (N,) i4: surfaces it was scattered by before;
    light (N,) i4 into ``lights``; caster (N,) i4 into ``objects``: what its path met first, -1
    for those that were stored there.
    """

    position: NDArray[np.float64]
    direction: NDArray[np.float32]
    normal: NDArray[np.float32]
    flux: NDArray[np.float32]
    caustic: NDArray[np.bool_]
    path: NDArray[np.int64]
    bounce: NDArray[np.int32]
    light: NDArray[np.int32]
    caster: NDArray[np.int32]
    lights: tuple[str, ...]
    objects: tuple[str, ...]

    def only(self, chosen: NDArray[np.bool_] | NDArray[np.intp]) -> PhotonView:
        """The photons where ``chosen`` (N,) holds, or of these rows."""
        names = [name for name in self._fields if name not in ("lights", "objects")]
        return self._replace(**{name: getattr(self, name)[chosen] for name in names})


def view_photons(scene: Scene, settings: Settings, i: int = 0) -> PhotonView:
    """The photons of pass ``i`` of ``scene``; raises ``SceneError``."""
    prepared = prepare(scene, settings)
    camera = scene.camera
    assert camera is not None  # prepare has looked
    batches = photon_batches(Plan.of(scene, settings), settings, camera.width * camera.height)
    known = [known_walk(prepared, settings, i, batch) for batch in batches]
    return view_of(scene, settings, prepared, batches, known)


class KnownWalk(NamedTuple):
    """A batch's walk, and of each of its paths the light and the first face (-1: none)."""

    walk: Walk
    light: NDArray[np.int32]
    first: NDArray[np.int32]


def known_walk(prepared: Prepared, settings: Settings, i: int, batch: Batch) -> KnownWalk:
    """Trace a batch and look where its paths begin."""
    light, first = np.full((2, batch.count), -1, np.int32)
    seen = np.zeros(batch.count, np.bool_)

    def look(paths: NDArray[np.void], origins: NDArray[np.float32], hits: Hits) -> None:
        own = paths["index"] - batch.start
        new = ~seen[own]
        seen[own] = True
        light[own[new]] = paths["entry"][new]
        first[own[new]] = hits.face[new]

    return KnownWalk(trace_batch(prepared, settings, i, batch, look), light, first)


def view_of(
    scene: Scene,
    settings: Settings,
    prepared: Prepared,
    batches: list[Batch],
    known: list[KnownWalk],
) -> PhotonView:
    """The photons of all ``batches``, one behind the other."""
    facts = [np.zeros((0, 5), np.int64)]
    rows = [known_walk.walk.photons for known_walk in known]
    for batch, (walk, light, first) in zip(batches, known, strict=True):
        path = walk.order // settings.photon_depth
        bounce = walk.order % settings.photon_depth
        face = first[path - batch.start]
        met = np.where(face >= 0, scene.face_object[face] if len(scene.faces) else -1, -1)
        caster = np.where(bounce > 0, met, -1)
        kind = np.full(len(path), batch.caustic)
        facts.append(np.stack([kind, path, bounce, light[path - batch.start], caster], axis=1))
    photons = np.concatenate(rows) if rows else np.zeros(0, PHOTON)
    columns = np.concatenate(facts).astype(np.int64)
    return PhotonView(
        position=photons["position"] + prepared.centre.origin,
        direction=photons["direction"],
        normal=photons["normal"],
        flux=photons["flux"],
        caustic=columns[:, 0] != 0,
        path=columns[:, 1],
        bounce=columns[:, 2].astype(np.int32),
        light=columns[:, 3].astype(np.int32),
        caster=columns[:, 4].astype(np.int32),
        lights=(*scene.light_names, *OTHER_LIGHTS),
        objects=scene.object_names,
    )


def picture_places(
    scene: Scene, settings: Settings, view: PhotonView
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """The photons that the camera sees: their rows, and their pixels (n, 2) x and y.

    x counts from the left, y from the bottom; what lies behind something is left out.
    """
    prepared = prepare(scene, settings)
    camera, size = prepared.camera, scene.camera
    assert size is not None  # prepare has looked
    centred = view.position - prepared.centre.origin
    x, y, depth = project(camera, centred)
    inside = (x >= 0) & (x < size.width) & (y >= 0) & (y < size.height)
    inside &= (depth > camera.clip_start) & (depth < camera.clip_end)
    rows = np.flatnonzero(inside)
    start = centred[rows] + 1e-4 * depth[rows, None] * view.normal[rows]
    back = np.broadcast_to(-camera.axes[2], start.shape) * depth[rows, None]
    if not camera.orthographic:
        back = camera.position - start
    free = prepared.intersector.is_free(
        start.astype(np.float32),
        np.ascontiguousarray(back, np.float32),
        np.ones(len(rows), np.float32),
    )
    rows = rows[free & ((view.normal[rows] * back).sum(axis=1) > 0)]
    return rows, np.stack([x[rows], y[rows]], axis=1).astype(np.int32)


def project(
    camera: CameraTables, points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Pixel x and y from the bottom left, and depth along the axis, of ``points`` (N, 3)."""
    right, up, depth = camera.axes @ (points - camera.position).T
    if not camera.orthographic:
        with np.errstate(divide="ignore", invalid="ignore"):
            right, up = right / depth, up / depth
    x = np.where(depth > 0, (right - camera.left) / camera.step_x, -1.0)
    y = np.where(depth > 0, (up - camera.bottom) / camera.step_y, -1.0)
    return x, y, depth
