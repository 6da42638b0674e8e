from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from photon_map.core.scene.builder import (
    SceneBuilder,
    dielectric,
    diffuse,
    mirror,
    phong,
    refraction,
)
from photon_map.core.scene.camera_data import CameraData
from photon_map.core.scene.scene import SceneError
from photon_map.core.scene.tables import LightKind, Model, Visibility

TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_an_empty_scene_is_a_scene():
    scene = SceneBuilder("nothing").build()
    assert scene.name == "nothing"
    assert scene.vertices.shape == (0, 3)
    assert scene.corner_normals.shape == (0, 3, 3)
    assert scene.camera is None
    assert scene.lights.shape == (0,)


def test_meshes_are_merged_with_their_own_vertices_materials_and_names():
    builder = SceneBuilder()
    white = builder.add_material("white", [diffuse(0.8)])
    glass = builder.add_material("glass", [dielectric(1.5)])
    builder.add_mesh("floor", TRIANGLE, [[0, 1, 2]], white)
    builder.add_mesh("pane", np.add(TRIANGLE, 5.0), [[0, 1, 2], [2, 1, 0]], [glass, white])
    scene = builder.build()
    assert scene.faces.tolist() == [[0, 1, 2], [3, 4, 5], [5, 4, 3]]
    assert scene.vertices[3:].tolist() == np.add(TRIANGLE, 5.0).tolist()
    assert scene.face_material.tolist() == [white, glass, white]
    assert scene.face_object.tolist() == [0, 1, 1]
    assert scene.object_names == ("floor", "pane")


def test_lobes_of_a_material_are_its_slice_of_the_table():
    builder = SceneBuilder()
    builder.add_material("matte", [diffuse((0.1, 0.2, 0.3))])
    row = builder.add_material(
        "varnish", [phong(0.5, 20), refraction(1.33), mirror().scaled(0.25)], emission=2.0
    )
    scene = builder.build()
    material = scene.materials[row]
    stop = material["lobe_start"] + material["lobe_count"]
    lobes = scene.lobes[material["lobe_start"] : stop]
    assert lobes["model"].tolist() == [Model.PHONG, Model.REFRACTION, Model.CONDUCTOR]
    assert lobes["exponent"][0] == 20
    assert lobes["weight"][2].tolist() == [0.25, 0.25, 0.25]
    assert material["emission"].tolist() == [2.0, 2.0, 2.0]
    assert material["ior"] == 1.33
    assert scene.materials[0]["ior"] == 0.0


@pytest.mark.parametrize(
    "bad_corner", [[np.nan, 0, 0], [np.inf, 0, 0], [0.5, 0, 0]], ids=["nan", "inf", "no area"]
)
def test_malformed_faces_are_dropped_and_counted(bad_corner: list[float]):
    builder = SceneBuilder()
    white = builder.add_material("white", [diffuse(0.8)])
    builder.add_mesh("mixed", [*TRIANGLE, bad_corner], [[0, 1, 2], [0, 1, 3]], white)
    assert builder.dropped_faces == 1
    scene = builder.build()
    assert scene.faces.tolist() == [[0, 1, 2]]
    assert np.isfinite(scene.vertices).all()


@given(
    arrays.arrays(np.float64, (5, 3), elements=st.floats(allow_nan=True, allow_infinity=True))
)
def test_whatever_the_vertices_the_scene_is_finite(vertices: np.ndarray):
    builder = SceneBuilder()
    white = builder.add_material("white", [diffuse(0.8)])
    faces = [[0, 1, 2], [2, 3, 4], [0, 0, 1]]
    with np.errstate(over="ignore", invalid="ignore"):
        builder.add_mesh("any", vertices, faces, white)
    scene = builder.build()
    assert np.isfinite(scene.vertices).all()
    assert len(scene.faces) + builder.dropped_faces == len(faces)


def test_normals_that_are_not_finite_become_flat():
    builder = SceneBuilder()
    white = builder.add_material("white", [diffuse(0.8)])
    normals = np.tile([0.0, 0.0, 1.0], (2, 3, 1))
    normals[1, 2, 0] = np.nan
    builder.add_mesh("m", TRIANGLE, [[0, 1, 2], [2, 1, 0]], white, normals)
    scene = builder.build()
    assert scene.corner_normals[0].tolist() == [[0, 0, 1]] * 3
    assert not scene.corner_normals[1].any()


