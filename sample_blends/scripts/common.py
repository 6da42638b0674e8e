"""What the sample scripts share: rooms, solids of revolution, materials, lamps, saving.

Every script of this folder builds one scene from nothing and writes it:

    python sample_blends/scripts/NAME.py OUT.blend

The Python must have the ``bpy`` wheel 4.2: its files open in Blender 4.2 to 5.2. The content
is deterministic. Lengths are metres.
"""

from __future__ import annotations

import argparse
import math
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

Colour = tuple[float, float, float]
Point = tuple[float, float, float]

WHITE: Colour = (0.73, 0.73, 0.73)
RED: Colour = (0.60, 0.05, 0.04)
GREEN: Colour = (0.10, 0.42, 0.08)
BLUE: Colour = (0.10, 0.20, 0.78)
#: Glass of the report's objects.
GLASS_IOR = 1.52
#: Gap between a solid and what it stands on: no two faces may lie in one plane.
GAP = 0.001


def new_scene(width: int, height: int) -> bpy.types.Scene:
    """Empty the session; return its scene with black world and Standard view transform."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x = width
    scene.render.resolution_y = height
    scene.render.resolution_percentage = 100
    scene.view_settings.view_transform = "Standard"
    scene.render.image_settings.file_format = "PNG"
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    scene.world = world
    return scene


def shader(name: str, node_type: str, **inputs: float | Colour) -> bpy.types.Material:
    """A material of one shader node; ``inputs`` by socket name, ``_`` for a space."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    node = tree.nodes.new(node_type)
    node.location = (-300.0, 0.0)
    for key, value in inputs.items():
        socket = node.inputs[key.replace("_", " ")]
        socket.default_value = (*value, 1.0) if isinstance(value, tuple) else value
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    material.diffuse_color = (*_viewport_colour(inputs.get("Color", WHITE)), 1.0)
    return material


def _viewport_colour(value: float | Colour) -> Colour:
    return value if isinstance(value, tuple) else (value, value, value)


def diffuse(name: str, colour: Colour) -> bpy.types.Material:
    """A Lambert surface of that albedo."""
    return shader(name, "ShaderNodeBsdfDiffuse", Color=colour, Roughness=0.0)


def glass(
    name: str, colour: Colour = (1.0, 1.0, 1.0), ior: float = GLASS_IOR, roughness: float = 0.0
) -> bpy.types.Material:
    """Glass, smooth and of the report's index when nothing else is said."""
    return shader(name, "ShaderNodeBsdfGlass", Color=colour, Roughness=roughness, IOR=ior)


def refraction(name: str) -> bpy.types.Material:
    """Glass as the report drew it before it knew Fresnel's terms: none is mirrored."""
    return shader(name, "ShaderNodeBsdfRefraction", Roughness=0.0, IOR=GLASS_IOR)


def mirror(name: str, colour: Colour = (0.9, 0.9, 0.9)) -> bpy.types.Material:
    """A perfect mirror that reflects that share of the light at every angle."""
    return shader(name, "ShaderNodeBsdfGlossy", Color=colour, Roughness=0.0)


