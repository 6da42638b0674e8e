"""Why an object casts no caustic: the causes that can be told without rendering."""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .bsdf.lobe import WIDE_FROM
from .geometry.intersector import Intersector
from .geometry.mesh import centre_of, centred_mesh
from .photons.casters import caster_strength, receiver_materials
from .scene.scene import Scene
from .scene.tables import ClosureKind, LightKind, Model, Visibility
from .settings import Settings

#: Places on the object, and on the emissive faces, between which rays are sent.
_PLACES = 64
_EMITTING_PLACES = 16
_SMOOTH_MODELS = (Model.CONDUCTOR, Model.DIELECTRIC, Model.REFRACTION)
_ROUGH_MODELS = (Model.GGX, Model.GGX_DIELECTRIC, Model.GGX_REFRACTION)
_ROUGH_KINDS = (
    ClosureKind.GLOSSY, ClosureKind.GLASS, ClosureKind.REFRACTION, ClosureKind.METALLIC
)  # fmt: skip


class Finding(NamedTuple):
    """One cause in a word or two, and what it means for this object."""

    cause: str
    words: str


def why_no_caustic(scene: Scene, settings: Settings, name: str) -> tuple[Finding, ...]:
    """What keeps object ``name`` from casting a caustic; nothing when no cause is seen.

    A caustic may then still be too faint, out of the picture or behind something.
    """
    objects = [k for k, other in enumerate(scene.object_names) if other == name]
    faces = np.flatnonzero(np.isin(scene.face_object, objects))
    if len(faces) == 0:
        return (Finding("not rendered", "it has no faces that are rendered"),)
    findings = [*_switches(scene, settings, objects)]
    strength = caster_strength(scene)
    rows = np.unique(scene.face_material[faces])
    if not (strength[rows] > 0).any():
        return (*findings, _no_caster(scene, rows))
    findings += _too_rough(scene, rows[strength[rows] > 0])
    casting = faces[strength[scene.face_material[faces]] > 0]
    findings += _flipped(scene, casting)
    findings += _too_short(scene, settings, casting)
    findings += _no_receiver(scene)
    findings += _in_the_dark(scene, strength, objects, casting)
    return tuple(findings)


def _switches(scene: Scene, settings: Settings, objects: list[int]) -> list[Finding]:
    findings = []
    if settings.photons_caustic == 0:
        words = "the scene sends no caustic photons: let their number be automatic, or above 0"
        findings.append(Finding("switched off", words))
    if (scene.object_visibility[objects] & Visibility.CASTS_NONE).any():
        findings.append(Finding("switched off", "Cast Caustics is off for this object"))
    return findings


def _too_rough(scene: Scene, rows: NDArray[np.int32]) -> list[Finding]:
    """Whether none of the casting materials is smooth enough for an edge of light."""
    most = WIDE_FROM**0.5
    found = [_roughness(scene, scene.materials[row]) for row in rows]
    if any(roughness is None or roughness < most for roughness in found):
        return []
    return [
        Finding(
            "roughness too high",
            f"material '{scene.material_names[rows[0]]}' has a roughness of {found[0]:.2g}, "
            f"which spreads light into a glow without edges: make it less than {most:.2g}",
        )
    ]


def _no_caster(scene: Scene, rows: NDArray[np.int32]) -> Finding:
    """Its materials neither mirror nor refract enough to cast anything."""
    return Finding(
        "no caster",
        f"material '{scene.material_names[rows[0]]}' neither reflects nor refracts: make it "
        "glass, a mirror or a metal",
    )


def _roughness(scene: Scene, material: np.void) -> float | None:
    """Blender's roughness of the smoothest lobe that mirrors or refracts; None without one."""
    start, count = material["lobe_start"], material["lobe_count"]
    lobes = scene.lobes[start : start + count]
    found = [
        float(lobe["roughness"]) ** 0.5 if lobe["model"] in _ROUGH_MODELS else 0.0
        for lobe in lobes
        if lobe["model"] in (*_ROUGH_MODELS, *_SMOOTH_MODELS) and lobe["weight"].max() > 0
    ]
    start, count = material["closure_start"], material["closure_count"]
    for closure in scene.closures[start : start + count]:
        layered = closure["kind"] == ClosureKind.PRINCIPLED and (
            closure["metallic"]["value"][0] > 0 or closure["transmission"]["value"][0] > 0
        )
        if closure["kind"] in _ROUGH_KINDS or layered:
            # A texture may say anything: nothing is known to be too rough.
            known = closure["roughness"]["texture"] < 0
            found.append(float(closure["roughness"]["value"][0]) if known else 0.0)
    return min(found, default=None)


def _flipped(scene: Scene, faces: NDArray[np.intp]) -> list[Finding]:
    """Whether a refracting body is inside out, by its signed volume."""
    glass = faces[scene.materials["ior"][scene.face_material[faces]] > 0]
    if len(glass) == 0:
        return []
    corners = scene.vertices[scene.faces[glass]]
    a, b, c = np.moveaxis(corners - corners.reshape(-1, 3).mean(axis=0), 1, 0)
    if (a * np.cross(b, c)).sum() >= 0:
        return []
    words = "its normals point inwards, so inside and outside are swapped: recalculate them"
    return [Finding("normals flipped", words)]


