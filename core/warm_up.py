"""A few pixels through every kernel before the clock starts: compiling is set-up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .camera_pass.chunk import PhotonMaps, trace_chunk
from .camera_pass.pixels import Pixels, Region
from .film.film import Film
from .guide_pass import learn_guide, wants_guide
from .photon_pass import PhotonSource, photon_maps, walk_and_connect
from .pilot import Radii
from .plan import Plan
from .prepared import Prepared
from .sampling.rng import REPLICATES
from .settings import Settings
from .steps import run

#: Pixels, at most, and photon paths of a batch.
_PIXELS, _PHOTONS = 256, 16
#: Pixels that learn a guide which nobody follows.
_LEARNING = 64


def empty_film(settings: Settings, width: int, height: int) -> Film:
    """A film with the layers that ``settings`` ask for."""
    return Film(
        width, height, settings.exposure, settings.first_hit, settings.matte_ranks,
        settings.light_kinds, tuple(group.name for group in settings.light_groups),
        settings.aovs,
    )  # fmt: skip


def warm_up(
    prepared: Prepared,
    settings: Settings,
    plan: Plan,
    region: Region,
    radii: Radii,
    source: PhotonSource,
) -> None:
    """Compile all that a pass of ``plan`` and its film call."""
    few = [replace(batch, count=min(batch.count, _PHOTONS)) for batch in source.batches]
    asked = (prepared, source, settings, radii)
    walks = [walk_and_connect(*asked, 0, batch) for batch in few]
    maps = photon_maps(settings, radii, 0, few, walks)
    if prepared.focus.found and maps.focus is None:
        maps = maps._replace(focus=maps.global_)
    few_pixels(prepared, settings, plan, region, maps)


def few_pixels(
    prepared: Prepared, settings: Settings, plan: Plan, region: Region, maps: PhotonMaps
) -> None:
    """All of a pass after the photons."""
    total = region.width * region.height
    stride = max(1, total // _PIXELS)
    pixels = Pixels.spread(0, total // stride, stride=stride)
    chunk = trace_chunk(prepared, settings, region, pixels, maps)
    if wants_guide(settings, plan, region):
        run(learn_guide(prepared, settings, region, maps, _LEARNING))
    film = empty_film(settings, pixels.paths, 1)
    ids = np.arange(pixels.paths, dtype=np.int32)
    for i in range(REPLICATES):
        film.add(i, ids, chunk.samples)
        film.add_asked(i, ids, chunk.first_hits, chunk.kinds, chunk.aovs)
        film.end_pass()
        film.stated_error()
    film.scatter_of_paths(0.0)
