"""How many photons lie around what the camera sees, for a layer of data.

A density estimate like those of the light, with the same discs, of photons that count one
each: so a picture is dark where a render has to guess its light from few photons.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.vector import vector
from ..jit import Row, Table, kernel
from ..photons.coverage import look_around
from ..photons.gather import gather_irradiance
from ..photons.photon_map import PhotonMap
from ..photons.sight import SIGHT
from .caustics import crowded_radius

if TYPE_CHECKING:
    from ..prepared import Prepared
    from .chunk import PhotonMaps


class DensityMaps(NamedTuple):
    """Both maps of a pass with photons of flux 1, None where the plan has none."""

    caustic: PhotonMap | None
    global_: PhotonMap | None

    @staticmethod
    def of(caustic: PhotonMap | None, global_: PhotonMap | None) -> DensityMaps:
        """Copies of a pass's photons; their tables are shared."""
        return DensityMaps(_of_ones(caustic), _of_ones(global_))


def _of_ones(photon_map: PhotonMap | None) -> PhotonMap | None:
    if photon_map is None:
        return None
    photons = photon_map.photons.copy()
    photons["flux"] = 1.0
    return photon_map._replace(photons=photons)


def count_photons(
    prepared: Prepared,
    maps: PhotonMaps,
    counted: DensityMaps,
    vertices: NDArray[np.void],
    at: NDArray[Any],
    rows: NDArray[np.void],
) -> None:
    """Density of the photons in the discs at ``vertices``, into ``FIRST_HIT`` rows ``at``."""
    sight, radii = np.zeros(SIGHT), np.full(len(vertices), maps.global_radius)
    np.add.at(rows["gathered"], at, vertices["portion"])
    if counted.global_ is not None:
        add_density(counted.global_, maps.global_borders, radii, vertices, at, rows, sight)
    if counted.caustic is not None:
        crowded_radii(prepared.camera, maps.caustic_radii, maps.crowd, vertices, radii, sight)
        add_density(counted.caustic, maps.caustic_borders, radii, vertices, at, rows, sight)


@kernel
def crowded_radii(
    camera: Row, radii: Table, crowd: Row, vertices: Table, out: Table, sight: Table
) -> None:
    """Radius [m] of the caustic disc at each of ``vertices`` (n,), into ``out`` (n,)."""
    for k in range(len(vertices)):
        vertex = vertices[k]
        p, ng = vector(vertex.p), vector(vertex.ng)
        out[k] = crowded_radius(camera, radii, crowd, p, ng, vertex.length, sight)


@kernel
def add_density(
    photon_map: Row,
    borders: Row,
    radii: Table,
    vertices: Table,
    at: Table,
    rows: Table,
    sight: Table,
) -> None:
    """Add the photons per area [1/m^2] in discs of ``radii`` (n,) at ``vertices`` (n,).

    Ends of branches count by their portion, in rows ``at`` (n,). ``photon_map`` is one of
    ``DensityMaps``; ``sight`` (SIGHT,) is overwritten.
    """
    for k in range(len(vertices)):
        vertex = vertices[k]
        p, ng = vector(vertex.p), vector(vertex.ng)
        outside = vertex.entering != 0
        _, share, _ = look_around(borders, p, ng, outside, radii[k], sight)
        density, _, _ = gather_irradiance(photon_map, p, ng, radii[k], sight)
        rows[at[k]].photon_density += vertex.portion * density[0] / share
