"""Caustics: the caustic photon map, asked where camera paths stop."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..geometry.vector import Vector, scale, store, vector
from ..jit import Row, Table, kernel
from ..photons.gather import gather_irradiance
from ..photons.sight import SECTORS
from .estimate import add_estimate

#: Photons from which on a disc of caustics is made smaller, ...
ENOUGH = 8
#: ... and to what part of its first radius at least.
LEAST_DISC = 0.05
#: Radius of the discs of crowded places, in that of caustics: their light is smoother, the
#: photons are fewer.
FOCUS_DISC = 2.0


@kernel
def footprint(camera: Row, length: float) -> float:
    """Radius [m] of what a pixel shows at ``length`` along its path.

    A pixel's width there, and the circle of confusion of the lens: a blurred place can be
    estimated with a larger disc.
    """
    pixel = max(camera.step_x, camera.step_y)
    if not camera.orthographic:
        pixel *= length
    blur = camera.lens_radius * abs(length - camera.focus_distance) / camera.focus_distance
    return math.sqrt(pixel * pixel + blur * blur)


def footprints(camera: Row, lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """``footprint`` of each of ``lengths`` (N,)."""
    out = np.zeros(len(lengths))
    fill_footprints(camera, lengths, out)
    return out


@kernel
def fill_footprints(camera: Row, lengths: Table, out: Table) -> None:
    """Write ``footprint`` of each of ``lengths`` (N,) to ``out`` (N,)."""
    for k in range(len(lengths)):
        out[k] = footprint(camera, lengths[k])


@kernel
def disc_radius(camera: Row, radii: Table, length: float) -> float:
    """Radius [m] of the disc at ``length`` along a path; see ``gather_caustics``."""
    return min(max(radii[0] * footprint(camera, length), radii[1]), radii[2])


@kernel
def crowded_radius(
    camera: Row, radii: Table, crowd: Row, p: Vector, ng: Vector, length: float, sight: Table
) -> float:
    """Radius [m] of the disc at ``p``: smaller where light is focused.

    There a disc has hundreds of photons, and its blur outweighs its noise. ``crowd`` tells by
    photons of another pass, since a choice by the photons that are summed would bias the sum.
    ``sight`` (SIGHT,) is overwritten.
    """
    radius = disc_radius(camera, radii, length)
    first = disc_radius(camera, crowd.radii, length)
    sight[SECTORS] = 0.0
    _, _, found = gather_irradiance(crowd.photons, p, ng, first, sight)
    expected = crowd.factor * found
    if expected > ENOUGH:
        radius = min(radius, max(LEAST_DISC, math.sqrt(ENOUGH / expected)) * first)
    return radius


@kernel
def gather_caustics(
    lobes: Table,
    camera: Row,
    photon_map: Row,
    borders: Row,
    radii: Table,
    crowd: Row,
    focused: bool,
    connected: Table,
    vertices: Table,
    count: int,
    samples: Table,
    sight: Table,
) -> None:
    """Add the caustic layer at ``count`` vertices.

    ``radii``: (pixels per footprint, least, most) of this pass, the latter two in metres;
    ``connected`` (n,): the part that connections have brought where the camera sees a vertex at
    once, (0,) for none; ``sight`` (SIGHT,) is overwritten. ``focused``: add what crowded places
    send (``photons.focus``) to the indirect layer, by their map and in discs of one size.
    """
    for k in range(count):
        vertex = vertices[k]
        p, ng, beta = vector(vertex.p), vector(vertex.ng), vector(vertex.beta)
        sample = samples[vertex.slot]
        layer = sample.caustics
        if focused:
            layer = sample.indirect
            radius = disc_radius(camera, radii, vertex.length)
        else:
            radius = crowded_radius(camera, radii, crowd, p, ng, vertex.length, sight)
        if vertex.depth == 1 and len(connected) > 0:
            store(vertex.beta, scale(beta, 1.0 - connected[vertex.slot]))
        add_estimate(layer, sample, vertex, lobes, photon_map, borders, radius, sight)
        store(vertex.beta, beta)
