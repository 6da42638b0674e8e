"""The tree of view rays against the choice by chance, at equal time.

    python benchmarks/view_tree.py [--figure] [SCENE ...]

For each way: the variance of a render's pixels between seeds, relative to the mean of the
pixel and of the image, times the processor time of its passes. All ways have the same mean,
so this product tells which is nearer to the truth at equal time; below 1 the tree pays. The
ways take turns with each seed, so that other work of the machine falls on all alike. Each
render chooses its gather rays and photons itself, as usual. Prints the table of
docs/theory.md; with --figure draws docs/pictures/view_tree.png.
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import speed_caustics as caustics  # noqa: E402
import speed_rooms as rooms  # noqa: E402

from photon_map.core import Scene, Settings, render  # noqa: E402

SIZE = (96, 72)
PASSES, SEEDS = 16, 8
SCENES = {
    "glass box": rooms.glass_box,
    "corridor": rooms.corridor,
    "magnifier": caustics.magnifier,
    "hdri": caustics.hdri_glass,
    "pool": caustics.pool,
}
#: (events that may split, least weight); 0 events is chance.
WAYS = ((0, 0.1), (1, 0.1), (2, 0.1))
#: The scene whose noise the figure shows.
SHOWN = "hdri"
PICTURE = ROOT / "docs" / "pictures" / "view_tree.png"


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


def deviation_of(seen: list[Seen], mean: NDArray[np.float64]) -> NDArray[np.float64]:
    """Variance (h, w) of each pixel over seeds, relative to ``mean``, that of all ways."""
    scale = (mean + 0.05 * mean.mean()) ** 2
    images = [one.image for one in seen]
    return np.asarray((np.var(images, axis=0, ddof=1) / scale).mean(axis=2))


def draw(
    products: dict[str, list[float]], variances: list[NDArray[np.float64]], path: Path
) -> None:
    """Products of all scenes as bars; where a pixel's noise is, by chance and split."""
    figure = Figure(figsize=(9.0, 2.7), layout="constrained")
    bars, *pictures = figure.subplots(1, 3, width_ratios=(1.3, 1.0, 1.0))
    for k, (depth, _) in enumerate(WAYS[1:], start=1):
        places = np.arange(len(products)) + 0.36 * (k - 1.5)
        heights = [row[k] for row in products.values()]
        bars.bar(places, heights, 0.34, label=f"{depth} event" + "s" * (depth > 1))
    bars.axhline(1.0, color="0.4", lw=0.8)
    bars.set_xticks(range(len(products)), list(products), fontsize=7)
    bars.set_ylabel("variance x time, chance = 1", fontsize=8)
    bars.legend(fontsize=6, loc="lower left")
    worst = float(np.sqrt(np.percentile(variances[0], 99)))
    names = (f"{SHOWN}: noise by chance", "split once")
    for axis, variance, name in zip(pictures, variances, names, strict=True):
        axis.imshow(np.sqrt(variance), origin="lower", cmap="magma", vmin=0.0, vmax=worst)
        axis.set_title(name, fontsize=8)
        axis.set(xticks=[], yticks=[])
    figure.savefig(path, dpi=100, metadata={"Software": None})


def main() -> None:
    """All ways for each scene; time is that of one thread."""
    parser = argparse.ArgumentParser(description="The tree of view rays against chance.")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=", ".join(SCENES))
    parser.add_argument("--figure", action="store_true", help="draw the docs' figure")
    given = parser.parse_args()
    products: dict[str, list[float]] = {}
    shown: list[NDArray[np.float64]] = []
    for name in given.scenes or SCENES:
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
        products[name] = []
        for (depth, least), seen in found.items():
            map_of = deviation_of(seen, mean)
            variance = float(map_of.mean())
            seconds = float(np.median([one.seconds for one in seen]))
            first = first or (variance, seconds)
            products[name].append(variance * seconds / (first[0] * first[1]))
            if name == SHOWN and depth < 2:
                shown.append(map_of)
            print(
                f"{name} | {depth}, {least} | mean {np.mean([s.image for s in seen]):.4f} | "
                f"variance {variance / first[0]:.3f} | time {seconds / first[1]:.3f} | "
                f"product {products[name][-1]:.3f} | "
                f"{1e3 * seconds:.0f} ms, {np.mean([s.rays for s in seen]):.0f} rays",
                flush=True,
            )
    if given.figure:
        draw(products, shown, PICTURE)


if __name__ == "__main__":
    main()
