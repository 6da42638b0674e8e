"""Caustics: the caustic photon map, asked where camera paths stop."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..jit import Row, Table, kernel
from .estimate import add_estimate


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
def gather_caustics(
    lobes: Table,
    camera: Row,
    photon_map: Row,
    borders: Row,
    radii: Table,
    vertices: Table,
    count: int,
    samples: Table,
    sight: Table,
) -> None:
    """Add the caustic layer at ``count`` vertices.

    ``radii``: (pixels per footprint, least, most) of this pass, the latter two in metres;
    ``sight`` (SIGHT,) is overwritten.
    """
    for k in range(count):
        vertex = vertices[k]
        radius = disc_radius(camera, radii, vertex.length)
        sample = samples[vertex.slot]
        add_estimate(sample.caustics, sample, vertex, lobes, photon_map, borders, radius, sight)
