"""Image Texture nodes: coordinates, mapping, channels, and where they may stand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from photon_map.core.scene.dump import load_scene, save_scene
from photon_map.core.scene.tables import Channel, ClosureKind, Extension
from tests.blender.support import Exported, add_camera, add_mesh, export, new_material
from tests.blender.test_export_images import picture, textured

IDENTITY = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]


def uv_of(got: Exported, layer: int, name: str = "Square") -> np.ndarray:
    """Corners (F, 3, 2) of the object's triangles in one set."""
    row = got.scene.object_names.index(name)
    return got.scene.uvs[layer][got.scene.face_object == row]


def new(material: Any, node: str, **values: Any) -> Any:
    made = material.node_tree.nodes.new(node)
    for key, value in values.items():
        setattr(made, key, value)
    return made


def connect(material: Any, output: Any, node: str, name: str | int) -> None:
    material.node_tree.links.new(output, material.node_tree.nodes[node].inputs[name])


def test_a_textured_colour(bpy: Any) -> None:
    add_camera(bpy)
    textured(bpy, picture(bpy), extension="MIRROR", interpolation="Closest")
    got = export(bpy)
    (row,) = got.closures_of("M")
    assert row["kind"] == ClosureKind.DIFFUSE
    assert row["color"]["texture"] == 0
    assert row["color"]["value"].tolist() == [1.0, 1.0, 1.0]
    (texture,) = got.scene.textures
    assert texture["to_image"].tolist() == IDENTITY
    assert texture["extension"] == Extension.MIRROR
    assert texture["interpolation"] == 1
    assert got.warnings == ()
    # The square spans -1..1, its map 0..1: the coordinates are those of the corners.
    corners = got.vertices_of("Square")[..., :2]
    assert uv_of(got, 0) == pytest.approx((corners + 1) / 2)


def test_uv_maps_by_name_and_the_active_one(bpy: Any) -> None:
    add_camera(bpy)
    material = textured(bpy, picture(bpy))
    mesh = bpy.data.objects["Square"].data
    second = mesh.uv_layers.new(name="Second")
    values = np.arange(8, dtype=np.float32)
    second.uv.foreach_set("vector", values)
    got = export(bpy)
    assert got.scene.uvs.shape[0] == 1
    assert got.scene.uvs.max() == 1.0, "the first map is active for rendering"
    second.active_render = True
    assert export(bpy).scene.uvs.max() == 7.0
    by_name = new(material, "ShaderNodeUVMap", uv_map="UVMap")
    connect(material, by_name.outputs[0], "Image Texture", "Vector")
    got = export(bpy)
    assert got.scene.uvs.max() == 1.0
    other = new(material, "ShaderNodeTexImage", name="Other", image=picture(bpy, "Q"))
    connect(material, other.outputs["Color"], "Diffuse BSDF", "Roughness")
    got = export(bpy)
    assert len(got.scene.uvs) == 2
    assert sorted(got.scene.textures["uv"].tolist()) == [0, 1]
    assert sorted(uv_of(got, k).max() for k in (0, 1)) == [1.0, 7.0]


def test_meshes_without_the_map_have_zeros(bpy: Any) -> None:
    add_camera(bpy)
    material = textured(bpy, picture(bpy))
    add_mesh(bpy, "Bare", material=material)
    got = export(bpy)
    assert not uv_of(got, 0, "Bare").any()
    assert uv_of(got, 0).any()


def test_mirrored_instances_keep_their_corners(bpy: Any) -> None:
    add_camera(bpy)
    textured(bpy, picture(bpy))
    bpy.data.objects["Square"].scale = (-1.0, 1.0, 1.0)
    got = export(bpy)
    corners = got.vertices_of("Square")[..., :2] * [-1, 1]
    assert uv_of(got, 0) == pytest.approx((corners + 1) / 2)


