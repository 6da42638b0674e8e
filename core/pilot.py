"""The pilot: a few paths and photons that tell how large the first gather discs must be."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera_pass.caustics import footprints
from .camera_pass.chunk import Pixels, Rays, Region, trace_camera, trace_gather, wide_only
from .film.film import SAMPLE
from .geometry.borders import borders_of, no_borders
from .photons.coverage import MOST_PIECES, BorderGrid, border_grid
from .photons.shadow import ShadowMap
from .prepared import Prepared
from .settings import Settings

#: Pass number of the pilot's random streams; no real pass reaches it.
PILOT_PASS = 2_000_000_000
#: Pixels that the pilot looks at, at most.
PIXELS = 4096
#: Photons in the first disc of the final gather's map.
GLOBAL_NEIGHBOURS = 20
#: The grid's cells suit discs of the usual size; this bounds the others, as factors.
SPREAD = 4.0


class Radii(NamedTuple):
    """Radii of pass 0. ``caustic``: pixel footprints, least, most, cell; ``global_`` [m].

    ``borders`` are in a grid for discs of up to those radii. ``shadows``: the shadow photons,
    None without.
    """

    caustic: tuple[float, float, float, float]
    global_: float
    borders: BorderGrid
    shadows: ShadowMap | None = None


def no_radii() -> Radii:
    """Of a render without photons."""
    return Radii((0.0, 0.0, 0.0, 0.0), 0.0, border_grid(no_borders(), 1.0))


def first_radii(
    prepared: Prepared, settings: Settings, region: Region, photons: NDArray[np.float64]
) -> Radii:
    """Radii from what the camera sees and how dense the pilot's global ``photons`` lie.

    ``photons`` (P, 3): positions of one pass's global photons, centred.
    """
    total = region.width * region.height
    stride = max(1, total // PIXELS)
    pixels = Pixels(0, total // stride, stride)
    samples = np.zeros(pixels.count, SAMPLE)
    rays = Rays(prepared, pixels.count)
    lit = trace_camera(prepared, settings, region, PILOT_PASS, pixels, rays, samples)
    lit = wide_only(lit)
    far, _ = trace_gather(prepared, settings, PILOT_PASS, lit, samples)
    size = prepared.centre.radius
    seen = footprints(prepared.camera, np.ascontiguousarray(lit.vertices["length"]))
    typical = float(np.median(seen)) if len(seen) else 1e-3 * size
    typical = max(typical * settings.caustic_radius, 1e-7 * size)
    caustic = (settings.caustic_radius, typical / SPREAD, typical * SPREAD, 2 * typical)
    radius = _global_radius(photons, far.vertices["p"], size)
    largest = max(radius, caustic[2])
    holds = prepared.receivers[prepared.mesh.material]
    borders = borders_of(prepared.mesh, holds, prepared.intersector, largest, MOST_PIECES)
    return Radii(caustic, radius, border_grid(borders, largest))


def _global_radius(
    photons: NDArray[np.float64], ends: NDArray[np.float64], size: float
) -> float:
    """Median distance to the k-th photon at the ends of the gather rays."""
    from scipy.spatial import cKDTree

    k = min(GLOBAL_NEIGHBOURS, len(photons))
    if k == 0 or len(ends) == 0:
        return 0.05 * size
    distance, _ = cKDTree(photons).query(ends, k=[k])
    return float(np.clip(np.median(distance), 1e-6 * size, size))
