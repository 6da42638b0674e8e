"""The pilot: a few paths and photons that tell how large the first gather discs must be."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera_pass.caustics import footprints
from .camera_pass.chunk import trace_camera, trace_gather, wide_only
from .camera_pass.light_image import Expected
from .camera_pass.pixels import Pixels, Region
from .camera_pass.rays import Rays
from .film.film import SAMPLE
from .geometry.borders import border_sides, borders_of, joined, no_borders, short
from .geometry.crossings import crossings
from .geometry.polylines import straightened
from .geometry.surfaces import Surfaces
from .photons.coverage import MOST_PIECES, BorderGrid, border_grid
from .photons.photon_map import Crowd, PhotonMap
from .photons.rows import CELL
from .photons.shadow import ShadowMap
from .prepared import Prepared
from .settings import Settings

#: Pass number of the pilot's random streams; no real pass reaches it.
PILOT_PASS = 2_000_000_000
#: Pixels that the pilot looks at, at most.
PIXELS = 4096
#: Ends of gather rays whose photons are asked for, about: of 4096 the search took a quarter of
#: the pilot's time.
ENDS = 1024
#: Caustic photons that tell where light is focused.
CROWD = 8192
#: Both of a draft: half of what an edit waited for was the pilot.
DRAFT_PIXELS, DRAFT_CROWD = 1024, 1024
#: Photons in the first disc of the final gather's map.
GLOBAL_NEIGHBOURS = 20
#: Lines where surfaces cross are this exact, in radii of the discs that they part.
STRAY = 0.005
#: The grid's cells suit discs of the usual size; this bounds the others, as factors.
SPREAD = 4.0


class Radii(NamedTuple):
    """Radii of pass 0. ``caustic``: pixel footprints, least, most, cell; ``global_`` [m].

    The borders are in grids for discs of up to those radii. ``shadows``: the shadow photons,
    None without; ``crowd``: the map of ``crowd_photons`` caustic photons, None without, and
    ``expected``: what the camera sees of these at once.
    """

    caustic: tuple[float, float, float, float]
    global_: float
    caustic_borders: BorderGrid
    global_borders: BorderGrid
    shadows: ShadowMap | None = None
    crowd: PhotonMap | None = None
    crowd_photons: int = CROWD
    expected: Expected | None = None

    def with_caustics(self, factor: float) -> Radii:
        """Discs of caustics ``factor`` (1 at most) times as wide."""
        footprints, least, most, cell = (factor * r for r in self.caustic)
        return self._replace(caustic=(footprints, least, most, cell))

    def crowd_of(self, emitted: int) -> Crowd | None:
        """Where passes that emit so many caustic photons are dense."""
        if self.crowd is None:
            return None
        return Crowd(self.crowd, emitted / self.crowd_photons, self.caustic[:3])


def no_radii() -> Radii:
    """Of a render without photons."""
    none = border_grid(no_borders(), 1.0)
    return Radii((0.0, 0.0, 0.0, 0.0), 0.0, none, none)


class PilotLook(NamedTuple):
    """What the camera sees.

    ``views`` (P, 3): where the pilot's camera paths have ended, ``ends`` (Q, 3): where gather
    rays from there have, both centred; ``footprint``: of a typical pixel [m], 0 where none
    sees anything.
    """

    views: NDArray[np.float64]
    ends: NDArray[np.float64]
    footprint: float


#: Of a render that has no photons to look for.
NOTHING = PilotLook(np.zeros((0, 3)), np.zeros((0, 3)), 0.0)


def look_for_radii(prepared: Prepared, settings: Settings, region: Region) -> PilotLook:
    """A few of the pixels of ``region``; photons play no part."""
    total = region.width * region.height
    stride = max(1, total // (DRAFT_PIXELS if settings.draft else PIXELS))
    pixels = Pixels.spread(PILOT_PASS, total // stride, stride=stride)
    samples = np.zeros(pixels.paths, SAMPLE)
    rays = Rays(prepared, pixels.paths)
    ends = trace_camera(prepared, settings, region, pixels, rays, samples)
    ends = wide_only(ends)
    # One ray each: the radius shall not hang on how many there will be.
    one = replace(settings, gather_rays=1)
    far, _ = trace_gather(prepared, one, ends, samples)
    seen = footprints(prepared.camera, np.ascontiguousarray(ends.vertices["length"]))
    typical = float(np.median(seen)) if len(seen) else 0.0
    return PilotLook(ends.vertices["p"].copy(), far.vertices["p"].copy(), typical)


def first_radii(
    prepared: Prepared,
    settings: Settings,
    look: PilotLook,
    photons: NDArray[np.float64],
    caustics: bool,
) -> Radii:
    """Radii from what the camera sees and how dense the pilot's global ``photons`` lie.

    ``photons`` (P, 3): positions of one pass's global photons, centred; ``caustics``:
    whether there are discs for them at all.
    """
    size = prepared.centre.radius
    typical = look.footprint if len(look.views) else 1e-3 * size
    typical = max(typical * settings.caustic_radius, 1e-7 * size)
    caustic = (settings.caustic_radius, typical / SPREAD, typical * SPREAD, CELL * typical)
    radius = _global_radius(prepared, photons, look.ends)
    grids = _borders(
        prepared, [caustic[2], radius] if caustics else [radius], not settings.draft
    )
    return Radii(caustic, radius, grids[0], grids[-1])


def _borders(prepared: Prepared, radii: list[float], crossed: bool) -> list[BorderGrid]:
    """Where surfaces end and, if ``crossed``, meet others, for discs of each of ``radii``."""
    mesh, intersector = prepared.mesh, prepared.intersector
    if len(mesh.faces) == 0:
        return [border_grid(no_borders(), 1.0)] * len(radii)
    holds = prepared.receivers[mesh.material]
    surfaces = Surfaces(mesh, prepared.face_object)
    met = crossings(surfaces, holds, intersector, radii[-1]) if crossed else no_borders()
    sides = border_sides(surfaces, holds)
    grids = []
    for radius in radii:
        intersector.go_on()
        ends = borders_of(mesh, sides, holds, intersector, radius, MOST_PIECES)
        lines = short(straightened(met, STRAY * radius), radius, MOST_PIECES)
        grids.append(border_grid(joined(ends, lines), radius))
    return grids


def _global_radius(
    prepared: Prepared, photons: NDArray[np.float64], ends: NDArray[np.float64]
) -> float:
    """Median distance to the k-th photon at the ends of the gather rays, some of them."""
    from scipy.spatial import cKDTree

    size = prepared.centre.radius
    k = min(GLOBAL_NEIGHBOURS, len(photons))
    if k == 0 or len(ends) == 0:
        return 0.05 * size
    prepared.intersector.go_on()
    tree = cKDTree(photons)
    prepared.intersector.go_on()
    distance, _ = tree.query(ends[:: max(1, len(ends) // ENDS)], k=[k])
    return float(np.clip(np.median(distance), 1e-6 * size, size))