def add_mesh(
    name: str,
    vertices: Sequence[Point],
    faces: Sequence[Sequence[int]],
    materials: Sequence[bpy.types.Material],
    *,
    smooth_below: float = 0.0,
    face_material: Sequence[int] | None = None,
) -> bpy.types.Object:
    """A mesh object in the scene; edges flatter than ``smooth_below`` degrees are smooth."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    for material in materials:
        mesh.materials.append(material)
    if face_material is not None:
        mesh.polygons.foreach_set("material_index", list(face_material))
    if smooth_below > 0.0:
        mesh.shade_smooth()
        mesh.set_sharp_from_angle(angle=math.radians(smooth_below))
    mesh.validate()
    mesh.update()
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_room(
    low: Point,
    high: Point,
    materials: dict[str, bpy.types.Material],
    *,
    name: str = "Room",
) -> bpy.types.Object:
    """An axis-aligned room seen from inside, one mesh with a material per wall.

    ``materials`` has the keys floor, ceiling, left (-X), right (+X), front (-Y), back (+Y);
    a wall without a material is left open (and may be an object of its own: photons are
    aimed at whole objects, so a mirror wall should be one).
    """
    corners = [
        (x, y, z)
        for z in (low[2], high[2])
        for y in (low[1], high[1])
        for x in (low[0], high[0])
    ]
    walls = {
        "floor": (0, 1, 3, 2),
        "ceiling": (4, 6, 7, 5),
        "left": (0, 2, 6, 4),
        "right": (1, 5, 7, 3),
        "front": (0, 4, 5, 1),
        "back": (2, 3, 7, 6),
    }
    kept = [wall for wall in walls if wall in materials]
    used = sorted({corner for wall in kept for corner in walls[wall]})
    slots = list({id(materials[wall]): materials[wall] for wall in kept}.values())
    return add_mesh(
        name,
        [corners[corner] for corner in used],
        [[used.index(corner) for corner in walls[wall]] for wall in kept],
        slots,
        face_material=[slots.index(materials[wall]) for wall in kept],
    )


def add_box(
    name: str, centre: Point, size: Point, material: bpy.types.Material, turn: float = 0.0
) -> bpy.types.Object:
    """A flat-shaded cuboid with outward normals, turned by ``turn`` degrees about Z."""
    x, y, z = (0.5 * edge for edge in size)
    vertices = [(i * x, j * y, k * z) for k in (-1, 1) for j in (-1, 1) for i in (-1, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3)]
    box = add_mesh(name, vertices, faces, [material])
    box.location = centre
    box.rotation_euler[2] = math.radians(turn)
    return box


def lathe(
    name: str,
    profile: Sequence[tuple[float, float]],
    material: bpy.types.Material,
    *,
    segments: int = 96,
    closed: bool = False,
    smooth_below: float = 40.0,
) -> bpy.types.Object:
    """A solid of revolution about Z from a profile of (radius, height).

    The profile runs so that the solid lies on its left (counter-clockwise in the r-z
    plane), then normals point outwards. An end with radius 0 becomes a pole, ``closed``
    joins the last point to the first (a ring).
    """
    vertices: list[Point] = []
    rings: list[list[int]] = []
    for radius, height in profile:
        count = 1 if radius == 0.0 else segments
        rings.append(list(range(len(vertices), len(vertices) + count)))
        for i in range(count):
            angle = 2.0 * math.pi * i / segments
            vertices.append((radius * math.cos(angle), radius * math.sin(angle), height))
    faces: list[tuple[int, ...]] = []
    pairs = list(zip(rings, rings[1:] + rings[:1], strict=True))
    for lower, upper in pairs if closed else pairs[:-1]:
        for i in range(segments):
            j = (i + 1) % segments
            a, b = lower[i % len(lower)], lower[j % len(lower)]
            c, d = upper[j % len(upper)], upper[i % len(upper)]
            faces.append(tuple(dict.fromkeys((a, b, c, d))))
    return add_mesh(name, vertices, faces, [material], smooth_below=smooth_below)


def arc(
    centre: tuple[float, float], radius: float, start: float, end: float, steps: int
) -> list[tuple[float, float]]:
    """Points (radius, height) of an arc for ``lathe``, angles in degrees from +r to +z."""
    points = []
    for i in range(steps + 1):
        angle = math.radians(start + (end - start) * i / steps)
        r = centre[0] + radius * math.cos(angle)
        points.append((0.0 if abs(r) < 1e-9 else r, centre[1] + radius * math.sin(angle)))
    return points


def add_sphere(
    name: str, centre: Point, radius: float, material: bpy.types.Material, *, detail: int = 5
) -> bpy.types.Object:
    """A smooth icosphere; ``detail`` 5 has 5120 faces."""
    import bmesh

    mesh = bpy.data.meshes.new(name)
    shape = bmesh.new()
    bmesh.ops.create_icosphere(shape, subdivisions=detail, radius=radius)
    shape.to_mesh(mesh)
    shape.free()
    mesh.materials.append(material)
    mesh.shade_smooth()
    sphere = bpy.data.objects.new(name, mesh)
    sphere.location = centre
    bpy.context.scene.collection.objects.link(sphere)
    return sphere


def add_point_light(
    name: str, location: Point, power: float, radius: float, colour: Colour = (1.0, 1.0, 1.0)
) -> bpy.types.Object:
    """A spherical point lamp (soft falloff off: a true sphere, not a turned disk)."""
    light = bpy.data.lights.new(name, "POINT")
    light.energy = power
    light.shadow_soft_size = radius
    light.color = colour
    light.use_soft_falloff = False
    return _add_light(name, light, location)


def add_area_light(name: str, location: Point, power: float, size: float) -> bpy.types.Object:
    """A square area lamp that shines straight down."""
    light = bpy.data.lights.new(name, "AREA")
    light.energy = power
    light.shape = "SQUARE"
    light.size = size
    return _add_light(name, light, location)


def add_aimed_light(
    name: str, kind: str, location: Point, target: Point, strength: float, angle: float
) -> bpy.types.Object:
    """A SUN [W/m^2] whose disc, or a SPOT [W] whose cone, is ``angle`` degrees across."""
    light = bpy.data.lights.new(name, kind)
    light.energy = strength
    if kind == "SUN":
        light.angle = math.radians(angle)
    else:
        light.spot_size, light.spot_blend = math.radians(angle), 0.1
        light.shadow_soft_size, light.use_soft_falloff = 0.01, False
    lamp = _add_light(name, light, location)
    way = Vector(target) - Vector(location)
    lamp.rotation_euler = way.to_track_quat("-Z", "Y").to_euler()
    return lamp


def show_in(frame: int, thing: bpy.types.Object) -> None:
    """Render ``thing`` in that one of the frames 1 and 2 only."""
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 2
    for at in (1, 2):
        thing.hide_render = at != frame
        thing.keyframe_insert("hide_render", frame=at)


def _add_light(name: str, light: bpy.types.Light, location: Point) -> bpy.types.Object:
    lamp = bpy.data.objects.new(name, light)
    lamp.location = location
    bpy.context.scene.collection.objects.link(lamp)
    return lamp


def add_camera(
    location: Point,
    target: Point,
    lens: float,
    *,
    f_stop: float = 0.0,
    focus: Point | None = None,
) -> bpy.types.Object:
    """The scene's camera, looking at ``target``; ``focus`` is a point in the sharp plane."""
    data = bpy.data.cameras.new("Camera")
    data.lens = lens
    data.clip_start = 0.01
    camera = bpy.data.objects.new("Camera", data)
    look = Vector(target) - Vector(location)
    turn = look.to_track_quat("-Z", "Y").to_matrix().to_4x4()
    camera.matrix_world = Matrix.Translation(location) @ turn
    if focus is not None:
        data.dof.use_dof = True
        data.dof.aperture_fstop = f_stop
        data.dof.focus_distance = axis_distance(location, target, focus)
    scene = bpy.context.scene
    scene.collection.objects.link(camera)
    scene.camera = camera
    return camera


