"""Light of crowded places: their photon map, asked where camera paths stop."""

from __future__ import annotations

from ..jit import Row, Table, kernel
from .caustics import disc_radius
from .estimate import add_estimate

#: Radius of the discs, in that of caustics: the light is smoother, the photons are fewer.
FOCUS_DISC = 2.0


@kernel
def gather_focus(
    lobes: Table,
    camera: Row,
    photon_map: Row,
    borders: Row,
    radii: Table,
    vertices: Table,
    samples: Table,
    sight: Table,
) -> None:
    """Add what crowded places send (``photons.focus``) to the indirect layer at ``vertices``.

    Arguments as for ``caustics.gather_caustics``.
    """
    for k in range(len(vertices)):
        vertex = vertices[k]
        radius = disc_radius(camera, radii, vertex.length)
        sample = samples[vertex.slot]
        add_estimate(sample.indirect, sample, vertex, lobes, photon_map, borders, radius, sight)
