"""Small scenes in Blender, and what the add-on makes of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parents[2]

#: A square in the plane z = 0, side 2, facing +z.
SQUARE = (
    [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)],
    [(0, 1, 2, 3)],
)


class Exported(NamedTuple):
    """What a render of the current scene would hand to the core."""

    scene: Any
    settings: Any
    warnings: tuple[str, ...]

    def vertices_of(self, name: str) -> np.ndarray:
        """Corners (F, 3, 3) of the triangles of the objects called ``name``."""
        rows = [i for i, n in enumerate(self.scene.object_names) if n == name]
        faces = self.scene.faces[np.isin(self.scene.face_object, rows)]
        return self.scene.vertices[faces]

    def normals_of(self, name: str) -> np.ndarray:
        """Geometric unit normals (F, 3) by the winding."""
        a, b, c = np.moveaxis(self.vertices_of(name), 1, 0)
        cross = np.cross(b - a, c - a)
        return cross / np.linalg.norm(cross, axis=1, keepdims=True)

    def material(self, name: str) -> Any:
        """Row of the material table."""
        return self.scene.materials[self.scene.material_names.index(name)]

    def closures_of(self, material: str) -> list[Any]:
        """Rows of the closure table of ``material``."""
        row = self.material(material)
        return list(self.scene.closures[row["closure_start"] :][: row["closure_count"]])

    def lobes_of(self, material: str) -> list[Any]:
        """Rows of the lobe table of ``material``."""
        row = self.material(material)
        return list(self.scene.lobes[row["lobe_start"] :][: row["lobe_count"]])

    def emission_of(self, material: str) -> np.ndarray:
        return np.array(self.material(material)["emission"])


def export(bpy: Any, **overrides: Any) -> Exported:
    """Export the current scene through the render operator; raises what the user sees."""
    from photon_map.addon import headless
    from photon_map.addon.job import Job

    job = Job(overrides=overrides, export_only=True)
    headless._run(bpy.context.scene, job, png_path=None)
    return Exported(job.scene, job.settings, job.warnings)


def link(bpy: Any, obj: Any) -> Any:
    """Put ``obj`` into the scene."""
    bpy.context.scene.collection.objects.link(obj)
    return obj


def add_camera(bpy: Any, location: Sequence[float] = (0.0, 0.0, 5.0)) -> Any:
    """A camera that looks down from ``location``, as the scene's."""
    camera = link(bpy, bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")))
    camera.location = location
    bpy.context.scene.camera = camera
    return camera


def add_mesh(
    bpy: Any,
    name: str,
    shape: tuple[list, list] = SQUARE,
    *materials: Any,
    smooth: bool = False,
    uv: bool = False,
    material: Any = None,
) -> Any:
    """An object of vertices and faces with material slots.

    ``uv``: with a map, of 0..1 for x and y in -1..1.
    """
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(shape[0], [], shape[1])
    if uv:
        layer = mesh.uv_layers.new(name="UVMap")
        for loop, corner in zip(mesh.loops, layer.uv, strict=True):
            x, y, _ = mesh.vertices[loop.vertex_index].co
            corner.vector = ((x + 1) / 2, (y + 1) / 2)
    for used in (*materials, *([material] if material else [])):
        mesh.materials.append(used)
    if smooth:
        mesh.shade_smooth()
    return link(bpy, bpy.data.objects.new(name, mesh))


def add_cube(bpy: Any, name: str, *materials: Any, smooth: bool = False) -> Any:
    """A cube of side 2, outward normals."""
    corners = [(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return add_mesh(bpy, name, (corners, faces), *materials, smooth=smooth)


def add_light(bpy: Any, kind: str, name: str = "Light", **values: Any) -> Any:
    """A lamp of ``kind`` with properties ``values`` of its data."""
    light = bpy.data.lights.new(name, kind)
    for key, value in values.items():
        setattr(light, key, value)
    return link(bpy, bpy.data.objects.new(name, light))


def new_material(bpy: Any, name: str, node: str = "", **inputs: Any) -> Any:
    """A material whose surface is one shader node with the given inputs.

    Input names are written with underscores for spaces.
    """
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    if node:
        shader = tree.nodes.new(node)
        for key, value in inputs.items():
            shader.inputs[key.replace("_", " ")].default_value = value
        tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def save_exr(bpy: Any, path: Any) -> None:
    """Have the next render with ``write_still`` write a float32 multilayer EXR."""
    render = bpy.context.scene.render
    if hasattr(render.image_settings, "media_type"):
        render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    render.filepath = str(path)


def headless_render(bpy: Any, **overrides: Any) -> Any:
    """Render the current scene to its file path as a script would; the finished job."""
    from photon_map.addon.job import Job, running

    with running(Job(overrides=overrides)) as job:
        try:
            bpy.ops.render.render(write_still=True)
        except RuntimeError:
            if job.interrupted:
                raise KeyboardInterrupt from None
            raise
    return job


def read_exr(path: Any) -> dict[str, np.ndarray]:
    """Layers of an EXR as (height, width, channels) float32, the bottom row first.

    Blender calls channels ``<view layer>.<pass>.<letter>``; the key is without the letter.
    """
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {
            name: channel.pixels[::-1].copy()
            for part in file.parts  # Blender 5 writes a part for each pass
            for name, channel in part.channels.items()
        }
    layers: dict[str, list[str]] = {}
    for name in channels:
        layers.setdefault(name.rpartition(".")[0], []).append(name)
    order = "UVRGBAXYZWrgba"
    return {
        layer: np.stack(
            [channels[n] for n in sorted(names, key=lambda n: order.index(n[-1]))], axis=2
        )
        for layer, names in layers.items()
    }
