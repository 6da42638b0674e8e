"""The photons of one pass to look at: each with its power, its bounce, its light, its caster.

What a photon came through is in no photon map. It is found again here, from the order of
the paths and from their first rays, so that looking costs renders nothing.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera.perspective import CameraTables
from .photon_pass import Batch, photon_batches, trace_batch
from .photons.emit import PHOTON_PATH, emit_photons
from .photons.trace import PHOTON
from .plan import Plan
from .prepared import Prepared, prepare
from .sampling.rng import PHOTON_CAUSTIC, PHOTON_GLOBAL
from .scene.scene import Scene
from .settings import Settings

#: What lights are called that are no lamps.
OTHER_LIGHTS = ("glowing surfaces", "the world")


class PhotonView(NamedTuple):
    """N stored photons.

    position (N, 3) f8 [m, world]; direction (N, 3) f4 back to where each came from; normal
    (N, 3) f4; flux (N, 3) f4 [W]; caustic (N,) bool, else of the global map; bounce (N,)
    i4: surfaces it was scattered by before; light (N,) i4 into ``lights``; caster (N,) i4
    into ``objects``: what its path met first, -1 for those that were stored there.
    """

    position: NDArray[np.float64]
    direction: NDArray[np.float32]
    normal: NDArray[np.float32]
    flux: NDArray[np.float32]
    caustic: NDArray[np.bool_]
    bounce: NDArray[np.int32]
    light: NDArray[np.int32]
    caster: NDArray[np.int32]
    lights: tuple[str, ...]
    objects: tuple[str, ...]

    def only(self, chosen: NDArray[np.bool_]) -> PhotonView:
        """The photons where ``chosen`` (N,) holds."""
        names = [name for name in self._fields if name not in ("lights", "objects")]
        return self._replace(**{name: getattr(self, name)[chosen] for name in names})


def view_photons(scene: Scene, settings: Settings, i: int = 0) -> PhotonView:
    """The photons of pass ``i`` of ``scene``; raises ``SceneError``."""
    prepared = prepare(scene, settings)
    camera = scene.camera
    assert camera is not None  # prepare has looked
    batches = photon_batches(Plan.of(scene, settings), settings, camera.width * camera.height)
    photons = [np.zeros(0, PHOTON)]
    facts = [np.zeros((0, 4), np.int32)]
    for batch in batches:
        walk = trace_batch(prepared, settings, i, batch)
        light, first = _first_hits(prepared, settings, i, batch)
        path = (walk.order // settings.photon_depth).astype(np.int64)
        bounce = (walk.order % settings.photon_depth).astype(np.int32)
        face = first[path - batch.start]
        met = np.where(face >= 0, scene.face_object[face] if len(scene.faces) else -1, -1)
        caster = np.where(bounce > 0, met, -1)
        kind = np.full(len(path), batch.caustic)
        photons.append(walk.photons)
        facts.append(np.stack([kind, bounce, light[path - batch.start], caster], axis=1))
    rows = np.concatenate(photons)
    known = np.concatenate(facts).astype(np.int32)
    return PhotonView(
        position=rows["position"] + prepared.centre.origin,
        direction=rows["direction"],
        normal=rows["normal"],
        flux=rows["flux"],
        caustic=known[:, 0] != 0,
        bounce=known[:, 1],
        light=known[:, 2],
        caster=known[:, 3],
        lights=(*scene.light_names, *OTHER_LIGHTS),
        objects=scene.object_names,
    )


def _first_hits(
    prepared: Prepared, settings: Settings, i: int, batch: Batch
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Light entry and first face (-1: none) of each path of ``batch``."""
    count = batch.count
    origins, directions = np.zeros((2, count, 3), np.float32)
    paths = np.zeros(count, PHOTON_PATH)
    light_cdf = prepared.aim.light_cdf if batch.caustic else prepared.lights.photon_cdf
    alive = emit_photons(
        prepared.mesh, prepared.materials, prepared.shading, prepared.lights,
        prepared.light_media, prepared.aim.spheres, light_cdf, batch.caustic, settings.seed,
        PHOTON_CAUSTIC if batch.caustic else PHOTON_GLOBAL, i, batch.start, count,
        batch.total, origins, directions, paths,
    )  # fmt: skip
    light, first = np.full((2, count), -1, np.int32)
    own = paths["index"][:alive] - batch.start
    light[own] = paths["entry"][:alive]
    first[own] = prepared.intersector.nearest(origins[:alive], directions[:alive]).face
    return light, first


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
