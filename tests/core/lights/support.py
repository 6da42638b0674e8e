"""Lights made ready for kernels, for the tests in this folder."""

from __future__ import annotations

import numpy as np

from photon_map.core.geometry.mesh import centre_of, centred_mesh
from photon_map.core.lights.dispatch import sample_li
from photon_map.core.lights.light_set import light_set
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.textures.shading import shading_tables

UP = (0.0, 0.0, 1.0)
#: Shading tables of a scene without textures.
PLAIN = shading_tables(SceneBuilder("plain").build())


def prepared(builder):
    scene = builder.build()
    centre = centre_of(scene)
    mesh = centred_mesh(scene, centre)
    return light_set(scene, mesh, centre), mesh, scene.materials, centre


def draw(lights, mesh, materials, entry, p, numbers):
    """Directions (N, 3), distances, radiances (N, 3), densities, delta."""
    found = [sample_li(lights, mesh, materials, PLAIN, entry, p, UP, *u) for u in numbers]
    return [np.array(column) for column in zip(*found, strict=True)]
