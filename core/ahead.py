"""The first render of all: camera kernels are compiled while photons wait for theirs."""

from __future__ import annotations

import numpy as np

from .camera_pass.chunk import trace_chunk
from .camera_pass.pixels import Pixels, Region
from .jit import has_compiled
from .photon_pass import Batch, photon_maps
from .photons.photon_map import build_photon_map
from .photons.trace import PHOTON, Walk
from .pilot import no_radii
from .plan import Plan
from .prepared import Prepared
from .settings import Settings

#: Pixels, at most.
_PIXELS = 64


def compile_ahead(prepared: Prepared, settings: Settings, plan: Plan, region: Region) -> None:
    """Compile what a camera pass of ``plan`` calls, by a few pixels and maps of no photons.

    For a thread that has nothing else to do yet: kernels become machine code side by side.
    Does nothing once there are kernels.
    """
    if has_compiled() or settings.shadow_photons:
        return
    walk = Walk(np.zeros(0, PHOTON), np.zeros(0, np.int64), 0)
    crowd = build_photon_map([walk], 1.0) if plan.is_on("caustics") else None
    radii = no_radii()._replace(caustic=(1.0, 1.0, 1.0, 1.0), global_=1.0, crowd=crowd)
    batches = [
        Batch(caustic, 0, 0, 1)
        for caustic, stage in ((True, "caustics"), (False, "indirect"))
        if plan.is_on(stage)
    ]
    maps = photon_maps(settings, radii, 0, batches, [walk] * len(batches))
    stride = max(1, region.width * region.height // _PIXELS)
    pixels = Pixels.spread(0, region.width * region.height // stride, stride=stride)
    trace_chunk(prepared, settings, region, pixels, maps)
