"""Kernels of a camera pass, compiled or loaded while the pilot traces its first photons."""

from __future__ import annotations

import numpy as np

from .camera_pass.chunk import PhotonMaps, trace_chunk
from .camera_pass.pixels import Pixels, Region
from .jit import has_compiled
from .photon_pass import Batch, photon_maps
from .photons.photon_map import build_photon_map
from .photons.trace import PHOTON, Walk
from .pilot import no_radii
from .plan import Plan
from .prepared import Prepared
from .settings import Settings
from .warm_up import few_pixels

#: Pixels, at most.
_PIXELS = 64


def get_ready(prepared: Prepared, settings: Settings, plan: Plan, region: Region) -> bool:
    """Compile what a camera pass of ``plan`` calls, or load it once there are kernels.

    By a few pixels and maps of no photons, for a thread that has nothing else to do yet.
    Returns whether that is all: what was compiled leaves something for ``warm_up``.
    """
    if settings.shadow_photons:  # the maps are others then
        return False
    maps = _maps_of_none(settings, plan)
    if has_compiled():
        few_pixels(prepared, settings, plan, region, maps)
        return True
    stride = max(1, region.width * region.height // _PIXELS)
    pixels = Pixels.spread(0, region.width * region.height // stride, stride=stride)
    trace_chunk(prepared, settings, region, pixels, maps)
    return False


def _maps_of_none(settings: Settings, plan: Plan) -> PhotonMaps:
    walk = Walk(np.zeros(0, PHOTON), np.zeros(0, np.int64), 0)
    crowd = build_photon_map([walk], 1.0) if plan.is_on("caustics") else None
    radii = no_radii()._replace(caustic=(1.0, 1.0, 1.0, 1.0), global_=1.0, crowd=crowd)
    batches = [
        Batch(caustic, 0, 0, 1)
        for caustic, stage in ((True, "caustics"), (False, "indirect"))
        if plan.is_on(stage)
    ]
    return photon_maps(settings, radii, 0, batches, [walk] * len(batches))