def axis_distance(location: Point, target: Point, point: Point) -> float:
    """Distance of ``point`` from a camera along its axis, as a focus distance counts [m]."""
    axis = (Vector(target) - Vector(location)).normalized()
    return float((Vector(point) - Vector(location)).dot(axis))


class _Photonmap(bpy.types.RenderEngine):  # type: ignore[misc]
    """Stand-in, so that bpy accepts and stores the engine's name without the add-on."""

    bl_idname = "PHOTONMAP"
    bl_label = "Photon Map"


def save(path: Path, passes: int) -> None:
    """Write the session with engine PHOTONMAP and that many passes, compressed."""
    scene = bpy.context.scene
    bpy.utils.register_class(_Photonmap)
    scene.render.engine = "PHOTONMAP"
    # Until 4.x a plain ID property of this name is what the add-on's settings read.
    scene["photon_map"] = {"passes": passes}
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), compress=True)
    bpy.utils.unregister_class(_Photonmap)


def run(build: Callable[[], None], passes: int = 32) -> None:
    """Command line of a sample script: build the scene and write it to the path given."""
    parser = argparse.ArgumentParser(description="Write a sample .blend (bpy 4.2).")
    parser.add_argument("out", type=Path, help="path of the .blend to write")
    out: Path = parser.parse_args().out
    build()
    save(out, passes)
    if not os.path.getsize(out):
        raise SystemExit(f"{out}: nothing was written")
