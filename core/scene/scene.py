"""The frozen scene: arrays only, everything a render needs to know."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .camera_data import CameraData
from .errors import SceneError as SceneError
from .tables import (
    AOV,
    CLOSURE,
    IMAGE,
    LIGHT,
    LOBE,
    MATERIAL,
    MOST_FACTORS,
    PARAM_NAMES,
    TEXTURE,
    ImageKind,
    LightKind,
    Model,
    Visibility,
)


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """Everything to be rendered, in world space, metres and scene-linear colour.

    vertices        (V, 3) float64
    faces           (F, 3) int32, vertex ids, counter-clockwise seen from outside
    corner_normals  (F, 3, 3) float32 unit shading normals, or zeros: a flat face
    face_material   (F,) int32 row of ``materials``
    face_object     (F,) int32 index into ``object_names``
    object_visibility (O,) int32 ``Visibility`` bits, all by default
    materials       (M,) ``tables.MATERIAL``; lobes (L,) ``tables.LOBE``
    closures        (C,) ``tables.CLOSURE``: of the materials that vary over their surface
    textures        (T,) ``tables.TEXTURE``; images (I,) ``tables.IMAGE``
    texels8         (N, 4) uint8, texels32 (N, 4) float32: what the images show
    uvs             (K, F, 3, 2) float32 texture coordinates of K sets, per face corner
    lights          (N,) ``tables.LIGHT``: the lamps; emissive faces come by material
    light_photons   (N,) float64 factors above 0 on each lamp's number of photons; the light
                    stays the same, its noise does not
    world           (3,) float64 radiance of the surroundings, or what ``world_map`` is times
    world_map       (h, w, 3) float32 seen all around, equirectangular: columns by
                    0.5 - atan2(y, x) / (2 pi), rows from straight down to straight up
    world_rotation  (3, 3) float64 takes a direction to that of the map
    world_visibility  (1,) int32 ``tables.Visibility`` bits of the surroundings
    luminance       (3,) float64 weights of the channels, summing to 1
    object_index    (O,) int32 a number of the user's for each object
    object_assets   the name of what each object is a part of, its own by default
    shown_uv        (1,) int32 the set of ``uvs`` that the layer "uv" shows, -1 for none
    aovs            (A, M) ``tables.AOV``: values of the user's own, for layers of ``aov_names``
    world_aovs      (A,) ``tables.AOV`` the same of the surroundings, without textures
    mist            (3,) float64 where mist begins, how far it goes [m], and its exponent

    Raises ``SceneError`` at construction when a table contradicts another.
    """

    name: str = "scene"
    vertices: NDArray[np.float64]
    faces: NDArray[np.int32]
    corner_normals: NDArray[np.float32]
    face_material: NDArray[np.int32]
    face_object: NDArray[np.int32]
    materials: NDArray[np.void]
    lobes: NDArray[np.void]
    lights: NDArray[np.void]
    world: NDArray[np.float64]
    camera: CameraData | None
    luminance: NDArray[np.float64] = field(
        default_factory=lambda: np.array([0.2126, 0.7152, 0.0722])
    )
    closures: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, CLOSURE))
    textures: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, TEXTURE))
    images: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, IMAGE))
    texels8: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((0, 4), np.uint8))
    texels32: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 4), np.float32))
    uvs: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 0, 3, 2), np.float32))
    world_map: NDArray[np.float32] = field(
        default_factory=lambda: np.zeros((0, 0, 3), np.float32)
    )
    world_rotation: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))
    world_visibility: NDArray[np.int32] = field(
        default_factory=lambda: np.array([int(Visibility.ALL)], np.int32)
    )
    object_visibility: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))
    light_photons: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    object_index: NDArray[np.int32] = field(default_factory=lambda: np.zeros(0, np.int32))
    shown_uv: NDArray[np.int32] = field(default_factory=lambda: np.array([-1], np.int32))
    mist: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 100.0, 1.0]))
    object_names: tuple[str, ...] = ()
    object_assets: tuple[str, ...] = ()
    material_names: tuple[str, ...] = ()
    light_names: tuple[str, ...] = ()
    aovs: NDArray[np.void] = field(default_factory=lambda: np.zeros((0, 0), AOV))
    world_aovs: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, AOV))
    aov_names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.uvs.shape == (0, 0, 3, 2):
            object.__setattr__(self, "uvs", np.zeros((0, len(self.faces), 3, 2), np.float32))
        # What fits is left alone: the same arrays mean the same scene (``kept``).
        if self.aovs.shape == (0, 0) and len(self.materials):
            object.__setattr__(self, "aovs", np.zeros((0, len(self.materials)), AOV))
        if len(self.world_aovs) == 0 and self.aov_names:
            object.__setattr__(self, "world_aovs", np.zeros(len(self.aov_names), AOV))
        if len(self.object_visibility) == 0:
            seen = np.full(len(self.object_names), int(Visibility.ALL), np.int32)
            object.__setattr__(self, "object_visibility", seen)
        if len(self.object_index) == 0:
            object.__setattr__(self, "object_index", np.zeros(len(self.object_names), np.int32))
        if not self.object_assets:
            object.__setattr__(self, "object_assets", self.object_names)
        if len(self.light_photons) == 0:
            object.__setattr__(self, "light_photons", np.ones(len(self.lights)))
        check_scene(self)
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)


def check_scene(scene: Scene) -> None:
    """Raise ``SceneError`` when shapes, types or indices do not fit, naming the place."""
    count = len(scene.faces)
    expected: dict[str, tuple[tuple[int, ...], np.dtype]] = {
        "vertices": ((len(scene.vertices), 3), np.dtype("f8")),
        "faces": ((count, 3), np.dtype("i4")),
        "corner_normals": ((count, 3, 3), np.dtype("f4")),
        "face_material": ((count,), np.dtype("i4")),
        "face_object": ((count,), np.dtype("i4")),
        "materials": ((len(scene.material_names),), MATERIAL),
        "lobes": ((len(scene.lobes),), LOBE),
        "lights": ((len(scene.light_names),), LIGHT),
        "light_photons": ((len(scene.light_names),), np.dtype("f8")),
        "world": ((3,), np.dtype("f8")),
        "world_map": ((*scene.world_map.shape[:2], 3), np.dtype("f4")),
        "world_rotation": ((3, 3), np.dtype("f8")),
        "world_visibility": ((1,), np.dtype("i4")),
        "luminance": ((3,), np.dtype("f8")),
        "object_visibility": ((len(scene.object_names),), np.dtype("i4")),
        "object_index": ((len(scene.object_names),), np.dtype("i4")),
        "shown_uv": ((1,), np.dtype("i4")),
        "mist": ((3,), np.dtype("f8")),
        "closures": ((len(scene.closures),), CLOSURE),
        "textures": ((len(scene.textures),), TEXTURE),
        "images": ((len(scene.images),), IMAGE),
        "texels8": ((len(scene.texels8), 4), np.dtype("u1")),
        "texels32": ((len(scene.texels32), 4), np.dtype("f4")),
        "world_aovs": ((len(scene.aov_names),), AOV),
        "aovs": ((len(scene.aov_names), len(scene.material_names)), AOV),
        "uvs": ((len(scene.uvs), count, 3, 2), np.dtype("f4")),
    }
    for name, (shape, dtype) in expected.items():
        array = getattr(scene, name)
        if array.shape != shape or array.dtype != dtype:
            raise SceneError(
                f"scene '{scene.name}': {name} is {array.dtype}{array.shape}, "
                f"it must be {dtype}{shape}"
            )
    if len(scene.object_assets) != len(scene.object_names):
        raise SceneError(f"scene '{scene.name}': one asset per object is needed")
    if not (np.isfinite(scene.mist).all() and (scene.mist[1:] > 0).all()):
        raise SceneError(
            f"scene '{scene.name}': depth and exponent of the mist must be above 0"
        )
    limits = {
        "faces": len(scene.vertices),
        "face_material": len(scene.materials),
        "face_object": len(scene.object_names),
    }
    for name, limit in limits.items():
        array = getattr(scene, name)
        if array.size and (array.min() < 0 or array.max() >= limit):
            raise SceneError(f"scene '{scene.name}': {name} points outside 0..{limit - 1}")
    if not np.isfinite(scene.vertices).all():
        raise SceneError(
            f"scene '{scene.name}': a vertex is NaN or infinite; build scenes with "
            "SceneBuilder, which drops such faces and counts them"
        )
    _check_pictures(scene)
    _check_world(scene)
    _check_materials(scene)
    _check_lights(scene)
    _check_camera(scene)


def _check_pictures(scene: Scene) -> None:
    """Kernels follow these indices unchecked."""
    for k, image in enumerate(scene.images):
        floats = image["kind"] in (ImageKind.FLOATS, ImageKind.SRGB_FLOATS)
        stored = len(scene.texels32 if floats else scene.texels8)
        count = int(image["width"]) * int(image["height"])
        inside = 0 <= image["start"] and image["start"] + count <= stored
        if min(image["width"], image["height"]) < 1 or not inside:
            raise SceneError(f"scene '{scene.name}': image {k} lies outside its texels")
    uses = scene.textures["image"]
    if uses.size and (uses.min() < 0 or uses.max() >= len(scene.images)):
        raise SceneError(f"scene '{scene.name}': a texture uses an image that does not exist")
    if not np.isfinite(scene.textures["to_image"]).all():
        raise SceneError(f"scene '{scene.name}': the mapping of a texture is not finite")
    used = [scene.materials["normal_texture"], scene.materials["bump_texture"]]
    used.append(scene.closures["factors"]["param"]["texture"].reshape(-1))
    used.append(scene.aovs["param"]["texture"].reshape(-1))
    used += [scene.closures[name]["texture"] for name in PARAM_NAMES]
    if max((ids.max() for ids in used if ids.size), default=-1) >= len(scene.textures):
        raise SceneError(f"scene '{scene.name}': a material uses a texture that does not exist")
    counts = scene.closures["factor_count"]
    if counts.size and (counts.min() < 0 or counts.max() > MOST_FACTORS):
        raise SceneError(f"scene '{scene.name}': a closure has too many mix factors")


def _check_world(scene: Scene) -> None:
    if not np.isfinite(scene.world).all() or (scene.world < 0).any():
        raise SceneError(f"scene '{scene.name}': the world's radiance must be at least 0")
    if not np.isfinite(scene.world_map).all() or (scene.world_map < 0).any():
        raise SceneError(f"scene '{scene.name}': the world's map must be finite, at least 0")
    turn = scene.world_rotation
    if not np.allclose(turn @ turn.T, np.eye(3), atol=1e-6):
        raise SceneError(f"scene '{scene.name}': the world's rotation turns and scales")


def _check_materials(scene: Scene) -> None:
    for row, name in zip(scene.materials, scene.material_names, strict=True):
        start, stop = row["lobe_start"], row["lobe_start"] + row["lobe_count"]
        if start < 0 or row["lobe_count"] < 0 or stop > len(scene.lobes):
            raise SceneError(f"material '{name}': its lobes lie outside the lobe table")
        first, behind = row["closure_start"], row["closure_start"] + row["closure_count"]
        if first < 0 or row["closure_count"] < 0 or behind > len(scene.closures):
            raise SceneError(f"material '{name}': its closures lie outside the closure table")
        if not np.isfinite(row["emission"]).all() or (row["emission"] < 0).any():
            raise SceneError(f"material '{name}': emission must be finite and not negative")
        for lobe in scene.lobes[start:stop]:
            if lobe["model"] not in list(Model):
                raise SceneError(f"material '{name}': unknown model {lobe['model']}")
            if not np.isfinite(lobe["weight"]).all() or (lobe["weight"] < 0).any():
                raise SceneError(f"material '{name}': lobe weights must be finite, at least 0")
            transmits = lobe["model"] in (Model.DIELECTRIC, Model.REFRACTION)
            if transmits and not (np.isfinite(lobe["ior"]) and lobe["ior"] > 0):
                raise SceneError(f"material '{name}': IOR must be above 0")
            phong = lobe["model"] == Model.PHONG
            if phong and not (np.isfinite(lobe["exponent"]) and lobe["exponent"] >= 0):
                raise SceneError(f"material '{name}': Phong exponent must be at least 0")


def _check_lights(scene: Scene) -> None:
    factors = scene.light_photons
    if not (np.isfinite(factors).all() and (factors > 0).all()):
        raise SceneError(f"scene '{scene.name}': light_photons must be above 0")
    for row, name in zip(scene.lights, scene.light_names, strict=True):
        if row["kind"] not in list(LightKind):
            raise SceneError(f"light '{name}': unknown kind {row['kind']}")
        for field_name in LIGHT.names or ():
            if not np.isfinite(row[field_name]).all():
                raise SceneError(f"light '{name}': {field_name} must be finite")
        if (row["emission"] < 0).any():
            raise SceneError(f"light '{name}': power must not be negative")
        if row["radius"] < 0:
            raise SceneError(f"light '{name}': its radius must be at least 0")
        if not 0 <= row["angle"] <= np.pi:
            raise SceneError(f"light '{name}': its angle must lie between 0 and 180 degrees")
        if row["kind"] in (LightKind.RECTANGLE, LightKind.DISK):
            if not (row["size_x"] > 0 and row["size_y"] > 0):
                raise SceneError(f"light '{name}': an area light needs a size above 0")
            if not 0 < row["spread"] <= np.pi * (1 + 1e-6):
                raise SceneError(f"light '{name}': its spread must be above 0, at most pi")


def _check_camera(scene: Scene) -> None:
    camera = scene.camera
    if camera is None:
        return
    if camera.width < 1 or camera.height < 1:
        raise SceneError(f"camera: size {camera.width}x{camera.height} has no pixel")
    if camera.kind not in ("PERSPECTIVE", "ORTHOGRAPHIC"):
        raise SceneError(f"camera: kind {camera.kind} is unknown")
    if not 0 <= camera.clip_start < camera.clip_end:
        raise SceneError(
            f"camera: clip_start {camera.clip_start} must be at least 0 and below "
            f"clip_end {camera.clip_end}"
        )
    positive = (
        "ortho_scale", "lens", "sensor_width", "sensor_height", "focus_distance", "blade_ratio",
        "pixel_aspect_x", "pixel_aspect_y",
    )  # fmt: skip
    for name in positive:
        value = getattr(camera, name)
        if not (np.isfinite(value) and value > 0):
            raise SceneError(f"camera: {name} is {value}, it must be above 0")
    others = ("shift_x", "shift_y", "lens_radius", "blade_rotation")
    for name in others:
        if not np.isfinite(getattr(camera, name)):
            raise SceneError(f"camera: {name} is {getattr(camera, name)}")
    if camera.lens_radius < 0:
        raise SceneError(f"camera: lens_radius is {camera.lens_radius}, it must be at least 0")
    if not np.isfinite(camera.matrix).all() or abs(np.linalg.det(camera.matrix[:3, :3])) == 0:
        raise SceneError("camera: its matrix is not invertible; check its scale")
