"""Photon Map from its core, as the benchmark runs it.

The kernels are loaded by a first render of one pass. The clock counts rendering and the
pilot pass, which is measured by itself; building the ray tracer is left out, as it is of
the peers.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from measure import Image

from photon_map.core import Scene, Settings, render
from photon_map.core.camera_pass.chunk import Region
from photon_map.core.photon_pass import TracedPhotons, photon_batches, pilot_radii
from photon_map.core.plan import Plan
from photon_map.core.prepared import prepare
from photon_map.core.version import ENGINE, VERSION

ENDLESS = 10_000_000


def version() -> str:
    """Name and version."""
    return f"{ENGINE} {VERSION}"


def settings(seed: int, threads: int, passes: int = ENDLESS) -> Settings:
    """The engine's own choices, but the box filter that all peers have."""
    return Settings(
        passes=passes, seed=seed, threads=threads, pixel_filter="BOX", filter_width=1.0
    )


def snapshots(
    scene: Scene, engine: str, times: Sequence[float], seed: int, threads: int, ready: Any
) -> Iterator[tuple[float, Image]]:
    """Seconds and image (h, w, 3), row 0 at the top, soon after each of ``times``."""
    for _ in render(scene, settings(seed, threads, passes=1)):
        pass
    ready()
    pilot = pilot_seconds(scene, settings(seed, threads))
    waiting, paused = list(times), 0.0
    updates = render(scene, settings(seed, threads))
    for update in updates:
        seconds = pilot + update.seconds - paused
        if update.passes and seconds >= waiting[0]:
            stopped = time.perf_counter()
            image = update.film.resolve("combined")[::-1, :, :3].astype(np.float64)
            while waiting and waiting[0] <= seconds:
                waiting.pop(0)
            yield seconds, image
            paused += time.perf_counter() - stopped
            if not waiting:
                updates.close()
                return


def pilot_seconds(scene: Scene, chosen: Settings) -> float:
    """What the pilot pass of a render takes."""
    assert scene.camera is not None
    prepared, region = prepare(scene, chosen), Region.of(scene.camera, chosen)
    batches = photon_batches(Plan.of(scene, chosen), chosen, region.width * region.height)
    begin = time.perf_counter()
    pilot_radii(prepared, chosen, region, TracedPhotons(prepared, chosen, batches))
    return time.perf_counter() - begin
