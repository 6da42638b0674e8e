"""Normal maps and bump against the normal pass of Cycles, pixel by pixel."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blender.support import add_camera, add_mesh, export, new_material, read_exr, save_exr
from tests.blender.test_export_images import picture

SIZE = 48


def hills(side: int = 12) -> np.ndarray:
    """Texels of a smooth hilly surface: tangent-space normals, and heights as alpha."""
    y, x = np.mgrid[0:side, 0:side] / side * 2 * math.pi
    tilt = np.stack([0.5 * np.cos(x) * np.sin(y), 0.5 * np.sin(x + y), np.ones_like(x)], axis=2)
    tilt /= np.linalg.norm(tilt, axis=2, keepdims=True)
    return np.concatenate([tilt / 2 + 0.5, np.ones((side, side, 1))], axis=2)


def heights(side: int = 12) -> np.ndarray:
    y, x = np.mgrid[0:side, 0:side] / side * 2 * math.pi
    value = 0.5 + 0.25 * np.cos(x) * np.sin(y) + 0.2 * np.sin(x + y)
    return np.stack([value, value, value, np.ones_like(x)], axis=2)


#: A square before an orthographic camera: 2 x 2 and a little tilted against its diagonal.
PLANE = ([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)])


def stage(bpy: Any, shape: Any = PLANE, smooth: bool = False) -> tuple[Any, Any]:
    """Camera and object with an empty diffuse material: the object and the material."""
    camera = add_camera(bpy)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.0
    render = bpy.context.scene.render
    render.resolution_x = render.resolution_y = SIZE
    render.resolution_percentage = 100
    material = new_material(bpy, "M", "ShaderNodeBsdfDiffuse")
    return add_mesh(bpy, "Object", shape, material, uv=True, smooth=smooth), material


def add_normal_map(bpy: Any, material: Any, strength: float = 1.0, **values: Any) -> Any:
    tree = material.node_tree
    image, bend = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeNormalMap")
    image.image = picture(bpy, "N", hills(), space="Non-Color")
    for key, value in values.items():
        setattr(bend, key, value)
    bend.inputs["Strength"].default_value = strength
    tree.links.new(image.outputs["Color"], bend.inputs["Color"])
    tree.links.new(bend.outputs[0], tree.nodes["Diffuse BSDF"].inputs["Normal"])
    return bend


def add_bump(bpy: Any, material: Any, strength: float, distance: float) -> Any:
    tree = material.node_tree
    image, bump = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeBump")
    image.image = picture(bpy, "H", heights(), space="Non-Color")
    bump.inputs["Strength"].default_value = strength
    bump.inputs["Distance"].default_value = distance
    tree.links.new(image.outputs["Color"], bump.inputs["Height"])
    before = tree.nodes["Diffuse BSDF"].inputs["Normal"]
    if before.is_linked:
        tree.links.new(before.links[0].from_socket, bump.inputs["Normal"])
    tree.links.new(bump.outputs[0], before)
    return bump


def in_cycles(bpy: Any, path: Path) -> np.ndarray:
    """Normals (SIZE, SIZE, 3) in the middle of each pixel, zeros beside the object."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.filter_width = 0.01
    bpy.context.view_layer.use_pass_normal = True
    save_exr(bpy, path)
    bpy.ops.render.render(write_still=True)
    scene.render.engine = "PHOTONMAP"
    return next(v for k, v in read_exr(path).items() if k.endswith("Normal"))


def ours(bpy: Any) -> np.ndarray:
    """The same by our kernels, seen from above by parallel rays."""
    from photon_map.core.geometry.interaction import interact
    from photon_map.core.geometry.intersector import Intersector
    from photon_map.core.geometry.mesh import centre_of, centred_mesh
    from photon_map.core.textures.normals import shading_normal
    from photon_map.core.textures.shading import shading_tables

    scene = export(bpy).scene
    centre = centre_of(scene)
    mesh = centred_mesh(scene, centre)
    shading, materials = shading_tables(scene), scene.materials.copy()
    axis = (np.arange(SIZE) + 0.5) / SIZE * 2 - 1
    x, y = np.meshgrid(axis, axis)
    origins = np.stack([x, y, np.full_like(x, 5.0)], axis=2).reshape(-1, 3) - centre.origin
    directions = np.tile([0.0, 0.0, -1.0], (SIZE * SIZE, 1))
    hits = Intersector(mesh).nearest(origins.astype(np.float32), directions.astype(np.float32))
    normals = np.zeros((SIZE * SIZE, 3))
    for k, (face, u, v) in enumerate(zip(hits[0], hits[1], hits[2], strict=True)):
        if face < 0:
            continue
        wo = (0.0, 0.0, 1.0)
        ng, ns = interact(mesh, face, float(u), float(v), wo)[1:3]
        row = materials[mesh.material[face]]
        normals[k] = shading_normal(shading, mesh, row, face, float(u), float(v), ng, ns, wo)
    return normals.reshape(SIZE, SIZE, 3)


