"""All lights of a scene as kernels see them, in centred coordinates.

Entries are numbered: the lamps, then the emissive faces as one, then the world.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.mesh import Centre, Mesh
from ..sampling.distributions import cumulative
from ..scene.scene import Scene
from ..scene.tables import LightKind
from .mesh import Emitters, emitters_of
from .selection import FEW
from .tree import LightTree, light_tree
from .world import World, world_of

#: Least share of the photons that a light with power gets, relative to an equal share.
LEAST_SHARE = 0.1


class LightSet(NamedTuple):
    """Lights of one render, N lamps and N + 2 entries.

    lamps (N,) ``tables.LIGHT`` centred; emitters: the emissive faces; world:
    the surroundings;
    radius: bounding radius of the scene; place (N+2, 3) and size (N+2,): about where and
    how large; strength (N+2,): mean irradiance at 1 m (distant ones: anywhere), 0 = off;
    distant (N+2,) bool; power (N+2,): mean emitted flux [W]; photon_cdf (N+2,);
    tree: the local lamps; choices: entries that are weighed one by one (``selection``);
    suns: lamps without a place whose shape rays can hit.
    """

    lamps: NDArray[np.void]
    emitters: Emitters
    world: World
    radius: float
    place: NDArray[np.float64]
    size: NDArray[np.float64]
    strength: NDArray[np.float64]
    distant: NDArray[np.bool_]
    power: NDArray[np.float64]
    photon_cdf: NDArray[np.float64]
    tree: LightTree
    choices: NDArray[np.int32]
    suns: NDArray[np.int32]


def light_set(scene: Scene, mesh: Mesh, centre: Centre) -> LightSet:
    """Collect and weigh the lights of ``scene``."""
    lamps = scene.lights.copy()
    lamps["position"] -= centre.origin
    emitters = emitters_of(mesh, scene.materials)
    count = len(lamps)
    place = np.zeros((count + 2, 3))
    size = np.zeros(count + 2)
    strength = np.zeros(count + 2)
    power = np.zeros(count + 2)
    distant = np.zeros(count + 2, np.bool_)
    disc = math.pi * centre.radius**2
    for k, lamp in enumerate(lamps):
        mean = float(lamp["emission"].mean())
        place[k] = lamp["position"]
        kind = lamp["kind"]
        if kind == LightKind.SUN:
            distant[k], strength[k], power[k] = True, mean, mean * disc
        elif kind in (LightKind.RECTANGLE, LightKind.DISK):
            area = float(lamp["size_x"] * lamp["size_y"])
            area *= math.pi / 4 if kind == LightKind.DISK else 1.0
            size[k] = 0.5 * max(lamp["size_x"], lamp["size_y"])
            strength[k], power[k] = mean * area, mean * area * math.pi
        else:
            size[k], strength[k] = lamp["radius"], mean
            part = 0.5 * (1 - lamp["cos_outer"]) if kind == LightKind.SPOT else 1.0
            if kind == LightKind.SPOT:
                part = min(1.0, part * lamp["size_x"] * lamp["size_y"])
            power[k] = mean * 4 * math.pi * part
    if len(emitters.faces):
        corners = mesh.vertices[mesh.faces[emitters.faces]].reshape(-1, 3)
        low, high = corners.min(axis=0), corners.max(axis=0)
        place[count] = (low + high) / 2
        size[count] = 0.5 * float(np.linalg.norm(high - low))
        strength[count], power[count] = emitters.power, 2 * math.pi * emitters.power
    world = world_of(scene)
    distant[count + 1] = True
    strength[count + 1] = world.mean * math.pi
    power[count + 1] = world.mean * 4 * math.pi * disc
    local = np.flatnonzero((lamps["kind"] != LightKind.SUN) & (strength[:count] > 0))
    tree = light_tree(lamps["position"], half_sizes(lamps), strength, local)
    discs = (lamps["kind"] == LightKind.SUN) & (lamps["angle"] > 0)
    suns = np.flatnonzero(discs).astype(np.int32)
    photon_cdf = photon_shares(power * photon_factors(scene))
    return LightSet(
        lamps, emitters, world, centre.radius, place, size, strength,
        distant, power, photon_cdf, tree, _choices(tree), suns,
    )  # fmt: skip


def half_sizes(lamps: NDArray[np.void]) -> NDArray[np.float64]:
    """Half the extents (N, 3) of boxes around the lamps' shapes, a little wider."""
    plates = np.isin(lamps["kind"], (LightKind.RECTANGLE, LightKind.DISK))
    across = np.abs(lamps["axis_x"]) * lamps["size_x"][:, None]
    across = 0.5 * (across + np.abs(lamps["axis_y"]) * lamps["size_y"][:, None])
    half = np.where(plates[:, None], across, lamps["radius"][:, None])
    reach = np.abs(lamps["position"]).max(axis=1, initial=0.0)[:, None]
    return half * (1 + 1e-6) + 1e-6 * (reach + half.max(axis=1, initial=0.0)[:, None])


def _choices(tree: LightTree) -> NDArray[np.int32]:
    """All entries, or of many lights those that are not in the ``tree``."""
    if len(tree.leaf) <= FEW:
        return np.arange(len(tree.leaf), dtype=np.int32)
    return np.flatnonzero(tree.leaf < 0).astype(np.int32)


def photon_factors(scene: Scene) -> NDArray[np.float64]:
    """What the numbers of photons of all entries (N+2,) are multiplied by."""
    return np.append(scene.light_photons, (1.0, 1.0))


def photon_shares(weight: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cumulative shares by ``weight`` (N,), each light above 0 with a minimum share."""
    on = weight > 0
    if not on.any():
        return np.zeros(len(weight))
    share = np.where(on, LEAST_SHARE / on.sum(), 0.0)
    return cumulative(share + (1 - LEAST_SHARE) * weight / weight.sum())