def test_seams_split_by_corner(bpy: Any) -> None:
    """Two faces that share an edge and not their coordinates."""
    add_camera(bpy)
    textured(bpy, picture(bpy))
    shape = ([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)])
    obj = add_mesh(bpy, "Seam", shape, uv=True, material=bpy.data.materials["M"])
    coordinates = np.arange(12, dtype=np.float32)
    obj.data.uv_layers[0].uv.foreach_set("vector", coordinates)
    got = uv_of(export(bpy), 0, "Seam")
    assert sorted(got.reshape(-1, 2).tolist()) == coordinates.reshape(-1, 2).tolist()


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR"])
def test_mapping(bpy: Any, kind: str) -> None:
    """As mathutils puts the same three together."""
    import mathutils

    add_camera(bpy)
    material = textured(bpy, picture(bpy))
    node = new(material, "ShaderNodeMapping", vector_type=kind)
    location, rotation, scale = (0.25, -0.5, 0.125), (0.1, -0.2, 0.7), (2.0, 3.0, 0.5)
    for name, value in (("Location", location), ("Rotation", rotation), ("Scale", scale)):
        socket = node.inputs.get(name)
        if socket is not None:
            socket.default_value = value
    coordinates = new(material, "ShaderNodeTexCoord")
    connect(material, coordinates.outputs["UV"], "Mapping", "Vector")
    connect(material, node.outputs[0], "Image Texture", "Vector")
    got = export(bpy)
    if kind == "VECTOR":
        location = (0.0, 0.0, 0.0)
    matrix = mathutils.Matrix.LocRotScale(location, mathutils.Euler(rotation), scale)
    if kind == "TEXTURE":
        matrix.invert()
    expected = np.array(matrix)[:2][:, [0, 1, 3]]
    assert got.scene.textures[0]["to_image"] == pytest.approx(expected, abs=1e-6)
    assert got.warnings == ()


def test_generated_coordinates_warn(bpy: Any) -> None:
    add_camera(bpy)
    material = textured(bpy, picture(bpy), interpolation="Cubic", projection="SPHERE")
    coordinates = new(material, "ShaderNodeTexCoord")
    connect(material, coordinates.outputs["Generated"], "Image Texture", "Vector")
    warnings = " / ".join(export(bpy).warnings)
    for words in ("'Generated' of node 'Texture Coordinate'", "sphere projection", "cubic"):
        assert words in warnings


def principled(bpy: Any, image: Any) -> tuple[Any, Any]:
    """Material M: a Principled shader, and a node of ``image`` linked to nothing yet."""
    add_camera(bpy)
    material = new_material(bpy, "M", "ShaderNodeBsdfPrincipled")
    add_mesh(bpy, "Square", uv=True, material=material)
    return material, new(material, "ShaderNodeTexImage", image=image)


def test_every_input_that_takes_a_texture(bpy: Any) -> None:
    material, node = principled(bpy, picture(bpy))
    names = {
        "color": "Base Color", "roughness": "Roughness", "metallic": "Metallic",
        "transmission": "Transmission Weight", "alpha": "Alpha", "emission": "Emission Color",
    }  # fmt: skip
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Emission Strength"].default_value = 3.0
    for name in names.values():
        connect(material, node.outputs["Color"], "Principled BSDF", name)
    got = export(bpy)
    (row,) = got.closures_of("M")
    assert all(row[name]["texture"] == 0 for name in names)
    channels = {name: row[name]["channel"] for name in names}
    colors = dict.fromkeys(("color", "emission"), Channel.COLOR)
    assert channels == {**dict.fromkeys(names, Channel.LUMINANCE), **colors}
    assert row["emission"]["value"].tolist() == [3.0, 3.0, 3.0]
    assert got.material("M")["passes"] == 1
    assert got.material("M")["ior"] == 1.5
    (warning,) = got.warnings
    assert "no closed body" in warning


def test_textured_strength_and_the_mean_emission(bpy: Any) -> None:
    pixels = np.array([[[1.0, 1.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0]]])
    add_camera(bpy)
    material = new_material(bpy, "M", "ShaderNodeEmission", Color=(1.0, 0.5, 0.25, 1.0))
    add_mesh(bpy, "Square", uv=True, material=material)
    node = new(material, "ShaderNodeTexImage", image=picture(bpy, pixels=pixels))
    connect(material, node.outputs["Color"], "Emission", "Strength")
    got = export(bpy)
    (row,) = got.closures_of("M")
    assert row["emission"]["value"] == pytest.approx([1.0, 0.5, 0.25])
    assert row["emission"]["channel"] == Channel.LUMINANCE
    assert got.emission_of("M") == pytest.approx([0.5, 0.25, 0.125])