def difference(bpy: Any, tmp_path: Path) -> np.ndarray:
    """Angles (n,) [rad] between the two, where both see the object."""
    a, b = ours(bpy), in_cycles(bpy, tmp_path / "cycles.exr")
    seen = (np.abs(a).sum(axis=2) > 0) & (np.abs(b).sum(axis=2) > 0.5)
    assert seen.mean() > 0.4
    cross = np.linalg.norm(np.cross(a[seen], b[seen]), axis=1)
    return np.arctan2(cross, (a[seen] * b[seen]).sum(axis=1))


#: Texture coordinates of the square's corners: as it is, turned, mirrored, sheared.
LAYOUTS = {
    "plain": [0, 0, 1, 0, 1, 1, 0, 1],
    "turned": [0, 1, 0, 0, 1, 0, 1, 1],
    "mirrored": [1, 0, 0, 0, 0, 1, 1, 1],
    "sheared": [0, 0, 1, 0.5, 1.5, 2, 0.5, 1.5],
}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("strength", [0.5, 1.0, 2.0])
def test_normal_maps(bpy: Any, tmp_path: Path, layout: str, strength: float) -> None:
    obj, material = stage(bpy)
    obj.data.uv_layers[0].uv.foreach_set("vector", np.array(LAYOUTS[layout], np.float32))
    add_normal_map(bpy, material, strength)
    angle = difference(bpy, tmp_path)
    assert np.quantile(angle, 0.99) < 2e-3


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize(("strength", "distance"), [(1.0, 0.1), (0.5, 0.2), (1.0, -0.1)])
def test_bump(bpy: Any, tmp_path: Path, layout: str, strength: float, distance: float) -> None:
    obj, material = stage(bpy)
    obj.data.uv_layers[0].uv.foreach_set("vector", np.array(LAYOUTS[layout], np.float32))
    node = add_bump(bpy, material, strength, abs(distance))
    node.invert = distance < 0
    # Where a tenth of a pixel, Cycles' step, meets the border of a texel the slope is mixed.
    angle = difference(bpy, tmp_path)
    assert np.quantile(angle, 0.8) < 5e-3


def test_bump_over_a_normal_map(bpy: Any, tmp_path: Path) -> None:
    _, material = stage(bpy)
    add_normal_map(bpy, material)
    add_bump(bpy, material, 1.0, 0.1)
    assert np.quantile(difference(bpy, tmp_path), 0.95) < 5e-3


def test_the_back_of_a_sheet(bpy: Any, tmp_path: Path) -> None:
    obj, material = stage(bpy)
    obj.rotation_euler = (math.pi, 0.0, 0.0)
    add_normal_map(bpy, material)
    add_bump(bpy, material, 1.0, 0.1)
    assert np.quantile(difference(bpy, tmp_path), 0.95) < 5e-3


def globe(rings: int = 24, segments: int = 48) -> tuple[list, list]:
    """A sphere of quads around z, cut open at the poles."""
    points = [
        (
            0.9
            * math.sin(math.pi * (i + 1) / (rings + 1))
            * math.cos(2 * math.pi * j / segments),
            0.9
            * math.sin(math.pi * (i + 1) / (rings + 1))
            * math.sin(2 * math.pi * j / segments),
            0.9 * math.cos(math.pi * (i + 1) / (rings + 1)),
        )
        for i in range(rings)
        for j in range(segments)
    ]
    faces = [
        (
            i * segments + j,
            (i + 1) * segments + j,
            (i + 1) * segments + (j + 1) % segments,
            i * segments + (j + 1) % segments,
        )
        for i in range(rings - 1)
        for j in range(segments)
    ]
    return points, faces


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (-1.0, 1.0, 1.0)])
def test_a_smooth_globe(bpy: Any, tmp_path: Path, scale: tuple[float, float, float]) -> None:
    """The tangent of each face stands for the one smoothed over corners: 3 degrees."""
    obj, material = stage(bpy, globe(), smooth=True)
    obj.rotation_euler, obj.scale = (1.2, 0.3, 0.0), scale
    layer = obj.data.uv_layers[0]
    for polygon in obj.data.polygons:
        row, column = divmod(polygon.index, 48)
        for loop, (di, dj) in zip(
            polygon.loop_indices, ((0, 0), (1, 0), (1, 1), (0, 1)), strict=True
        ):
            layer.uv[loop].vector = ((column + dj) / 12, (row + di) / 6)
    add_normal_map(bpy, material)
    angle = difference(bpy, tmp_path)
    assert np.quantile(angle, 0.5) < math.radians(0.5)
    assert np.quantile(angle, 0.95) < math.radians(3.0)
