"""The mesh as kernels see it."""

from __future__ import annotations

from dataclasses import replace

import numba
import numpy as np

from photon_map.core.geometry.mesh import centre_of, centred_mesh
from photon_map.core.scene.builder import SceneBuilder
from photon_map.tests.scenes import cornell_glass


def test_kernels_do_not_tell_a_scene_without_faces_from_others() -> None:
    """Or they would be compiled once more, half a minute, for the preview of a world."""
    some, none = cornell_glass(8), SceneBuilder("nothing").build()
    meshes = [centred_mesh(scene, centre_of(scene)) for scene in (some, none)]
    types = [tuple(numba.typeof(part) for part in mesh) for mesh in meshes]
    assert types[0] == types[1]
    assert len(meshes[0].faces) and not len(meshes[1].faces)


def test_positions_are_relative_to_the_middle() -> None:
    scene = cornell_glass(8)
    moved = replace(scene, vertices=scene.vertices + np.array([1e4, 0.0, -3e3]))
    for one in (scene, moved):
        centre = centre_of(one)
        mesh = centred_mesh(one, centre)
        np.testing.assert_allclose(
            mesh.vertices.astype(np.float64) + centre.origin, one.vertices, atol=1e-6
        )
