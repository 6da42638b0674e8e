"""Where cameras see places, and which faces of two scenes are the same."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.camera.motion import motion_vectors, places_on, raster, same_faces
from photon_map.core.film.film import Film
from photon_map.core.film.first_hits import FIRST_HIT
from photon_map.core.scene.builder import SceneBuilder, diffuse
from photon_map.core.scene.camera_data import CameraData
from photon_map.core.scene.scene import Scene

WIDTH, HEIGHT = 8, 4
TRIANGLE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def camera(x: float = 0.0, **others: object) -> CameraData:
    """Looks down from 2 m, with a field of view as wide as its distance."""
    matrix = np.eye(4)
    matrix[:3, 3] = (x, 0.0, 2.0)
    common = {"width": WIDTH, "height": HEIGHT, "lens": 36.0, "sensor_width": 36.0}
    return CameraData(matrix=matrix, **{**common, **others})  # type: ignore[arg-type]


def scene_of(places: dict[str, float], seen_from: CameraData) -> Scene:
    """Triangles by their names, shifted along x."""
    builder = SceneBuilder("moving")
    grey = builder.add_material("grey", [diffuse(0.5)])
    for name, x in places.items():
        builder.add_mesh(name, TRIANGLE + (x, 0, 0), [[0, 1, 2]], grey)
    builder.set_camera(seen_from)
    return builder.build()


def test_the_middle_and_the_right_rim() -> None:
    places = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.25, 1.0]])
    assert raster(camera(), places) == pytest.approx(np.array([[4, 2], [8, 2], [8, 4]]))
    flat = camera(kind="ORTHOGRAPHIC", ortho_scale=4.0)
    assert raster(flat, places) == pytest.approx(np.array([[4, 2], [6, 2], [5, 2.5]]))


def test_faces_are_found_by_the_names_of_their_objects() -> None:
    scene = scene_of({"a": 0, "b": 1, "c": 2}, camera())
    other = scene_of({"c": 0, "a": 1}, camera())
    np.testing.assert_array_equal(same_faces(scene, other), [1, -1, 0])
    middle = places_on(scene, np.array([1]), np.array([0.25]), np.array([0.5]))
    assert middle == pytest.approx(np.array([[1.25, 0.5, 0.0]]))


def test_vectors_of_a_body_and_of_the_camera() -> None:
    scene = scene_of({"moving": 0.0, "still": 1.0}, camera())
    before = scene_of({"moving": -0.25, "still": 1.0}, camera())
    after = scene_of({"still": 1.0}, camera(0.5))
    film = Film(2, 2, first_hit=("place",))
    rows = np.zeros(4, FIRST_HIT)
    rows["found"][:3] = 1.0
    rows["place"][:3, 0] = (1, 2, 2)
    rows["place"][:, 1:] = (0.25, 0.25)
    film.add_asked(0, np.arange(4, dtype=np.int32), rows, None, None)
    # 2 m of the floor are 8 pixels: what went 0.25 m to the right was 1 pixel to the left;
    # by a camera that goes to the right all goes 2 pixels to the left.
    expected = [[-1, 0, 2, 0], [0, 0, 2, 0], [0, 0, 2, 0], [0, 0, 0, 0]]
    found = motion_vectors(film, scene, before, after)
    assert found.reshape(4, 4) == pytest.approx(np.array(expected), abs=1e-6)