def test_alpha_of_a_leaf(bpy: Any) -> None:
    """Colour and alpha of one picture: its colours are divided by alpha, as in Cycles."""
    material, node = principled(bpy, picture(bpy))
    connect(material, node.outputs["Color"], "Principled BSDF", "Base Color")
    assert export(bpy).scene.textures["unassociate"].tolist() == [0]
    connect(material, node.outputs["Alpha"], "Principled BSDF", "Alpha")
    got = export(bpy)
    (row,) = got.closures_of("M")
    assert row["alpha"]["channel"] == Channel.ALPHA
    assert got.scene.textures["unassociate"].tolist() == [1]
    assert got.material("M")["passes"] == 1
    node.image.alpha_mode = "CHANNEL_PACKED"
    assert export(bpy).scene.textures["unassociate"].tolist() == [0]


def test_channels_of_one_picture(bpy: Any) -> None:
    """Occlusion, roughness and metal packed into one image, as glTF has it."""
    material, node = principled(bpy, picture(bpy, space="Non-Color"))
    parts = new(material, "ShaderNodeSeparateColor")
    material.node_tree.links.new(node.outputs["Color"], parts.inputs[0])
    connect(material, parts.outputs["Green"], "Principled BSDF", "Roughness")
    connect(material, parts.outputs["Blue"], "Principled BSDF", "Metallic")
    got = export(bpy)
    (row,) = got.closures_of("M")
    assert row["roughness"]["channel"] == Channel.GREEN
    assert row["metallic"]["channel"] == Channel.BLUE
    assert got.warnings == ()


def test_a_texture_times_a_constant(bpy: Any) -> None:
    material, node = principled(bpy, picture(bpy))
    tree = material.node_tree
    mix = new(material, "ShaderNodeMix", data_type="RGBA", blend_type="MULTIPLY")
    mix.inputs["Factor"].default_value = 1.0
    tint = next(s for s in mix.inputs if s.name == "B" and s.type == "RGBA")
    tint.default_value = (0.5, 0.25, 1.0, 1.0)
    tree.links.new(
        node.outputs["Color"], next(s for s in mix.inputs if s.identifier == "A_Color")
    )
    result = next(s for s in mix.outputs if s.type == "RGBA")
    connect(material, result, "Principled BSDF", "Base Color")
    math = new(material, "ShaderNodeMath", operation="MULTIPLY")
    math.inputs[1].default_value = 0.5
    tree.links.new(node.outputs["Color"], math.inputs[0])
    connect(material, math.outputs[0], "Principled BSDF", "Roughness")
    got = export(bpy)
    (row,) = got.closures_of("M")
    assert row["color"]["value"] == pytest.approx([0.5, 0.25, 1.0])
    assert row["roughness"]["value"][0] == 0.5
    assert row["color"]["texture"] == row["roughness"]["texture"] == 0
    assert got.warnings == ()


def test_what_changes_colours_lets_them_pass_with_one_warning(bpy: Any) -> None:
    material, node = principled(bpy, picture(bpy))
    change = new(material, "ShaderNodeHueSaturation")
    connect(material, node.outputs["Color"], change.name, "Color")
    connect(material, change.outputs[0], "Principled BSDF", "Base Color")
    got = export(bpy)
    assert got.closures_of("M")[0]["color"]["texture"] == 0
    (warning,) = got.warnings
    assert "material 'M'" in warning
    assert f"'{change.name}'" in warning


def test_a_texture_where_only_numbers_may_stand_warns(bpy: Any) -> None:
    material, node = principled(bpy, picture(bpy))
    connect(material, node.outputs["Color"], "Principled BSDF", "Coat Weight")
    got = export(bpy)
    assert got.closures_of("M")[0]["coat"] == 0.0
    (warning,) = got.warnings
    assert "Coat Weight" in warning


