"""Surfaces that a camera path goes straight through."""

from __future__ import annotations

from typing import Any

from ..bsdf.dispatch import lobe_weights, pass_weight
from ..bsdf.scatter import choose_transparency
from ..geometry.interaction import leave
from ..geometry.vector import store, vector
from ..jit import Row, Table, kernel
from ..scene.tables import Visibility

_CAMERA_BIT = int(Visibility.CAMERA)


@kernel
def choose_passing(path: Row, lobes: Table, u: float) -> Any:
    """Go straight through a surface or not, at random: (through, factor (3,)).

    What the camera sees at once counts for alpha and depth, so it is chosen by the surface's
    opacity; later surfaces by how much they scatter, which makes less noise.
    """
    wide, narrow = lobe_weights(path, lobes)
    scattering = wide + narrow
    if path.event == _CAMERA_BIT and scattering > 0.0:
        passing = pass_weight(path, lobes)
        scattering = max(0.0, 1.0 - (passing[0] + passing[1] + passing[2]) / 3.0)
    return choose_transparency(path, lobes, scattering, u)


@kernel
def go_straight(
    paths: Table, k: int, hit: Row, origins: Table, directions: Table, to: int
) -> None:
    """Path ``k`` goes on behind the surface as if nothing had happened, as number ``to``."""
    if to != k:
        paths[to] = paths[k]
    d = vector(paths[to].direction)
    store(origins[to], leave(vector(hit.p), vector(hit.ng), d, hit.offset))
    store(directions[to], d)
