"""Caustics: the caustic photon map, asked where camera paths stop."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..geometry.vector import vector
from ..jit import Row, Table, kernel
from ..photons.gather import gather_radiance
from .paths import add


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


@kernel
def footprints(camera: Row, lengths: Table) -> Any:
    """``footprint`` of each of ``lengths`` (N,)."""
    out = np.zeros(len(lengths))
    for k in range(len(lengths)):
        out[k] = footprint(camera, lengths[k])
    return out


@kernel
def gather_caustics(
    materials: Table,
    lobes: Table,
    camera: Row,
    photon_map: Row,
    radii: Table,
    vertices: Table,
    count: int,
    samples: Table,
) -> None:
    """Add the caustic layer at ``count`` vertices.

    ``radii``: (pixels per footprint, least, most) of this pass, the latter two in metres.
    """
    for k in range(count):
        vertex = vertices[k]
        radius = radii[0] * footprint(camera, vertex.length)
        radius = min(max(radius, radii[1]), radii[2])
        radiance, _ = gather_radiance(
            photon_map, vector(vertex.p), vector(vertex.ng), vector(vertex.ns),
            vector(vertex.wo), radius, materials[vertex.row], lobes,
        )  # fmt: skip
        add(samples[vertex.slot].caustics, vertex.beta, radiance, 1.0)