def test_textured_mix_factors(bpy: Any) -> None:
    add_camera(bpy)
    material = new_material(bpy, "M", "ShaderNodeBsdfDiffuse")
    tree = material.node_tree
    mix, mirror = new(material, "ShaderNodeMixShader"), new(material, "ShaderNodeBsdfGlossy")
    node = new(material, "ShaderNodeTexImage", image=picture(bpy))
    tree.links.new(node.outputs["Color"], mix.inputs[0])
    tree.links.new(tree.nodes["Diffuse BSDF"].outputs[0], mix.inputs[1])
    tree.links.new(mirror.outputs[0], mix.inputs[2])
    connect(material, mix.outputs[0], "Material Output", "Surface")
    add_mesh(bpy, "Square", uv=True, material=material)
    first, second = export(bpy).closures_of("M")
    for row, invert in ((first, 1), (second, 0)):
        assert row["factor_count"] == 1
        assert row["factors"][0]["param"]["texture"] == 0
        assert row["factors"][0]["param"]["channel"] == Channel.LUMINANCE
        assert row["factors"][0]["invert"] == invert


def test_normal_map_and_bump(bpy: Any) -> None:
    material, node = principled(bpy, picture(bpy, space="Non-Color"))
    tree = material.node_tree
    bend, bump = new(material, "ShaderNodeNormalMap"), new(material, "ShaderNodeBump")
    bend.inputs["Strength"].default_value = 0.5
    tree.links.new(node.outputs["Color"], bend.inputs["Color"])
    connect(material, bend.outputs[0], "Principled BSDF", "Normal")
    got = export(bpy)
    row = got.material("M")
    assert (row["normal_texture"], row["bump_texture"]) == (0, -1)
    assert row["normal_strength"] == 0.5
    assert got.warnings == ()
    heights = new(material, "ShaderNodeTexImage", image=picture(bpy, "H"))
    tree.links.new(heights.outputs["Color"], bump.inputs["Height"])
    tree.links.new(bend.outputs[0], bump.inputs["Normal"])
    bump.inputs["Strength"].default_value = 0.75
    bump.inputs["Distance"].default_value = 0.25
    connect(material, bump.outputs[0], "Principled BSDF", "Normal")
    got = export(bpy)
    row = got.material("M")
    assert row["normal_texture"] >= 0
    assert row["bump_texture"] >= 0
    assert row["bump_texture"] != row["normal_texture"]
    assert (row["bump_strength"], row["bump_distance"]) == (0.75, 0.25)
    bump.invert = True
    assert export(bpy).material("M")["bump_distance"] == -0.25
    assert got.warnings == ()


def test_a_normal_map_for_directx_has_its_green_turned(bpy: Any) -> None:
    material, node = principled(bpy, picture(bpy, space="Non-Color"))
    bend = new(material, "ShaderNodeNormalMap")
    if not hasattr(bend, "convention"):
        pytest.skip("normal maps are all OpenGL's before 5.2")
    bend.convention = "DIRECTX"
    material.node_tree.links.new(node.outputs["Color"], bend.inputs["Color"])
    connect(material, bend.outputs[0], "Principled BSDF", "Normal")
    got = export(bpy)
    plain = np.rint(np.linspace(0, 1, 24).reshape(-1, 4) * 255)
    assert np.abs(got.scene.texels8[:, 1] - (255 - plain[:, 1])).max() <= 1
    assert (got.scene.texels8[:, [0, 2]] == plain[:, [0, 2]]).all()


def test_normal_maps_in_other_spaces_warn(bpy: Any) -> None:
    material, node = principled(bpy, picture(bpy))
    bend = new(material, "ShaderNodeNormalMap", space="OBJECT")
    material.node_tree.links.new(node.outputs["Color"], bend.inputs["Color"])
    connect(material, bend.outputs[0], "Principled BSDF", "Normal")
    got = export(bpy)
    assert got.material("M")["normal_texture"] == -1
    (warning,) = got.warnings
    assert "'Normal Map'" in warning


def test_a_scene_file_keeps_the_pictures(bpy: Any, tmp_path: Path) -> None:
    add_camera(bpy)
    textured(bpy, picture(bpy))
    got = export(bpy)
    save_scene(tmp_path / "scene.npz", got.scene, got.settings)
    loaded, _ = load_scene(tmp_path / "scene.npz")
    for name in ("textures", "images", "texels8", "texels32", "uvs"):
        ours, theirs = getattr(got.scene, name), getattr(loaded, name)
        assert ours.dtype == theirs.dtype
        assert ours.shape == theirs.shape
        if ours.dtype.names is None:
            assert ours.tobytes() == theirs.tobytes()
        else:
            assert all((ours[n] == theirs[n]).all() for n in ours.dtype.names)
