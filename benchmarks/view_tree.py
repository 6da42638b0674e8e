"""The tree of view rays against the choice by chance, at equal time.

    python benchmarks/view_tree.py [SCENE ...]

For each way: the variance of a render's pixels between seeds, relative to the mean of the
pixel and of the image, times the processor time of its passes. All ways have the same mean,
so this product tells which is nearer to the truth at equal time; below 1 the tree pays. The
ways take turns with each seed, so that other work of the machine falls on all alike. Each
render chooses its gather rays and photons itself, as usual. Prints the table of
docs/theory.md.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import speed_caustics as caustics
import speed_rooms as rooms
from numpy.typing import NDArray

from photon_map.core import Scene, Settings, render

SIZE = (96, 72)
PASSES, SEEDS = 8, 8
SCENES = {
    "glass box": rooms.glass_box,
    "corridor": rooms.corridor,
    "magnifier": caustics.magnifier,
    "hdri": caustics.hdri_glass,
    "pool": caustics.pool,
}
#: (events that may split, least weight); 0 events is chance.
WAYS = ((0, 0.1), (1, 0.1), (4, 0.1), (4, 0.02))


class Seen(NamedTuple):
    """A render: its pixels, processor time and rays of a pass."""

    image: NDArray[np.float64]
    seconds: float
    rays: float


def observe(scene: Scene, settings: Settings) -> Seen:
    """Render ``scene``, its preparation not timed."""
    begin = 0.0
    for last in render(scene, settings):
        if last.phase == "setup":
            begin = time.process_time()
    seconds = (time.process_time() - begin) / PASSES
    image = last.film.resolve("combined")[..., :3].astype(np.float64)
    return Seen(image, seconds, last.film.statistics.rays / PASSES)


def variance_of(seen: list[Seen], mean: NDArray[np.float64]) -> float:
    """Relative to ``mean``, that of all ways."""
    scale = (mean + 0.05 * mean.mean()) ** 2
    return float((np.var([one.image for one in seen], axis=0, ddof=1) / scale).mean())


def main() -> None:
    """All ways for each scene; time is that of one thread."""
    for name in sys.argv[1:] or SCENES:
        scene = SCENES[name]()
        assert scene.camera is not None
        camera = replace(scene.camera, width=SIZE[0], height=SIZE[1])
        scene = replace(scene, camera=camera)
        plain = Settings(passes=PASSES, threads=1)
        for depth in (0, 1):
            observe(scene, replace(plain, split_depth=depth))  # compiles
        found: dict[tuple[int, float], list[Seen]] = {way: [] for way in WAYS}
        for seed in range(SEEDS):
            for depth, least in WAYS:
                settings = replace(plain, seed=seed, split_depth=depth, split_least=least)
                found[depth, least].append(observe(scene, settings))
        mean = np.mean([one.image for way in WAYS for one in found[way]], axis=0)
        first = None
        for (depth, least), seen in found.items():
            variance = variance_of(seen, mean)
            seconds = float(np.median([one.seconds for one in seen]))
            first = first or (variance, seconds)
            print(
                f"{name} | {depth}, {least} | mean {np.mean([s.image for s in seen]):.4f} | "
                f"variance {variance / first[0]:.3f} | time {seconds / first[1]:.3f} | "
                f"product {variance * seconds / (first[0] * first[1]):.3f} | "
                f"{1e3 * seconds:.0f} ms, {np.mean([s.rays for s in seen]):.0f} rays",
                flush=True,
            )


if __name__ == "__main__":
    main()
