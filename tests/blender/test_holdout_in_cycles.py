"""What is held out, as objects, collections and materials, beside Cycles on the same scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from tests.blender.support import (
    SQUARE,
    add_camera,
    add_cube,
    add_light,
    add_mesh,
    export,
    headless_render,
    link,
    new_material,
    read_exr,
    save_exr,
)


def collection(bpy: Any, name: str, *objects: Any) -> Any:
    """A collection in the scene that alone holds ``objects``."""
    group = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(group)
    for obj in objects:
        bpy.context.scene.collection.objects.unlink(obj)
        group.objects.link(obj)
    return group


def build(bpy: Any, transparent: bool) -> None:
    """A floor before the sky; held out: a glowing cube, a veil, a cube in a collection.

    A mirror stands behind them and shows them.
    """
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    scene.render.film_transparent = transparent
    camera = add_camera(bpy, (0.0, -7.0, 2.5))
    camera.rotation_euler = (1.3, 0.0, 0.0)
    brown = new_material(bpy, "Brown", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.3, 0.1, 1))
    add_mesh(bpy, "Floor", SQUARE, brown).scale = (3, 2, 1)
    mirror = new_material(bpy, "Mirror", "ShaderNodeBsdfGlossy", Roughness=0.0)
    behind = add_mesh(bpy, "Mirror", SQUARE, mirror)
    behind.location, behind.rotation_euler, behind.scale = (
        (0, 2.5, 1),
        (1.5708, 0, 0),
        (3, 1, 1),
    )
    glow = new_material(bpy, "Glow", "ShaderNodeEmission", Strength=1.5, Color=(1, 0.5, 0.2, 1))
    veil = new_material(bpy, "Veil", "ShaderNodeBsdfPrincipled", Alpha=0.4)
    held = [add_cube(bpy, "Glowing", glow), add_cube(bpy, "Grey", brown)]
    held.append(add_mesh(bpy, "Veil", SQUARE, veil))
    for x, obj in zip((-1.8, 1.8, 0.0), held, strict=True):
        obj.location, obj.scale = (x, 0.0, 0.7), (0.5, 0.5, 0.5)
    held[2].rotation_euler = (1.5708, 0, 0)
    held[0].is_holdout = held[2].is_holdout = True
    collection(bpy, "Group", held[1])
    bpy.context.view_layer.layer_collection.children["Group"].holdout = True
    add_light(bpy, "SUN", energy=2.0).rotation_euler = (0.4, 0.3, 0)
    world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    scene.world = world
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.6, 1)
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_cryptomatte_object = True
    layer.use_pass_diffuse_color = True


def rendered(bpy: Any, engine: str, folder: Path) -> dict[str, np.ndarray]:
    """Passes by their names before 5.0."""
    bpy.context.scene.render.engine = engine
    save_exr(bpy, folder / f"{engine}.exr")
    headless_render(bpy)
    passes = {k.split(".")[1]: v for k, v in read_exr(folder / f"{engine}.exr").items()}
    return {{"Diffuse Color": "DiffCol"}.get(k, k): v for k, v in passes.items()}


def nothing_in(hole: np.ndarray, image: np.ndarray) -> None:
    """No light in the pixels of a hole; at its rim what the filter brings of other pixels.

    A pixel's paths may all miss what its filter (1.5 pixels wide) hardly reaches, while
    photons that are connected with the camera bring their little share of it.
    """
    assert (image[ndimage.binary_erosion(hole, np.ones((3, 3)))] == 0.0).all()
    assert image[hole].max() < 0.002 * image[~hole].mean()


@pytest.mark.parametrize("transparent", [True, False])
def test_held_out_is_a_hole_as_in_cycles(bpy: Any, tmp_path: Path, transparent: bool) -> None:
    import addon_utils

    build(bpy, transparent)
    addon_utils.enable("cycles")
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.use_denoising = 256, False
    scene.cycles.use_adaptive_sampling = False
    # 64 paths at least in each pixel, where the picture is even half of the mean.
    scene.photon_map.passes = 128
    cycles, ours = (rendered(bpy, name, tmp_path) for name in ("CYCLES", "PHOTONMAP"))
    combined = [image["Combined"] for image in (cycles, ours)]
    # A hole, a veil over something (that is half a hole), and something whole.
    black = [image[..., 3] < 0.02 for image in combined]
    part = (combined[0][..., 3] > 0.2) & (combined[0][..., 3] < 0.7)
    whole = [image[..., 3] > 0.999 for image in combined]
    assert (black[0] != black[1]).mean() < 0.02 and black[1].mean() > 0.02
    assert (whole[0] != whole[1]).mean() < 0.05
    assert part.sum() > 20
    hole = combined[1][..., 3] == 0.0
    assert hole.mean() > 0.02
    nothing_in(hole, combined[1])
    # The share of the veil's hole: 64 choices of 0.4 or 0.6 scatter by 0.06 in each pixel.
    assert combined[1][part].mean(axis=0) == pytest.approx(
        combined[0][part].mean(axis=0), rel=0.05
    )
    both = whole[0] & whole[1]
    # The mirror shows the bodies as they are: their light is in the rest of the picture.
    assert combined[1][both].mean(axis=0) == pytest.approx(
        combined[0][both].mean(axis=0), rel=0.02
    )
    # Data shows nothing where the hole is.
    deep = (combined[0][..., 3] == 0.0) & hole
    for name in ("Depth", "Normal", "DiffCol", "CryptoObject00"):
        np.testing.assert_array_equal(ours[name][deep], cycles[name][deep], err_msg=name)


def build_materials(bpy: Any, transparent: bool) -> None:
    """A floor, and before a mirror a cube of which two sides are a Holdout shader."""
    build(bpy, transparent)
    for name in ("Glowing", "Grey", "Veil"):
        bpy.data.objects.remove(bpy.data.objects[name])
    black = new_material(bpy, "Hole", "ShaderNodeHoldout")
    cube = add_cube(bpy, "Cube", bpy.data.materials["Brown"])
    cube.data.materials.append(black)
    cube.location, cube.rotation_euler = (0.3, 0.2, 0.5), (0.0, 0.0, 0.5)
    cube.scale = (0.5, 0.5, 0.5)
    for polygon in cube.data.polygons:
        # One that the camera sees, and one that the mirror shows.
        polygon.material_index = int(abs(polygon.normal[1]) > 0.5)


@pytest.mark.parametrize("transparent", [True, False])
def test_the_holdout_shader_is_a_hole_as_in_cycles(
    bpy: Any, tmp_path: Path, transparent: bool
) -> None:
    import addon_utils

    build_materials(bpy, transparent)
    addon_utils.enable("cycles")
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.use_denoising = 256, False
    scene.cycles.use_adaptive_sampling = False
    scene.photon_map.passes = 64
    cycles, ours = (rendered(bpy, name, tmp_path) for name in ("CYCLES", "PHOTONMAP"))
    combined = [image["Combined"] for image in (cycles, ours)]
    hole = [image[..., 3] == 0.0 for image in combined]
    assert (hole[0] != hole[1]).mean() < 0.02 and hole[1].mean() > 0.02
    nothing_in(hole[1], combined[1])
    # In the mirror and in its shadow it is a black side of a cube.
    both = (combined[0][..., 3] > 0.999) & (combined[1][..., 3] > 0.999)
    assert combined[1][both].mean(axis=0) == pytest.approx(
        combined[0][both].mean(axis=0), rel=0.02
    )
    shown = both & (combined[0][..., :3].max(axis=2) < 0.02)
    assert shown.sum() >= 5, "the mirror shows no black side"
    assert combined[1][shown].max(axis=0)[:3] == pytest.approx(0.0, abs=0.1)
    assert combined[1][shown].mean(axis=0)[:3] == pytest.approx(0.0, abs=0.02)
    deep = hole[0] & hole[1]
    for name in ("Depth", "Normal", "DiffCol", "CryptoObject00"):
        np.testing.assert_array_equal(ours[name][deep], cycles[name][deep], err_msg=name)


def test_a_mixed_holdout_is_black_and_said(bpy: Any) -> None:
    add_camera(bpy)
    material = new_material(bpy, "Mixed", "ShaderNodeHoldout")
    tree = material.node_tree
    mix, glow = (tree.nodes.new(f"ShaderNode{name}") for name in ("MixShader", "Emission"))
    output = tree.get_output_node("CYCLES")
    hole = output.inputs["Surface"].links[0].from_node
    mix.inputs[0].default_value = 0.25
    tree.links.new(hole.outputs[0], mix.inputs[1])
    tree.links.new(glow.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    add_cube(bpy, "Cube", material)
    got = export(bpy)
    (warning,) = got.warnings
    assert "'Mixed'" in warning and "Holdout" in warning
    from photon_map.core.scene.tables import Visibility

    assert not (got.scene.object_visibility & Visibility.HOLDOUT).any()
    assert got.scene.materials["emission"][-1] == pytest.approx([0.25] * 3)
    mix.inputs[0].default_value = 0.0
    got = export(bpy)
    assert not got.warnings
    assert (got.scene.object_visibility & Visibility.HOLDOUT).all()


def test_it_is_the_instancer_that_holds_out(bpy: Any) -> None:
    from photon_map.core.scene.tables import Visibility

    add_camera(bpy)
    group = collection(bpy, "Group", add_cube(bpy, "Child"))
    bpy.context.view_layer.layer_collection.children["Group"].exclude = True
    for name, held in (("Plain", False), ("Held", True)):
        empty = link(bpy, bpy.data.objects.new(name, None))
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        empty.is_holdout = held
    got = export(bpy)
    assert not got.warnings
    assert got.scene.object_names == ("Child", "Child")
    bits = got.scene.object_visibility & Visibility.HOLDOUT
    assert sorted(bits) == [0, Visibility.HOLDOUT]
