"""Which objects are in the picture, and how often."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.blender.support import (
    SQUARE,
    add_camera,
    add_cube,
    add_light,
    add_mesh,
    export,
    link,
    new_material,
)


def test_instances_of_a_collection(bpy: Any) -> None:
    add_camera(bpy)
    source = bpy.data.collections.new("Source")
    cube = bpy.data.objects.new("Cube", add_cube(bpy, "Original").data)
    source.objects.link(cube)
    cube.location = (0.0, 1.0, 0.0)
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    source.objects.link(lamp)
    for x in (10.0, 20.0):
        empty = link(bpy, bpy.data.objects.new("Empty", None))
        empty.instance_type, empty.instance_collection = "COLLECTION", source
        empty.location = (x, 0.0, 0.0)
        empty.scale = (1.0, 1.0, -2.0)
    got = export(bpy)
    centres = [
        got.scene.vertices[got.scene.faces[got.scene.face_object == i]].mean(axis=(0, 1))
        for i, name in enumerate(got.scene.object_names)
        if name == "Cube"
    ]
    assert sorted(map(tuple, np.round(centres, 5))) == [(10.0, 1.0, 0.0), (20.0, 1.0, 0.0)]
    assert sorted(got.scene.lights["position"][:, 0]) == [10.0, 20.0]
    triangles = got.vertices_of("Cube")
    centre = np.array([15.0, 1.0, 0.0])
    outwards = (triangles.mean(axis=1) - centre) * np.array([0.0, 1.0, 1.0])
    side = np.abs(got.normals_of("Cube")[:, 0]) < 0.5
    assert (np.einsum("ij,ij->i", outwards, got.normals_of("Cube"))[side] > 0).all()


def geometry_nodes(bpy: Any, obj: Any, build: Any) -> None:
    """Give ``obj`` a node modifier whose tree ``build(tree, input, output)`` links."""
    tree = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    build(tree, start.outputs[0], end.inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = tree


def test_instances_of_geometry_nodes(bpy: Any) -> None:
    """A cube with a material of its own on each of the four points of a square."""
    add_camera(bpy)
    square = add_mesh(bpy, "Square", SQUARE)
    gold = new_material(bpy, "Gold", "ShaderNodeBsdfGlossy", Roughness=0.0)

    def build(tree: Any, start: Any, end: Any) -> None:
        cube = tree.nodes.new("GeometryNodeMeshCube")
        paint = tree.nodes.new("GeometryNodeSetMaterial")
        paint.inputs["Material"].default_value = gold
        spread = tree.nodes.new("GeometryNodeInstanceOnPoints")
        tree.links.new(cube.outputs["Mesh"], paint.inputs["Geometry"])
        tree.links.new(start, spread.inputs["Points"])
        tree.links.new(paint.outputs["Geometry"], spread.inputs["Instance"])
        tree.links.new(spread.outputs["Instances"], end)

    geometry_nodes(bpy, square, build)
    got = export(bpy)
    assert len(got.scene.faces) == 4 * 12
    assert got.scene.material_names == ("Gold",)
    assert got.scene.vertices.min() == pytest.approx(-1.5)
    assert got.scene.vertices.max() == pytest.approx(1.5)


def test_materials_set_by_geometry_nodes(bpy: Any) -> None:
    add_camera(bpy)
    cube = add_cube(bpy, "Cube", new_material(bpy, "Old", "ShaderNodeBsdfDiffuse"))
    new = new_material(bpy, "New", "ShaderNodeBsdfDiffuse")

    def build(tree: Any, start: Any, end: Any) -> None:
        paint = tree.nodes.new("GeometryNodeSetMaterial")
        paint.inputs["Material"].default_value = new
        tree.links.new(start, paint.inputs["Geometry"])
        tree.links.new(paint.outputs["Geometry"], end)

    geometry_nodes(bpy, cube, build)
    got = export(bpy)
    assert {got.scene.material_names[i] for i in got.scene.face_material} == {"New"}


def test_one_mesh_in_two_objects_with_different_modifiers(bpy: Any) -> None:
    add_camera(bpy)
    first = add_cube(bpy, "First")
    second = link(bpy, bpy.data.objects.new("Second", first.data))
    second.modifiers.new("S", "SUBSURF").render_levels = 1
    got = export(bpy)
    assert len(got.vertices_of("First")) == 12
    assert len(got.vertices_of("Second")) == 48


def test_curves_that_share_data_keep_their_own_modifiers(bpy: Any) -> None:
    add_camera(bpy)
    text = bpy.data.curves.new("Text", "FONT")
    text.body = "I"
    link(bpy, bpy.data.objects.new("Plain", text))
    solid = link(bpy, bpy.data.objects.new("Solid", text))
    solid.modifiers.new("S", "SOLIDIFY").thickness = 0.2
    got = export(bpy)
    assert len(got.vertices_of("Solid")) > len(got.vertices_of("Plain")) > 0


def test_hidden_objects_are_left_out(bpy: Any) -> None:
    add_camera(bpy)
    add_cube(bpy, "Shown")
    add_cube(bpy, "Not in renders").hide_render = True
    add_cube(bpy, "Only hidden in the viewport").hide_viewport = True
    add_light(bpy, "POINT", "Dark").hide_render = True
    excluded = bpy.data.collections.new("Excluded")
    bpy.context.scene.collection.children.link(excluded)
    excluded.objects.link(bpy.data.objects.new("Elsewhere", bpy.data.meshes["Shown"]))
    bpy.context.view_layer.layer_collection.children["Excluded"].exclude = True
    got = export(bpy)
    assert set(got.scene.object_names) == {"Shown", "Only hidden in the viewport"}
    assert got.scene.light_names == ()


def test_an_instancer_that_is_not_shown_itself(bpy: Any) -> None:
    add_camera(bpy)
    parent = add_cube(bpy, "Parent")
    child = add_cube(bpy, "Child")
    child.parent = parent
    parent.instance_type = "VERTS"
    parent.show_instancer_for_render = False
    got = export(bpy)
    assert len(got.vertices_of("Parent")) == 0
    assert len(got.vertices_of("Child")) == 8 * 12


def test_what_cannot_be_rendered_is_named_once(bpy: Any) -> None:
    add_camera(bpy)
    volume = bpy.data.volumes.new("Smoke")
    link(bpy, bpy.data.objects.new("Smoke", volume))
    add_cube(bpy, "Catcher").is_shadow_catcher = True
    warnings = export(bpy).warnings
    assert len(warnings) == 2
    assert "object 'Smoke' is left out: volumes are not supported" in warnings
    assert any("shadow catchers" in text and "'Catcher'" in text for text in warnings)


def test_rays_that_do_not_see_an_object(bpy: Any) -> None:
    from photon_map.core.scene.tables import Visibility

    add_camera(bpy)
    for name in ("camera", "diffuse", "glossy", "transmission", "shadow"):
        setattr(add_cube(bpy, name), f"visible_{name}", False)
    group = bpy.data.collections.new("Group")
    bpy.context.scene.collection.children.link(group)
    group.objects.link(add_cube(bpy, "all"))
    bpy.context.scene.collection.objects.unlink(bpy.data.objects["all"])
    bpy.context.view_layer.layer_collection.children["Group"].indirect_only = True
    got = export(bpy)
    assert not got.warnings
    for name, bits in zip(got.scene.object_names, got.scene.object_visibility, strict=True):
        missing = Visibility.CAMERA if name == "all" else Visibility[name.upper()]
        assert bits == Visibility.ALL & ~missing, name


def test_caustic_switches(bpy: Any) -> None:
    from photon_map.core.scene.tables import Visibility

    add_camera(bpy)
    add_cube(bpy, "both")
    add_cube(bpy, "casts none").photon_map.casts_caustics = False
    add_cube(bpy, "shows none").photon_map.shows_caustics = False
    got = export(bpy)
    bits = dict(zip(got.scene.object_names, got.scene.object_visibility, strict=True))
    assert bits == {
        "both": Visibility.ALL,
        "casts none": Visibility.ALL | Visibility.CASTS_NONE,
        "shows none": Visibility.ALL | Visibility.SHOWS_NONE,
    }


def test_two_view_layers_differ(bpy: Any) -> None:
    """The export takes the layer that is rendered."""
    from photon_map.addon import headless
    from photon_map.addon.job import Job

    seen: dict[str, tuple[str, ...]] = {}

    class Listener(Job):
        def exported(self, layer: str, scene: Any, settings: Any, warnings: Any) -> None:
            seen[layer] = scene.object_names
            super().exported(layer, scene, settings, warnings)

    add_camera(bpy)
    add_cube(bpy, "Both")
    only = bpy.data.collections.new("Only")
    bpy.context.scene.collection.children.link(only)
    only.objects.link(bpy.data.objects.new("First only", bpy.data.meshes["Both"]))
    bpy.context.scene.view_layers.new("Second").layer_collection.children["Only"].exclude = True
    bpy.context.scene.view_layers.new("Off").use = False
    headless._run(bpy.context.scene, Listener(export_only=True), png_path=None)
    assert sorted(seen.pop("Second")) == ["Both"]
    assert [sorted(names) for names in seen.values()] == [["Both", "First only"]]
