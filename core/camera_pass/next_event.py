"""Direct light of a chunk: which points of lights are asked for, and which of them are free."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..photons.shadow import ASK, LIT, ShadowMap, decide
from ..prepared import Prepared
from ..room import ROOM
from ..settings import Settings
from .direct import add_direct, sample_direct
from .kinds import KindLight, directions_to_lights
from .shadow import free_part

if TYPE_CHECKING:
    from .rays import Lit


def light_directly(
    prepared: Prepared,
    settings: Settings,
    lit: Lit,
    shadows: ShadowMap | None,
    samples: NDArray[np.void],
    kinds: KindLight | None,
) -> int:
    """Next-event estimation at the vertices; the number of shadow rays."""
    count = len(lit.vertices)
    if count == 0:
        return 0
    most = count * settings.lights_each
    origins = ROOM.take("origins", most, "f4", 3)
    directions = ROOM.take("directions", most, "f4", 3)
    lengths = ROOM.take("lengths", most, "f4")
    slots, asking, entries = (
        ROOM.take(name, most, "i4") for name in ("slots", "asking", "entries")
    )
    radiance = ROOM.take("radiance", most, "f8", 3)
    asked: int = sample_direct(
        settings.rays_each, settings.lights_each, prepared.guide, prepared.mesh,
        prepared.materials, lit.lobes, prepared.shading, prepared.lights, lit.vertices,
        count, origins, directions, lengths, slots, radiance, asking, entries,
    )  # fmt: skip
    rays = origins[:asked], directions[:asked], lengths[:asked]
    if shadows is None:
        free, traced = free_part(prepared, prepared.lobe_room(0), *rays)
    else:
        verdicts = np.zeros(asked, np.int32)
        decide(shadows, lit.vertices, asking, entries, directions, asked, verdicts)
        free = np.repeat((verdicts == LIT)[:, None].astype(np.float64), 3, axis=1)
        left = verdicts == ASK
        rest = (np.ascontiguousarray(column[left]) for column in rays)
        free[left], traced = free_part(prepared, prepared.lobe_room(0), *rest)
    add_direct(free, slots, radiance, asked, samples)
    if kinds:
        asking = asking[:asked]
        wi = directions_to_lights(lit, asking, *rays)
        kinds.add(lit, asking, wi, radiance[:asked] * free, False)
    return traced
