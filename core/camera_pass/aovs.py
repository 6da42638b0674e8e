"""Values of a user's own that the camera sees on surfaces (AOVs: arbitrary output variables).

As in Cycles: every surface adds its value, through transparent ones by what they let pass,
until one is met that is at least half opaque; behind all of them the world. Surfaces that are
held out count too.
"""

from __future__ import annotations

from ..jit import Row, Table, kernel
from ..textures.sampling import param_color


@kernel
def keep_aovs(sums: Table, path: Row, hit: Row, shading: Row, tables: Row) -> None:
    """Add the values of the surface that ``path`` is on to ``sums`` (A, 4)."""
    beta = path.beta
    weight = (beta[0] + beta[1] + beta[2]) / 3.0
    for a in range(len(tables.aovs)):
        row = tables.aovs[a, hit.row]
        if row.known == 0:
            continue
        value = param_color(shading, row.param, hit.face, hit.u, hit.v)
        for c in range(3):
            sums[a, c] += weight * value[c]
        sums[a, 3] += weight


@kernel
def keep_world_aovs(sums: Table, path: Row, tables: Row) -> None:
    """Add the values of the surroundings, which ``path`` sees, to ``sums`` (A, 4)."""
    beta = path.beta
    weight = (beta[0] + beta[1] + beta[2]) / 3.0
    for a in range(len(tables.world_aovs)):
        row = tables.world_aovs[a]
        if row.known != 0:
            for c in range(3):
                sums[a, c] += weight * row.param.value[c]
            sums[a, 3] += weight
