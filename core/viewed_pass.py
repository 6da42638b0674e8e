"""A pass whose photons are looked at: what the gather discs of a place hold, and whence.

The discs are those of a render: their radii, borders and gates. Photons have their whole flux,
before crowded places share it out (``photons.focus``). The way of each photon from
its light is traced again; a pass depends on nothing but scene, settings and its number.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .baking.bake import misfits
from .baking.maps_file import BakeError, MapsFile
from .camera_pass.caustics import crowded_radius
from .camera_pass.pixels import Region
from .geometry.intersector import Hits
from .geometry.vector import Vector
from .jit import Row, Table, kernel
from .photon_memory import affordable
from .photon_pass import (
    TracedPhotons,
    photon_maps,
    trace_batch,
)
from .photon_view import known_walk, view_of
from .photons.coverage import BorderGrid, look_around
from .photons.gather import disc_weight, facing
from .photons.sight import SIGHT, is_hidden
from .photons.trace import PHOTON
from .pilot_pass import pilot_radii
from .plan import Plan
from .prepared import Prepared, prepare
from .scene.scene import Scene
from .settings import Settings


class Place(NamedTuple):
    """A point of a surface [m, world]: its normal to the side looked at, and what it is of.

    ``outside``: whether that side is the one that the face's winding calls outside.
    """

    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    outside: bool
    object: str


class Disc(NamedTuple):
    """A gather disc: what a density estimate at ``place`` asks.

    ``rows`` (n,) of the view: its photons, and their ``weight`` (n,) [1/m^2], the share of the
    disc on surfaces divided out. ``irradiance`` (3,) [W/m^2] on that side of the surface.
    """

    place: Place
    caustic: bool
    radius: float
    share: float
    rows: NDArray[np.intp]
    weight: NDArray[np.float64]
    irradiance: NDArray[np.float64]


class ViewedPass:
    """The photons of pass ``i`` of a render of ``scene``.

    Where settings name baked maps they are those of the file, traced again by the seed and the
    counts that it tells. Raises ``SceneError``; ``BakeError`` for maps of another scene.
    """

    def __init__(self, scene: Scene, settings: Settings, i: int = 0) -> None:
        self._prepared = prepare(scene, settings)
        camera = scene.camera
        assert camera is not None  # prepare has looked
        plan = Plan.of(scene, settings)
        if settings.photon_maps:
            settings, i = _as_baked(scene, settings, plan, self._prepared, i)
        self.number = i
        self._settings = settings
        self._scene = scene
        pixels = camera.width * camera.height
        self._batches = affordable(self._prepared, settings, plan, pixels).batches
        known = [known_walk(self._prepared, settings, i, batch) for batch in self._batches]
        self.view = view_of(scene, settings, self._prepared, self._batches, known)
        rows = [walk.walk.photons for walk in known]
        self._photons = np.concatenate(rows) if rows else np.zeros(0, PHOTON)
        region = Region.of(camera, replace(settings, region=None))
        source = TracedPhotons(self._prepared, settings, self._batches)
        radii = pilot_radii(self._prepared, replace(settings, shadow_photons=0), region, source)
        self._maps = photon_maps(settings, radii, i, self._batches, [k.walk for k in known])

    @property
    def size(self) -> float:
        """Radius of the scene [m]."""
        return self._prepared.centre.radius

    def ray_of(self, x: float, y: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Origin and direction (3,) [world] of the camera's view of a place of the picture.

        In pixels from the left and from the bottom; a lens counts as a pinhole.
        """
        camera = self._prepared.camera
        right, up, forward = camera.axes
        aside = (x * camera.step_x + camera.left) * right
        aside = aside + (y * camera.step_y + camera.bottom) * up
        position = camera.position + self._prepared.centre.origin
        if camera.orthographic:
            return position + aside, forward
        return position, forward + aside

    def place_at(
        self, origin: NDArray[np.float64], direction: NDArray[np.float64]
    ) -> Place | None:
        """The first surface that a ray [world] meets."""
        centre, mesh = self._prepared.centre.origin, self._prepared.mesh
        start = np.asarray(origin, np.float64) - centre
        hits = self._prepared.intersector.nearest(
            start[None].astype(np.float32), np.asarray(direction, np.float32)[None]
        )
        face = int(hits.face[0])
        if face < 0:
            return None
        corners = mesh.vertices[mesh.faces[face]].astype(np.float64)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normal /= np.linalg.norm(normal)
        outside = bool(normal @ np.asarray(direction, np.float64) < 0)
        return Place(
            position=hit_points(self._prepared, hits)[0] + centre,
            normal=normal if outside else -normal,
            outside=outside,
            object=self._scene.object_names[self._prepared.face_object[face]],
        )

    def discs(self, place: Place) -> tuple[Disc, ...]:
        """The caustic and the global disc at ``place``, those that the plan has."""
        found = []
        if self._maps.caustic is not None:
            radius = self._caustic_radius(place)
            found.append(self._disc(place, True, radius, self._maps.caustic_borders))
        if self._maps.global_ is not None:
            radius = self._maps.global_radius
            found.append(self._disc(place, False, radius, self._maps.global_borders))
        return tuple(found)

    def _caustic_radius(self, place: Place) -> float:
        """Of the disc where the camera sees ``place`` itself."""
        away = place.position - self._prepared.centre.origin
        length = float(np.linalg.norm(away - self._prepared.camera.position))
        return float(
            crowded_radius(
                self._prepared.camera, self._maps.caustic_radii, self._maps.crowd, tuple(away),
                tuple(place.normal), length, np.zeros(SIGHT),
            )
        )  # fmt: skip

    def _disc(self, place: Place, caustic: bool, radius: float, borders: BorderGrid) -> Disc:
        rows = np.flatnonzero(self.view.caustic == caustic)
        weight = np.zeros(len(rows))
        photons = self._photons[rows]
        share = weigh_disc(
            borders, photons, np.ascontiguousarray(photons["position"]),
            place.position - self._prepared.centre.origin, place.normal, place.outside, radius,
            np.zeros(SIGHT), weight,
        )  # fmt: skip
        inside = weight > 0
        weight = weight[inside] / share
        rows = rows[inside]
        irradiance = weight @ self.view.flux[rows].astype(np.float64)
        return Disc(place, caustic, radius, float(share), rows, weight, irradiance)

    def paths(self, rows: NDArray[np.intp]) -> list[NDArray[np.float64]]:
        """The way (n, 3) [m, world] of each photon in ``rows`` from its light to its place."""
        found: list[NDArray[np.float64]] = [np.zeros((0, 3))] * len(rows)
        chosen = self.view.only(rows)
        for batch in self._batches:
            own = chosen.caustic == batch.caustic
            own &= (chosen.path >= batch.start) & (chosen.path < batch.start + batch.count)
            if own.any():
                steps = _Steps(self._prepared, np.unique(chosen.path[own]))
                trace_batch(self._prepared, self._settings, self.number, batch, steps)
                for k in np.flatnonzero(own):
                    place = chosen.position[k] - self._prepared.centre.origin
                    way = steps.way(int(chosen.path[k]), int(chosen.bounce[k]), place)
                    found[k] = way + self._prepared.centre.origin
        return found


