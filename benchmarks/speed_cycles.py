"""Cycles as a peer: the scene as Blender's objects, rendered sample range by sample range.

Its seconds are those that Cycles counts itself: synchronising and building are left out.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import bpy
import mathutils
import numpy as np
from cycles_peer import quiet, rendering_seconds, set_up, write_image
from measure import Image, read_exr, write_exr
from speed_parts import Matter, Parts, Surface, parts_of

from photon_map.core import Scene
from photon_map.core.scene.tables import LightKind

#: Samples of the whole sequence, of which every render takes a range.
SEQUENCE = 1 << 16


def version() -> str:
    """Name and version."""
    return f"Cycles, bpy {bpy.app.version_string}"


def snapshots(
    scene: Scene, engine: str, times: Sequence[float], seed: int, threads: int, ready: Any
) -> Iterator[tuple[float, Image]]:
    """Seconds and image (h, w, 3), row 0 at the top, soon after each of ``times``.

    Ranges of one sequence of samples are added up, so the result is that of one render.
    """
    parts = parts_of(scene)
    with tempfile.TemporaryDirectory() as folder:
        blender = open_parts(parts, Path(folder), threads)
        blender.render.use_persistent_data = True
        blender.cycles.seed = seed
        out = Path(folder) / "image.exr"
        render_range(blender, out, 0, 1)
        ready()
        shape = (parts.camera.height, parts.camera.width, 3)
        total, count, seconds, rate = np.zeros(shape), 0, 0.0, 0.0
        for at in times:
            while count == 0 or seconds < at:
                samples = 1 if rate == 0 else max(1, round(1.02 * (at - seconds) * rate))
                if count:
                    samples = min(samples, 4 * count)
                samples = min(samples, SEQUENCE - count)
                seconds += render_range(blender, out, count, samples)
                total += samples * read_exr(out)
                count += samples
                rate = count / max(seconds, 1e-3)
            yield seconds, total / count


def render_range(blender: Any, out: Path, first: int, count: int) -> float:
    """Render ``count`` samples of the sequence from ``first`` on; seconds."""
    cycles = blender.cycles
    cycles.samples = SEQUENCE
    cycles.use_sample_subset = True
    cycles.sample_offset, cycles.sample_subset_length = first, count
    write_image(blender, out)
    return rendering_seconds(out)


def open_parts(parts: Parts, folder: Path, threads: int) -> Any:
    """An empty file with the scene in it, set up for Cycles."""
    with quiet():
        bpy.ops.wm.read_factory_settings(use_empty=True)
    blender = bpy.context.scene
    materials: dict[str, Any] = {}
    for surface in parts.surfaces:
        if surface.matter.name not in materials:
            materials[surface.matter.name] = material_of(surface.matter)
        add_surface(blender, surface, materials[surface.matter.name])
    for i, row in enumerate(parts.lamps):
        add_lamp(blender, i, row)
    add_world(blender, parts, folder)
    add_camera(blender, parts)
    set_up(blender, parts.camera.width, parts.camera.height, threads)
    return blender


def add_surface(blender: Any, surface: Surface, material: Any) -> None:
    """One mesh object."""
    mesh = bpy.data.meshes.new(surface.name)
    count = len(surface.faces)
    mesh.vertices.add(len(surface.vertices))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(surface.vertices).ravel())
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(surface.faces).ravel())
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    if surface.normals is None:
        mesh.shade_flat()
    else:
        mesh.shade_smooth()
        mesh.normals_split_custom_set_from_vertices(surface.normals.tolist())
    mesh.materials.append(material)
    blender.collection.objects.link(bpy.data.objects.new(surface.name, mesh))


def material_of(matter: Matter) -> Any:
    """A material of one shader node."""
    material = bpy.data.materials.new(matter.name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    kinds = {
        "diffuse": "BsdfDiffuse", "mirror": "BsdfAnisotropic", "glass": "BsdfGlass",
        "rough glass": "BsdfGlass", "glow": "Emission",
    }  # fmt: skip
    node = tree.nodes.new("ShaderNode" + kinds[matter.kind])
    node.inputs["Color"].default_value = (*matter.color, 1.0)
    if matter.kind in ("mirror", "glass", "rough glass"):
        node.inputs["Roughness"].default_value = math.sqrt(matter.roughness)
    if matter.kind in ("glass", "rough glass"):
        node.distribution = "GGX"
        node.inputs["IOR"].default_value = matter.ior
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def add_lamp(blender: Any, i: int, row: Any) -> None:
    """A lamp of Blender's with the same power, seen by every ray."""
    kinds = {LightKind.POINT: "POINT", LightKind.SUN: "SUN", LightKind.RECTANGLE: "AREA"}
    light = bpy.data.lights.new(f"lamp {i}", kinds[LightKind(int(row["kind"]))])
    strongest = float(row["emission"].max())
    light.color = row["emission"] / strongest
    if light.type == "POINT":
        light.energy, light.shadow_soft_size = 4 * math.pi * strongest, 0.0
    elif light.type == "SUN":
        light.energy, light.angle = strongest, float(row["angle"])
    else:
        area = float(row["size_x"] * row["size_y"])
        light.shape, light.energy = "RECTANGLE", strongest * math.pi * area
        light.size, light.size_y = float(row["size_x"]), float(row["size_y"])
    thing = bpy.data.objects.new(f"lamp {i}", light)
    axes = (row["axis_x"], row["axis_y"], row["axis_z"])
    turn = mathutils.Matrix([[float(axis[k]) for axis in axes] for k in range(3)])
    thing.matrix_world = mathutils.Matrix.LocRotScale(
        mathutils.Vector(row["position"]), turn, None
    )
    thing.visible_camera = True
    blender.collection.objects.link(thing)


def add_world(blender: Any, parts: Parts, folder: Path) -> None:
    """The surroundings: one colour, or a picture file in ``folder``."""
    world = bpy.data.worlds.new("world")
    blender.world = world
    world.use_nodes = True
    node = world.node_tree.nodes["Background"]
    node.inputs["Color"].default_value = (*parts.world, 1.0)
    if parts.world_map is not None:
        path = folder / "sky.exr"
        write_exr(path, (parts.world_map * parts.world)[::-1].astype(np.float64), {})
        picture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
        picture.image = bpy.data.images.load(str(path))
        picture.image.colorspace_settings.name = "Linear Rec.709"
        world.node_tree.links.new(picture.outputs["Color"], node.inputs["Color"])


def add_camera(blender: Any, parts: Parts) -> None:
    """A camera of the same view and lens."""
    camera = parts.camera
    data = bpy.data.cameras.new("camera")
    data.lens, data.sensor_width = camera.lens, camera.sensor_width
    data.clip_start, data.clip_end = 1e-3, 1e4
    if camera.lens_radius > 0:
        data.dof.use_dof = True
        data.dof.focus_distance = camera.focus_distance
        data.dof.aperture_fstop = camera.lens * 1e-3 / (2 * camera.lens_radius)
    thing = bpy.data.objects.new("camera", data)
    thing.matrix_world = mathutils.Matrix(camera.matrix.tolist())
    blender.collection.objects.link(thing)
    blender.camera = thing
