"""A ``Scene`` in words that every renderer knows: surfaces by material, lamps, a camera.

The converters to Cycles, Mitsuba, LuxCore and POV-Ray start from these parts, so all engines
get the same triangles, colours and powers. ``SceneError`` says what has no common word.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from photon_map.core import CameraData, Scene, SceneError
from photon_map.core.scene.tables import ClosureKind, LightKind, Model, Visibility

Kind = Literal["diffuse", "mirror", "glass", "rough glass", "glow"]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Matter:
    """A material. ``color``: albedo, reflectivity, or radiance of "glow"; linear RGB.

    ``roughness``: alpha of GGX, single scattering.
    """

    name: str
    kind: Kind
    color: tuple[float, float, float]
    ior: float = 0.0
    roughness: float = 0.0


@dataclass(frozen=True)
class Surface:
    """Triangles of one material: vertices (V, 3) f4, faces (F, 3) i4.

    ``normals`` (V, 3) f4 of smooth surfaces, None where every face is flat.
    """

    name: str
    matter: Matter
    vertices: NDArray[np.float32]
    faces: NDArray[np.int32]
    normals: NDArray[np.float32] | None = None

    def write_ply(self, path: Path) -> None:
        """Write a binary PLY file, the format that the other engines read fast."""
        fields = ["x", "y", "z"] + (["nx", "ny", "nz"] if self.normals is not None else [])
        columns = [self.vertices] + ([self.normals] if self.normals is not None else [])
        header = ["ply", "format binary_little_endian 1.0"]
        header += [f"element vertex {len(self.vertices)}"]
        header += [f"property float {name}" for name in fields]
        header += [f"element face {len(self.faces)}"]
        header += ["property list uchar int vertex_indices", "end_header"]
        rows = np.zeros(len(self.faces), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
        rows["n"], rows["i"] = 3, self.faces
        with open(path, "wb") as file:
            file.write(("\n".join(header) + "\n").encode())
            file.write(np.ascontiguousarray(np.hstack(columns), "<f4").tobytes())
            file.write(rows.tobytes())


@dataclass(frozen=True)
class Parts:
    """A scene: surfaces, rows of the light table, the world and the camera."""

    surfaces: tuple[Surface, ...]
    lamps: tuple[Any, ...]
    world: Array
    world_map: NDArray[np.float32] | None
    camera: CameraData
    size: float


def parts_of(scene: Scene) -> Parts:
    """Take ``scene`` apart; ``SceneError`` for what not every engine could show."""
    camera = scene.camera
    if camera is None or camera.kind != "PERSPECTIVE" or camera.width != camera.height:
        raise SceneError("the benchmark's cameras are square and perspective")
    if (scene.object_visibility != int(Visibility.ALL)).any():
        raise SceneError("every ray sees every object of a benchmark")
    matters = [matter_of(scene, i) for i in range(len(scene.materials))]
    surfaces = []
    pairs = np.stack([scene.face_object, scene.face_material], axis=1)
    for thing, material in np.unique(pairs, axis=0):
        chosen = (pairs == (thing, material)).all(axis=1)
        name = f"{scene.object_names[thing]} {material}".replace(" ", "_")
        surfaces.append(surface_of(scene, chosen, name, matters[material]))
    lamps = tuple(np.array(row) for row in scene.lights)
    for row in lamps:
        if row["kind"] == LightKind.SPOT or row["visibility"] != int(Visibility.ALL):
            raise SceneError("a benchmark's lamps are points, suns and visible areas")
        if row["kind"] == LightKind.POINT and row["radius"] > 0:
            raise SceneError("a benchmark's point lamps have no radius")
    world_map = scene.world_map if scene.world_map.size else None
    if world_map is not None and not np.allclose(scene.world_rotation, np.eye(3)):
        raise SceneError("a benchmark's sky is not turned")
    extent = np.ptp(scene.vertices, axis=0)
    size = float(np.linalg.norm(extent))
    return Parts(tuple(surfaces), lamps, scene.world, world_map, camera, size)


def surface_of(scene: Scene, chosen: NDArray[np.bool_], name: str, matter: Matter) -> Surface:
    """The chosen faces, with the vertices that they use."""
    faces = scene.faces[chosen]
    used, renumbered = np.unique(faces, return_inverse=True)
    corners = renumbered.reshape(-1, 3).astype(np.int32)
    normals = None
    if scene.corner_normals[chosen].any():
        if matter.kind != "diffuse":
            raise SceneError(f"{name}: engines differ in smooth normals of all but diffuse")
        normals = np.zeros((len(used), 3), np.float32)
        normals[corners.ravel()] = scene.corner_normals[chosen].reshape(-1, 3)
    points = scene.vertices[used].astype(np.float32)
    return Surface(name, matter, points, corners, normals)


def matter_of(scene: Scene, row: int) -> Matter:
    """The material of row ``row`` of the table."""
    material, name = scene.materials[row], scene.material_names[row]
    first, count = int(material["closure_start"]), int(material["closure_count"])
    if material["emission"].any() and not count and not material["lobe_count"]:
        return Matter(name, "glow", triple(material["emission"]))
    if count == 1 and scene.closures[first]["kind"] == ClosureKind.GLASS:
        glass = scene.closures[first]
        rough = float(glass["roughness"]["value"][0]) ** 2
        if glass["distribution"] == 0:
            color = triple(glass["color"]["value"])
            return Matter(name, "rough glass", color, float(glass["ior"]), rough)
    if not count and material["lobe_count"] == 1 and not material["emission"].any():
        lobe = scene.lobes[int(material["lobe_start"])]
        kinds: dict[int, Kind] = {
            Model.DIFFUSE: "diffuse", Model.CONDUCTOR: "mirror", Model.DIELECTRIC: "glass"
        }  # fmt: skip
        if int(lobe["model"]) in kinds:
            kind = kinds[int(lobe["model"])]
            ior = float(lobe["ior"]) if kind == "glass" else 0.0
            return Matter(name, kind, triple(lobe["weight"]), ior)
    raise SceneError(f"material '{name}' has no word that every engine knows")


def triple(values: Any) -> tuple[float, float, float]:
    """Three plain numbers."""
    return float(values[0]), float(values[1]), float(values[2])


#: Suns of engines that have none stand so many scene sizes away.
FAR = 400.0


def lamp_corners(row: Any) -> Array:
    """Corners (4, 3) of a rectangle lamp, counter-clockwise as seen from its bright side."""
    x, y = row["axis_x"] * row["size_x"] / 2, row["axis_y"] * row["size_y"] / 2
    p = row["position"]
    return np.array([p - x - y, p - x + y, p + x + y, p + x - y])


def sun_disk(row: Any, parts: Parts, middle: Array) -> tuple[Array, float, Array]:
    """Centre, radius and radiance of a far disk that shines as the sun ``row`` does."""
    half = float(row["angle"]) / 2.0
    distance = FAR * parts.size
    radiance = row["emission"] / (np.pi * np.sin(half) ** 2)
    return middle + distance * row["axis_z"], distance * float(np.tan(half)), radiance


def sun_frame(row: Any, random: np.random.Generator) -> Array:
    """Frame (4, 4) whose z goes the way of the light of one place of a sun's disk."""
    angle = 2 * np.pi * random.random()
    sine = np.sin(float(row["angle"]) / 2) * np.sqrt(random.random())
    cosine = np.sqrt(1 - sine * sine)
    x, y, z = (np.asarray(row[f"axis_{c}"], float) for c in "xyz")
    way = -(sine * np.cos(angle) * x + sine * np.sin(angle) * y + cosine * z)
    way /= np.linalg.norm(way)
    side = np.cross(x if abs(x @ way) < 0.9 else y, way)
    side /= np.linalg.norm(side)
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1], frame[:3, 2] = side, np.cross(way, side), way
    return frame