def _as_baked(
    scene: Scene, settings: Settings, plan: Plan, prepared: Prepared, i: int
) -> tuple[Settings, int]:
    """Settings and number of the pass that the baked maps hold for pass ``i``."""
    path = Path(settings.photon_maps)
    header = MapsFile(path).header
    found = misfits(header, scene, settings, plan, prepared)
    if found:
        raise BakeError(f"photon maps '{path}' are of another scene: {found[0]}")
    settings = replace(
        settings, photon_maps="", seed=header.seed, photons_caustic=header.emitted[0],
        photons_global=header.emitted[1],
    )  # fmt: skip
    return settings, i % header.passes


class _Steps:
    """Keeps the surfaces that some paths of a batch meet, in their order."""

    def __init__(self, prepared: Prepared, wanted: NDArray[np.int64]) -> None:
        self._prepared = prepared
        self._wanted = wanted
        self._starts: dict[int, NDArray[np.float64]] = {}
        self._met: dict[int, list[tuple[int, NDArray[np.float64]]]] = {}

    def __call__(
        self, paths: NDArray[np.void], origins: NDArray[np.float32], hits: Hits
    ) -> None:
        own = np.flatnonzero(np.isin(paths["index"], self._wanted) & (hits.face >= 0))
        met = Hits(hits.face[own], hits.u[own], hits.v[own])
        points = hit_points(self._prepared, met)
        for k, point in zip(own, points, strict=True):
            path = int(paths["index"][k])
            self._starts.setdefault(path, origins[k].astype(np.float64))
            self._met.setdefault(path, []).append((int(paths["depth"][k]), point))

    def way(self, path: int, bounce: int, place: NDArray[np.float64]) -> NDArray[np.float64]:
        """From the start of ``path`` to its photon at ``place`` after ``bounce``."""
        met = self._met[path]
        away = [
            float(np.linalg.norm(point - place)) if depth == bounce else float("inf")
            for depth, point in met
        ]
        points = [point for _, point in met[: int(np.argmin(away))]]
        return np.array([self._starts[path], *points, place])


def hit_points(prepared: Prepared, hits: Hits) -> NDArray[np.float64]:
    """Where hits (N,) lie, (N, 3) [centred]; all must have a face."""
    corners = prepared.mesh.vertices[prepared.mesh.faces[hits.face]].astype(np.float64)
    u, v = hits.u[:, None].astype(np.float64), hits.v[:, None].astype(np.float64)
    points: NDArray[np.float64] = (
        (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
    )
    return points


@kernel
def weigh_disc(
    borders: Row,
    photons: Table,
    places: Table,
    p: Vector,
    ng: Vector,
    outside: bool,
    radius: float,
    sight: Table,
    weight: Table,
) -> float:
    """Density weights [1/m^2] of ``photons`` at ``places`` in the disc about ``p``.

    Returns the share of the disc that they are still to be divided by; the others stay 0.
    """
    centre = (p[0], p[1], p[2])
    normal = (ng[0], ng[1], ng[2])
    parted, share, _ = look_around(borders, centre, normal, outside, radius, sight)
    norm = 2.0 / (np.pi * radius * radius)
    for k in range(len(photons)):
        photon = photons[k]
        near = disc_weight(places, k, centre, normal, radius, 1.0 / (radius * radius))
        cosine = facing(photon, normal, False)
        if near <= 0.0 or cosine == 0.0:
            continue
        x = photon.position
        to = (x[0] - p[0], x[1] - p[1], x[2] - p[2])
        if parted and is_hidden(sight, to, normal, radius):
            continue
        weight[k] = norm * near * cosine
    return share