def _too_short(scene: Scene, settings: Settings, faces: NDArray[np.intp]) -> list[Finding]:
    refracts = bool((scene.materials["ior"][scene.face_material[faces]] > 0).any())
    needed = 3 if refracts else 2
    if settings.photon_depth >= needed:
        return []
    words = f"photons may meet {settings.photon_depth} surfaces, its caustic takes {needed}"
    return [Finding("depth too low", words)]


def _no_receiver(scene: Scene) -> list[Finding]:
    shows = (scene.object_visibility[scene.face_object] & Visibility.SHOWS_NONE) == 0
    wide = receiver_materials(scene)[scene.face_material]
    if (shows & wide).any():
        return []
    words = "there is nothing for it to fall on: no rough surface receives caustics"
    return [Finding("no receiver", words)]


def _in_the_dark(
    scene: Scene, strength: NDArray[np.float64], objects: list[int], faces: NDArray[np.intp]
) -> list[Finding]:
    """Whether no light reaches the object, and what stands in the way."""
    origins, directions, names = _rays_from_lights(scene, faces)
    if len(names) == 0:
        if _shines(scene):
            return [Finding("light blocked", "no lamp shines towards it")]
        return [Finding("no light", "nothing in the scene shines")]
    centre = centre_of(scene)
    hits = Intersector(centred_mesh(scene, centre)).nearest(
        np.ascontiguousarray(origins - centre.origin, np.float32),
        np.ascontiguousarray(directions, np.float32),
    )
    met = hits.face >= 0
    if not met.any():
        return []
    face = hits.face[met]
    row, hit_object = scene.face_material[face], scene.face_object[face]
    lets_through = (strength[row] > 0) | (scene.materials["passes"][row] != 0)
    lets_through |= (scene.object_visibility[hit_object] & Visibility.SHADOW) == 0
    if (np.isin(hit_object, objects) | lets_through).any():
        return []
    blocker, light = Counter(
        zip(hit_object.tolist(), np.array(names)[met].tolist(), strict=True)
    ).most_common(1)[0][0]
    words = f"no light reaches it: '{scene.object_names[blocker]}' is before {light}"
    return [Finding("light blocked", words)]


def _shines(scene: Scene) -> bool:
    used = np.unique(scene.face_material)
    glows = bool((scene.materials["emission"][used] > 0).any())
    return glows or bool((scene.lights["emission"] > 0).any()) or bool(scene.world.max() > 0)


def _rays_from_lights(
    scene: Scene, faces: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.float64], list[str]]:
    """Rays towards places on ``faces``: origins and directions (N, 3), each light's name.

    Lights leave out the places that they do not shine at.
    """
    chosen = faces[np.linspace(0, len(faces) - 1, min(_PLACES, len(faces))).astype(int)]
    places = scene.vertices[scene.faces[chosen]].mean(axis=1)
    far = 2.1 * centre_of(scene).radius
    starts: list[NDArray[np.float64]] = []
    ends: list[NDArray[np.float64]] = []
    names: list[str] = []
    for lamp, name in zip(scene.lights, scene.light_names, strict=True):
        if not lamp["emission"].max() > 0:
            continue
        along = -lamp["axis_z"]
        if lamp["kind"] == LightKind.SUN:
            origin, lit = places - far * along, np.ones(len(places), np.bool_)
        else:
            origin = np.broadcast_to(lamp["position"], places.shape)
            way = places - origin
            cosine = way @ along / np.maximum(np.linalg.norm(way, axis=1), 1e-30)
            lit = cosine > _least_cosine(lamp)
        starts, ends = [*starts, origin[lit]], [*ends, places[lit]]
        names += [f"'{name}'"] * int(lit.sum())
    emitting = np.flatnonzero((scene.materials["emission"] > 0).any(axis=1))
    glowing = np.flatnonzero(np.isin(scene.face_material, emitting))
    for face in glowing[:: max(1, len(glowing) // _EMITTING_PLACES)]:
        origin = np.broadcast_to(scene.vertices[scene.faces[face]].mean(axis=0), places.shape)
        starts, ends = [*starts, origin], [*ends, places]
        names += [f"'{scene.object_names[scene.face_object[face]]}'"] * len(places)
    if scene.world.max() > 0:
        ways = np.random.default_rng(1).normal(size=places.shape)
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        starts, ends = [*starts, places - far * ways], [*ends, places]
        names += ["the world"] * len(places)
    if not names:
        return np.zeros((0, 3)), np.zeros((0, 3)), []
    origins = np.concatenate(starts)
    directions = np.concatenate(ends) - origins
    # Off the face that shines, and off the ceiling that a lamp is set into.
    return origins + 1e-4 * directions, directions, names


def _least_cosine(lamp: np.void) -> float:
    """Cosine about the axis beyond which ``lamp`` sends nothing."""
    if lamp["kind"] == LightKind.SPOT:
        return float(lamp["cos_outer"]) if lamp["size_x"] == lamp["size_y"] == 1.0 else 0.0
    return 0.0 if lamp["kind"] in (LightKind.RECTANGLE, LightKind.DISK) else -2.0
