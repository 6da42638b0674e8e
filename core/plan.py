"""What this scene needs, decided before the first ray, with a reason for each stage."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .photons.casters import caster_strength, receiver_materials
from .scene.scene import Scene
from .scene.tables import LightKind, Visibility
from .settings import Settings


class Stage(NamedTuple):
    """One stage of a render: on or off, and why."""

    name: str
    on: bool
    reason: str


class Plan(NamedTuple):
    """The stages of a render, in order, and what the user should know."""

    stages: tuple[Stage, ...]
    warnings: tuple[str, ...] = ()

    def is_on(self, name: str) -> bool:
        """Whether stage ``name`` runs."""
        return any(stage.name == name and stage.on for stage in self.stages)

    @staticmethod
    def of(scene: Scene, settings: Settings) -> Plan:
        """Look at ``scene`` and decide."""
        facts = _Facts(scene)
        stages = (
            _emission(scene, facts),
            _direct(facts),
            _shadow_photons(facts, settings),
            _caustics(scene, facts, settings),
            _indirect(facts, settings),
            _media(facts),
            _lens(scene),
        )
        return Plan(stages, facts.warnings)


class _Facts:
    """What the decisions rest on."""

    def __init__(self, scene: Scene) -> None:
        used = np.zeros(len(scene.materials), np.bool_)
        used[scene.face_material] = True
        shining = (scene.materials["emission"].max(axis=1) > 0) & used
        self.emissive_faces = int(np.isin(scene.face_material, np.flatnonzero(shining)).sum())
        self.lamps = int((scene.lights["emission"].max(axis=1) > 0).sum())
        rows, columns = scene.world_map.shape[:2]
        shines = scene.world.max() > 0 and (rows == 0 or scene.world_map.max() > 0)
        self.world = bool(shines)
        self.sky = f"the world, a map of {columns}x{rows}" if rows else "the world"
        self.lights = self.lamps + bool(self.emissive_faces) + self.world
        self.faces = len(scene.faces)
        casts = (caster_strength(scene) > 0) & used
        casting = np.isin(scene.face_material, np.flatnonzero(casts))
        found = np.unique(scene.face_object[casting])
        off = scene.object_visibility[found] & Visibility.CASTS_NONE != 0
        self.casters = [scene.object_names[k] for k in found[~off]]
        self.casters_off = int(off.sum())
        self.media = int(((scene.materials["ior"] > 0) & used).sum())
        self.receives = bool((receiver_materials(scene) & used).any())
        warnings = []
        if self.faces == 0:
            warnings.append(f"scene '{scene.name}' has no faces: only the background is seen")
        if self.lights == 0:
            warnings.append(
                f"scene '{scene.name}' has no light: the picture is black; add a lamp, an "
                "emissive material or a world colour"
            )
        self.warnings = tuple(warnings)


def _emission(scene: Scene, facts: _Facts) -> Stage:
    parts = []
    if facts.emissive_faces:
        parts.append(f"{facts.emissive_faces} emissive faces")
    if facts.world:
        parts.append(facts.sky)
    plates = np.isin(scene.lights["kind"], (LightKind.RECTANGLE, LightKind.DISK))
    shaped = int(((scene.lights["radius"] > 0) | plates).sum())
    if shaped:
        parts.append(f"{shaped} lamps with a shape")
    if not parts:
        return Stage("emission", False, "nothing that shines can be seen")
    return Stage("emission", True, ", ".join(parts))


def _direct(facts: _Facts) -> Stage:
    if facts.lights == 0:
        return Stage("direct", False, "no light")
    if not facts.receives:
        return Stage("direct", False, "no surface scatters widely")
    parts = [f"{facts.lamps} lamps"] if facts.lamps else []
    parts += [f"{facts.emissive_faces} emissive faces"] if facts.emissive_faces else []
    parts += [facts.sky] if facts.world else []
    return Stage("direct", True, "light from " + ", ".join(parts))


def _shadow_photons(facts: _Facts, settings: Settings) -> Stage:
    """Never by itself: docs/shadow_photons.md has what both cost."""
    if not settings.shadow_photons:
        reason = "a shadow ray costs a fifteenth of a look at shadow photons"
        return Stage("shadow photons", False, reason)
    if not facts.lamps or not facts.receives:
        return Stage("shadow photons", False, "no lamp whose shadow rays could be spared")
    reason = f"{settings.shadow_photons} paths from {facts.lamps} lamps, as asked for"
    return Stage("shadow photons", True, reason)


def _caustics(scene: Scene, facts: _Facts, settings: Settings) -> Stage:
    if facts.lights == 0:
        return Stage("caustics", False, "no light")
    if not facts.casters:
        reason = "no surface reflects or refracts sharply"
        if facts.casters_off:
            reason = f"casting is switched off for all {facts.casters_off} casters"
        return Stage("caustics", False, reason)
    if not facts.receives:
        return Stage("caustics", False, "no surface for a caustic to fall on")
    if settings.photons_caustic == 0:
        return Stage("caustics", False, "photons_caustic is 0")
    names = ", ".join(facts.casters[:4]) + (", ..." if len(facts.casters) > 4 else "")
    return Stage("caustics", True, f"{len(facts.casters)} casters ({names})")


def _indirect(facts: _Facts, settings: Settings) -> Stage:
    if facts.lights == 0:
        return Stage("indirect", False, "no light")
    if not facts.receives:
        return Stage("indirect", False, "no surface scatters widely")
    if settings.photons_global == 0:
        return Stage("indirect", False, "photons_global is 0")
    return Stage("indirect", True, "light between surfaces that scatter widely")


def _media(facts: _Facts) -> Stage:
    if not facts.media:
        return Stage("media", False, "nothing refracts")
    return Stage("media", True, f"{facts.media} refracting materials")


def _lens(scene: Scene) -> Stage:
    camera = scene.camera
    if camera is None:
        return Stage("lens", False, "no camera")
    if camera.lens_radius <= 0:
        return Stage("lens", False, "depth of field is off")
    return Stage(
        "lens", True,
        f"aperture radius {camera.lens_radius * 1000:.3g} mm, "
        f"focus at {camera.focus_distance:.4g} m",
    )  # fmt: skip
