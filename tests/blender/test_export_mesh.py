"""Geometry: what Blender evaluates is what the core gets."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tests.blender.support import (
    SQUARE,
    add_camera,
    add_cube,
    add_mesh,
    export,
    link,
    new_material,
)


def area(triangles: np.ndarray) -> float:
    a, b, c = np.moveaxis(triangles, 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def test_a_cube_keeps_its_place_and_faces_outwards(bpy: Any) -> None:
    add_camera(bpy)
    cube = add_cube(bpy, "Cube")
    cube.location = (1000.0, 2.0, 3.0)
    cube.rotation_euler = (0.3, 0.2, 0.1)
    cube.scale = (1.0, 2.0, 0.5)
    got = export(bpy)
    triangles = got.vertices_of("Cube")
    assert triangles.shape == (12, 3, 3)
    assert got.scene.vertices.dtype == np.float64
    outwards = triangles.mean(axis=1) - np.array([1000.0, 2.0, 3.0])
    assert (np.einsum("ij,ij->i", outwards, got.normals_of("Cube")) > 0).all()
    assert area(triangles) == pytest.approx(2 * (4 * 2 + 4 * 0.5 + 4 * 2 * 0.5), rel=1e-5)
    assert not got.scene.corner_normals.any(), "a flat cube has no shading normals"
    assert got.warnings == ()


def test_a_mirrored_object_still_faces_outwards(bpy: Any) -> None:
    add_camera(bpy)
    cube = add_cube(bpy, "Cube", smooth=True)
    cube.scale = (-1.0, 2.0, 3.0)
    cube.rotation_euler = (0.5, 0.0, 0.0)
    got = export(bpy)
    outwards = got.vertices_of("Cube").mean(axis=1)
    assert (np.einsum("ij,ij->i", outwards, got.normals_of("Cube")) > 0).all()
    # A smooth corner's normal points away from the centre, on the geometric side.
    normals = got.scene.corner_normals.astype(float)
    assert np.linalg.norm(normals, axis=2) == pytest.approx(1.0, abs=1e-5)
    assert (np.einsum("fck,fck->fc", normals, got.vertices_of("Cube")) > 0).all()


def test_normals_go_by_the_inverse_transpose(bpy: Any) -> None:
    """On an ellipsoid they are the gradient of its equation."""
    import bmesh

    add_camera(bpy)
    mesh = bpy.data.meshes.new("Ball")
    ball = bmesh.new()
    bmesh.ops.create_icosphere(ball, subdivisions=4, radius=1.0)
    ball.to_mesh(mesh)
    ball.free()
    mesh.shade_smooth()
    obj = link(bpy, bpy.data.objects.new("Ball", mesh))
    obj.scale = (1.0, 2.0, 4.0)
    got = export(bpy)
    points = got.vertices_of("Ball")
    gradient = points / np.array([1.0, 4.0, 16.0])
    gradient /= np.linalg.norm(gradient, axis=2, keepdims=True)
    assert got.scene.corner_normals == pytest.approx(gradient, abs=0.02)


def test_an_object_scaled_flat_keeps_its_normal(bpy: Any) -> None:
    add_camera(bpy)
    square = add_mesh(bpy, "Flat", SQUARE, smooth=True)
    square.scale = (1.0, 1.0, 0.0)
    got = export(bpy)
    assert np.broadcast_to([0.0, 0.0, 1.0], (2, 3, 3)) == pytest.approx(
        got.scene.corner_normals, abs=1e-6
    )


def test_flat_and_smooth_faces_in_one_mesh(bpy: Any) -> None:
    add_camera(bpy)
    cube = add_cube(bpy, "Cube", smooth=True)
    cube.data.polygons[0].use_smooth = False
    got = export(bpy)
    has_normals = got.scene.corner_normals.any(axis=(1, 2))
    assert has_normals.sum() == 10


def test_render_level_modifiers(bpy: Any) -> None:
    add_camera(bpy)
    cube = add_cube(bpy, "Cube")
    modifier = cube.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, 2
    hidden = add_cube(bpy, "Viewport only")
    off = hidden.modifiers.new("Subdivision", "SUBSURF")
    off.render_levels, off.show_render = 3, False
    got = export(bpy)
    assert len(got.vertices_of("Cube")) == 6 * 4**2 * 2
    assert len(got.vertices_of("Viewport only")) == 12


def test_curve_surface_text_and_metaball(bpy: Any) -> None:
    add_camera(bpy)
    curve = bpy.data.curves.new("Curve", "CURVE")
    curve.dimensions = "3D"
    curve.bevel_depth = 0.1
    spline = curve.splines.new("POLY")
    spline.points.add(1)
    spline.points[1].co = (1.0, 0.0, 0.0, 1.0)
    link(bpy, bpy.data.objects.new("Curve", curve))
    text = bpy.data.curves.new("Text", "FONT")
    text.body = "A"
    link(bpy, bpy.data.objects.new("Text", text))
    ball = bpy.data.metaballs.new("Meta")
    ball.elements.new()
    link(bpy, bpy.data.objects.new("Meta", ball)).location = (10.0, 0.0, 0.0)
    bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    surface = bpy.context.object.name
    got = export(bpy)
    for name in ("Curve", "Text", "Meta", surface):
        assert len(got.vertices_of(name)) > 0, name
    assert got.vertices_of("Meta").mean() == pytest.approx(10.0 / 3, abs=0.2)
    assert area(got.vertices_of("Curve")) > 0.4
    # Each surface once: twins would make glass of zero thickness.
    assert sorted(got.scene.object_names) == sorted(["Curve", "Text", "Meta", surface])


def test_material_of_each_face(bpy: Any) -> None:
    add_camera(bpy)
    red = new_material(bpy, "Red", "ShaderNodeBsdfDiffuse", Color=(1.0, 0.0, 0.0, 1.0))
    blue = new_material(bpy, "Blue", "ShaderNodeBsdfDiffuse", Color=(0.0, 0.0, 1.0, 1.0))
    cube = add_cube(bpy, "Cube", red, None, blue)
    for polygon in cube.data.polygons:
        polygon.material_index = polygon.index % 3
    got = export(bpy)
    rows = [got.scene.material_names[i] for i in got.scene.face_material]
    assert sorted(rows) == sorted(["Red"] * 4 + ["(none)"] * 4 + ["Blue"] * 4)
    assert got.warnings == ("object 'Cube': material slot 2 is empty, its faces are grey",)
    for normal, name in zip(got.normals_of("Cube"), rows, strict=True):
        expected = {(-1, 0, 0): "Red", (1, 0, 0): "(none)", (0, -1, 0): "Blue"}
        key = tuple(int(round(v)) for v in normal)
        assert expected.get(key, name) == name


def test_material_linked_to_the_object_wins(bpy: Any) -> None:
    add_camera(bpy)
    red = new_material(bpy, "Red", "ShaderNodeBsdfDiffuse")
    blue = new_material(bpy, "Blue", "ShaderNodeBsdfDiffuse")
    cube = add_cube(bpy, "Cube", red)
    cube.material_slots[0].link = "OBJECT"
    cube.material_slots[0].material = blue
    assert export(bpy).scene.material_names == ("Blue",)


def test_material_override_of_the_view_layer(bpy: Any) -> None:
    add_camera(bpy)
    add_cube(bpy, "Cube", new_material(bpy, "Red", "ShaderNodeBsdfDiffuse"))
    add_cube(bpy, "Bare")
    bpy.context.view_layer.material_override = new_material(bpy, "Clay")
    assert export(bpy).scene.material_names == ("Clay",)


def test_faces_without_area_are_left_out_and_counted(bpy: Any) -> None:
    add_camera(bpy)
    shape = ([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 1, 3)])
    add_mesh(bpy, "Sliver", shape)
    got = export(bpy)
    assert len(got.scene.faces) == 1
    assert got.warnings == ("faces without an area are left out: 1",)


def test_custom_normals_are_kept(bpy: Any) -> None:
    add_camera(bpy)
    square = add_mesh(bpy, "Square", SQUARE)
    tilted = (math.sin(0.3), 0.0, math.cos(0.3))
    square.data.normals_split_custom_set([tilted] * 4)
    got = export(bpy)
    assert got.scene.corner_normals == pytest.approx(
        np.broadcast_to(tilted, (2, 3, 3)), abs=1e-3
    )
