"""Blender's empty scene with short ways to put things into it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import bpy
import mathutils
import numpy as np

Triple = Sequence[float]
#: Down, for lamps.
DOWN = (0.0, 0.0, 0.0)


class Stage:
    """The scene being built; ``folder`` takes image files."""

    def __init__(self, folder: Path, size: tuple[int, int]) -> None:
        self.folder = folder
        self.scene = bpy.context.scene
        render = self.scene.render
        render.resolution_x, render.resolution_y = size
        render.resolution_percentage = 100
        self.world((0.0, 0.0, 0.0))

    def link(self, obj: Any) -> Any:
        self.scene.collection.objects.link(obj)
        return obj

    def world(self, color: Triple, strength: float = 1.0) -> Any:
        """A world of one colour; its node tree is returned."""
        world = self.scene.world or bpy.data.worlds.new("World")
        self.scene.world = world
        # Large enough for the suite's skies; Blender's automatic size takes seconds.
        world.cycles.sampling_method, world.cycles.sample_map_resolution = "MANUAL", 256
        node = world.node_tree.nodes["Background"]
        node.inputs["Color"].default_value = (*color, 1.0)
        node.inputs["Strength"].default_value = strength
        return world.node_tree

    def camera(
        self,
        location: Triple = (0.0, -4.0, 4.0),
        target: Triple = (0.0, 0.0, 0.0),
        **values: Any,
    ) -> Any:
        """The scene's camera, its data set to ``values``."""
        camera = self.link(bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera")))
        aim(camera, location, target)
        for key, value in values.items():
            setattr(camera.data, key, value)
        self.scene.camera = camera
        return camera

    def lamp(
        self,
        kind: str,
        location: Triple = (0.0, 0.0, 2.0),
        rotation: Triple = DOWN,
        **values: Any,
    ) -> Any:
        """A lamp that camera rays do not see; ``rotation`` in degrees, data ``values``."""
        light = bpy.data.lights.new("Lamp", kind)
        for key, value in values.items():
            setattr(light, key, value)
        obj = self.link(bpy.data.objects.new("Lamp", light))
        obj.location = location
        obj.rotation_euler = [math.radians(angle) for angle in rotation]
        obj.visible_camera = False
        return obj

    def materials(self) -> Any:
        """All materials so far."""
        return bpy.data.materials

    def mesh(self, name: str, vertices: Any, faces: Any, *materials: Any) -> Any:
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([tuple(map(float, v)) for v in vertices], [], faces)
        for material in materials:
            mesh.materials.append(material)
        return self.link(bpy.data.objects.new(name, mesh))

    def square(
        self,
        material: Any,
        size: float = 1.0,
        location: Triple = (0.0, 0.0, 0.0),
        rotation: Triple = DOWN,
        name: str = "Square",
    ) -> Any:
        """A square that faces +z before it is turned by ``rotation`` (degrees), with UVs."""
        h = size / 2.0
        corners = [(-h, -h, 0.0), (h, -h, 0.0), (h, h, 0.0), (-h, h, 0.0)]
        obj = self.mesh(name, corners, [(0, 1, 2, 3)], material)
        layer = obj.data.uv_layers.new(name="UVMap")
        layer.uv.foreach_set("vector", [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0])
        obj.location = location
        obj.rotation_euler = [math.radians(angle) for angle in rotation]
        return obj

    def ball(
        self,
        material: Any,
        radius: float = 1.0,
        location: Triple = (0.0, 0.0, 0.0),
        around: int = 24,
        smooth: bool = False,
    ) -> Any:
        """A closed ball of flat faces: both engines get the very same surface."""
        rings = around // 2
        points = [(0.0, 0.0, -radius)]
        for i in range(1, rings):
            theta = math.pi * i / rings
            for k in range(around):
                phi = 2.0 * math.pi * (k + 0.5) / around
                r = radius * math.sin(theta)
                points.append((r * math.cos(phi), r * math.sin(phi), -radius * math.cos(theta)))
        points.append((0.0, 0.0, radius))
        top = len(points) - 1
        faces: list[tuple[int, ...]] = []
        for k in range(around):
            nxt = (k + 1) % around
            faces.append((0, 1 + nxt, 1 + k))
            for i in range(rings - 2):
                low, high = 1 + i * around, 1 + (i + 1) * around
                faces.append((low + k, low + nxt, high + nxt, high + k))
            last = 1 + (rings - 2) * around
            faces.append((last + k, last + nxt, top))
        obj = self.mesh("Ball", points, faces, material)
        obj.location = location
        if smooth:
            obj.data.shade_smooth()
        return obj

    def cube(self, material: Any, size: float = 1.0, location: Triple = DOWN) -> Any:
        """A closed cube, normals outwards."""
        h = size / 2.0
        corners = [(x, y, z) for x in (-h, h) for y in (-h, h) for z in (-h, h)]
        faces = [
            (0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)
        ]  # fmt: skip
        obj = self.mesh("Cube", corners, faces, material)
        obj.location = location
        return obj

    def collection_instance(self, mesh: Any) -> Any:
        """An empty that instances a collection of one object of ``mesh``."""
        group = bpy.data.collections.new("Group")
        group.objects.link(bpy.data.objects.new("Member", mesh))
        empty = self.link(bpy.data.objects.new("Empty", None))
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        return empty

    def nodes(self, name: str = "Material") -> tuple[Any, Any, Any]:
        """An empty material: itself, its node tree and the input for its surface."""
        material = bpy.data.materials.new(name)
        tree = material.node_tree
        tree.nodes.clear()
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        return material, tree, output.inputs["Surface"]

    def node(self, tree: Any, kind: str, **inputs: Any) -> Any:
        """A shader node; colours have three numbers, ``_`` stands for a space, sockets link.

        A key that is no input is a property of the node.
        """
        node = tree.nodes.new("ShaderNode" + kind)
        for key, value in inputs.items():
            if not key[0].isupper():
                setattr(node, key, value)
                continue
            socket = node.inputs[key.replace("_", " ")]
            if isinstance(value, bpy.types.NodeSocket):
                tree.links.new(value, socket)
            elif isinstance(value, (tuple, list)) and socket.type == "RGBA":
                socket.default_value = (*value, 1.0)
            else:
                socket.default_value = value
        return node

    def material(self, kind: str, **inputs: Any) -> Any:
        """A material of one shader node."""
        material, tree, surface = self.nodes(kind)
        tree.links.new(self.node(tree, kind, **inputs).outputs[0], surface)
        return material

    def diffuse(self, *color: float) -> Any:
        return self.material("BsdfDiffuse", Color=color, Roughness=0.0)

    def glow(self, strength: float, *color: float) -> Any:
        return self.material("Emission", Color=color, Strength=strength)

    def image(self, pixels: Any, color_space: str = "sRGB", suffix: str = ".png") -> Any:
        """An image file of (h, w, 4) raw values, first row at the bottom, loaded."""
        pixels = np.asarray(pixels, dtype=np.float32)
        name = f"image{len(bpy.data.images)}"
        high = suffix == ".exr"
        made = bpy.data.images.new(
            name, pixels.shape[1], pixels.shape[0], alpha=True, float_buffer=high
        )
        if high:
            made.colorspace_settings.name = "Linear Rec.709"
        made.pixels.foreach_set(pixels.ravel())
        made.filepath_raw = str(self.folder / (name + suffix))
        made.file_format = "OPEN_EXR" if high else "PNG"
        made.save()
        loaded = bpy.data.images.load(made.filepath_raw)
        loaded.colorspace_settings.name = color_space
        return loaded


def aim(obj: Any, location: Triple, target: Triple) -> None:
    """Place ``obj`` and have its -z axis point at ``target``."""
    obj.location = location
    way = mathutils.Vector(target) - mathutils.Vector(location)
    obj.rotation_euler = way.to_track_quat("-Z", "Y").to_euler()