def test_lights_keep_their_shape_and_unit_axes():
    matrix = np.diag([2.0, 3.0, 4.0, 1.0])
    matrix[:3, 3] = (7, 8, 9)
    builder = SceneBuilder()
    builder.add_point_light("bulb", (1, 2, 3), 5.0, radius=0.1)
    builder.add_spot_light("spot", matrix, 1.0, half_angle=np.pi / 3, blend=0.5)
    builder.add_sun_light("sun", matrix, (1, 2, 3), angle=0.01)
    builder.add_area_light("panel", matrix, 1.0, 2.0, 3.0, visibility=Visibility.GLOSSY)
    builder.add_area_light("disk", matrix, 1.0, 2.0, 3.0, disk=True)
    lights = builder.build().lights
    assert lights["kind"].tolist() == [
        LightKind.POINT, LightKind.SPOT, LightKind.SUN, LightKind.RECTANGLE, LightKind.DISK
    ]  # fmt: skip
    assert lights["position"][1].tolist() == [7, 8, 9]
    for axis, unit in zip(("axis_x", "axis_y", "axis_z"), np.eye(3), strict=True):
        assert lights[axis][1].tolist() == unit.tolist()
    assert lights["cos_outer"][1] == pytest.approx(0.5, abs=1e-15)
    assert lights["emission"][2].tolist() == [1, 2, 3]
    assert lights["visibility"][3] == Visibility.GLOSSY
    assert (lights["size_x"][4], lights["size_y"][4]) == (2.0, 3.0)


def test_the_scene_is_frozen():
    scene = SceneBuilder().build()
    with pytest.raises(ValueError, match="read-only"):
        scene.world[0] = 1.0
    with pytest.raises(AttributeError):
        scene.world = np.ones(3)


def _material(**row: float) -> SceneBuilder:
    builder = SceneBuilder()
    builder.add_material("m", [dielectric(row.get("ior", 1.5), row.get("weight", 1.0))])
    return builder


def _light(emission: float, radius: float = 0.0) -> SceneBuilder:
    builder = SceneBuilder()
    builder.add_point_light("lamp", (0, 0, 0), emission, radius)
    return builder


def _sun(angle: float) -> SceneBuilder:
    builder = SceneBuilder()
    builder.add_sun_light("sun", np.eye(4), 1.0, angle)
    return builder


def _world(radiance: float) -> SceneBuilder:
    builder = SceneBuilder()
    builder.set_world(radiance)
    return builder


def _camera(**values: object) -> SceneBuilder:
    builder = SceneBuilder()
    builder.set_camera(CameraData(**{"width": 4, "height": 3, **values}))
    return builder


@pytest.mark.parametrize(
    ("builder", "message"),
    [
        (lambda: _material(ior=0.0), "material 'm': IOR"),
        (lambda: _material(ior=np.nan), "material 'm': IOR"),
        (lambda: _material(weight=-1.0), "material 'm': lobe weights"),
        (lambda: _light(-1.0), "light 'lamp': power"),
        (lambda: _light(np.inf), "light 'lamp': emission"),
        (lambda: _light(1.0, radius=-0.1), "light 'lamp': its radius"),
        (lambda: _sun(4.0), "light 'sun': its angle"),
        (lambda: _world(-1.0), "the world's radiance"),
        (lambda: _world(np.inf), "the world's radiance"),
        (lambda: _camera(width=0), "camera: size 0x3"),
        (lambda: _camera(pixel_aspect_x=0.0), "camera: pixel_aspect_x"),
        (lambda: _camera(shift_y=np.nan), "camera: shift_y"),
        (lambda: _camera(lens_radius=-1.0), "camera: lens_radius"),
        (lambda: _camera(lens=0.0), "camera: lens"),
        (lambda: _camera(focus_distance=np.nan), "camera: focus_distance"),
        (lambda: _camera(matrix=np.zeros((4, 4))), "camera: its matrix"),
    ],
)
def test_a_scene_that_cannot_be_rendered_says_where(builder, message: str):
    with pytest.raises(SceneError, match=message):
        builder().build()


def test_wrong_calls_name_the_object():
    builder = SceneBuilder()
    with pytest.raises(SceneError, match="object 'o': a face uses a vertex"):
        builder.add_mesh("o", TRIANGLE, [[0, 1, 3]], 0)
    with pytest.raises(SceneError, match="object 'o': one normal per face corner"):
        builder.add_mesh("o", TRIANGLE, [[0, 1, 2]], 0, np.zeros((2, 3, 3)))
    with pytest.raises(SceneError, match="matrix is not invertible"):
        builder.add_sun_light("s", np.zeros((4, 4)), 1.0)
    with pytest.raises(SceneError, match="light 'p': an area light needs a size"):
        builder.add_area_light("p", np.eye(4), 1.0, 0.0, 1.0)
    builder.add_mesh("o", TRIANGLE, [[0, 1, 2]], 3)
    with pytest.raises(SceneError, match=r"face_material points outside"):
        builder.build()
