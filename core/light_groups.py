"""The light of groups of lights, each kept by itself beside the whole picture.

A group's light is rendered again with the others dark: nothing that is drawn at random hangs
on how bright a light is at the end of a path, so the same paths are followed, and the groups
make the picture to the last bit of their sums. It costs each group a camera pass and its own
photons, and renders without groups nothing at all; no kernel knows of it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .camera_pass.chunk import Chunk, PhotonMaps, trace_chunk
from .camera_pass.pixels import Pixels, Region
from .film.layers import LIGHT_LAYERS
from .prepared import Prepared
from .scene.scene import Scene
from .settings import LightGroup, Settings


class GroupChunk(NamedTuple):
    """A chunk, and light (n, G, 2, 3) of each group in all and as caustics."""

    whole: Chunk
    groups: NDArray[np.float64]


def lit_by(prepared: Prepared, scene: Scene, group: LightGroup) -> Prepared:
    """``prepared`` with every light dark that is not in ``group``; draws stay as they are."""
    lights = prepared.lights
    lamps = lights.lamps.copy()
    lamps["emission"][~np.isin(np.array(scene.light_names, object), group.lights)] = 0.0
    world = lights.world
    if not group.world:
        world = world._replace(radiance=np.zeros(3))
    count = len(prepared.materials)
    dark = prepared.materials.copy()
    dark["emission"] = 0.0
    # A face that shall not glow gets the dark twin of its material.
    apart = ~np.isin(np.array(scene.object_names, object), group.objects)
    mesh = prepared.mesh
    glows = prepared.materials["emission"].any(axis=1)[mesh.material] if count else False
    twin = glows & apart[prepared.face_object] if len(mesh.material) else False
    material = np.where(twin, mesh.material + count, mesh.material).astype(np.int32)
    return prepared._replace(
        mesh=mesh._replace(material=material),
        materials=np.concatenate([prepared.materials, dark]),
        glass=np.tile(prepared.glass, 2),
        lights=lights._replace(lamps=lamps, world=world),
        first_hits=None,
    )


def trace_groups(
    prepared: list[Prepared],
    settings: Settings,
    region: Region,
    pixels: Pixels,
    maps: list[PhotonMaps],
) -> GroupChunk:
    """``trace_chunk`` with all lights, the first of ``prepared`` and ``maps``, and apart."""
    whole = trace_chunk(prepared[0], settings, region, pixels, maps[0])
    groups = np.zeros((pixels.paths, len(prepared) - 1, 2, 3))
    quiet = replace(settings, light_kinds=False, first_hit=())
    rays = whole.rays
    for k in range(1, len(prepared)):
        part = trace_chunk(prepared[k], quiet, region, pixels, maps[k])
        rays += part.rays
        groups[:, k - 1, 0] = sum(part.samples[name] for name in LIGHT_LAYERS)
        groups[:, k - 1, 1] = part.samples["caustics"]
    numbers = whole.samples.view(np.float64).reshape(pixels.paths, -1)
    finite = np.isfinite(numbers).all(axis=1) & np.isfinite(groups).all(axis=(1, 2, 3))
    groups[~finite] = 0.0
    return GroupChunk(whole._replace(rays=rays), groups)
