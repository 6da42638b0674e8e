"""What baked photon maps save over a camera's flight, and what they do to the flicker.

    python benchmarks/baked_maps.py [--figure] [PHOTONS ...]

Renders 24 frames of a sliding orthographic camera over the glass box's floor, each frame one
pixel farther, so that every place of the floor is seen at a pixel's middle in every frame:
once with photons traced for each frame (a seed each, as for an animation) and once with one
bake for all. Prints the numbers of docs/baking.md; with --figure draws
docs/pictures/baked_maps.png of the fewer photons. With --middle all of a pixel's camera rays go
through its middle, so that nothing but the photons can flicker.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from figures import draw_flicker

from photon_map.core import Scene, Settings, bake, render
from photon_map.tests.scenes import cornell_glass, look_at

FRAMES = 24
SIZE = 96
#: Width of the picture [m]: what the frames share is seen in all of them.
WIDTH = 1.2
SETTINGS = Settings(passes=8, pixel_filter="BOX", filter_width=1.0)
#: Width of a filter that lets through the pixel's middle alone.
MIDDLE = 0.01


def frame_scene(scene: Scene, frame: int) -> Scene:
    """The floor from above, a pixel farther each frame."""
    step = WIDTH / SIZE
    eye = (-0.15 + frame * step, 0.0, 0.9)
    camera = replace(
        scene.camera, kind="ORTHOGRAPHIC", ortho_scale=WIDTH, width=SIZE, height=SIZE,
        matrix=look_at(eye, (eye[0], 0.0, -1.0), up=(0, 1, 0)),
    )  # type: ignore[type-var]  # fmt: skip
    return replace(scene, camera=camera)


def flight(scene: Scene, settings: list[Settings]) -> tuple[np.ndarray, str, int]:
    """Caustic layers (frames, h, w), place by place; their time in words; rays.

    NaN but for the bare floor. Balls are left out: the camera's own choice at glass, reflected
    or refracted, is noise too.
    """
    begin, used = time.perf_counter(), time.process_time()
    layers, bare, rays = [], [], 0
    for frame, chosen in enumerate(settings):
        *_, last = render(frame_scene(scene, frame), chosen)
        layer = last.film.resolve("caustics").mean(axis=2)
        shared = slice(FRAMES - frame, SIZE - frame)
        layers.append(layer[:, shared])
        bare.append(abs(last.film.resolve("depth")[:, shared, 0] - 1.9) < 1e-3)
        rays += last.film.statistics.rays
    words = (
        f"{time.perf_counter() - begin:.1f} s ({time.process_time() - used:.1f} of processors)"
    )
    return np.where(np.all(bare, axis=0), np.stack(layers), np.nan), words, rays


def flicker(layers: np.ndarray) -> float:
    """Root mean square over places of the deviation in time, over the layer's mean."""
    return float(np.sqrt(np.nanmean(layers.var(axis=0, ddof=1))) / np.nanmean(layers))


def main() -> None:
    """Both flights with few and with many photons."""
    parser = argparse.ArgumentParser(description="Baked maps against traced photons.")
    parser.add_argument("--figure", action="store_true", help="draw the docs' figure")
    parser.add_argument("--middle", action="store_true", help="rays by the pixels' middle")
    parser.add_argument("photons", nargs="*", type=int, default=[8192, 131072])
    given = parser.parse_args()
    settings = replace(SETTINGS, filter_width=MIDDLE) if given.middle else SETTINGS
    scene = cornell_glass(SIZE, smooth=True, subdivisions=3)
    *_, _ = render(frame_scene(scene, 0), replace(SETTINGS, passes=1))
    with tempfile.TemporaryDirectory() as folder:
        for photons in given.photons:
            base = replace(settings, photons_caustic=photons, photons_global=photons)
            traced, words, rays = flight(
                scene, [replace(base, seed=frame) for frame in range(FRAMES)]
            )
            print(
                f"{photons} photons a kind, traced: {words}, {rays / 1e6:.1f} Mrays, "
                f"flicker {100 * flicker(traced):.1f} %",
                flush=True,
            )
            path = Path(folder) / "box.pmap"
            begin, used = time.perf_counter(), time.process_time()
            bake(scene, base, path, SETTINGS.passes)
            baking, used = time.perf_counter() - begin, time.process_time() - used
            chosen = replace(base, photon_maps=str(path), stale_maps="REFUSE")
            layers, words, rays = flight(
                scene, [replace(chosen, seed=frame) for frame in range(FRAMES)]
            )
            print(
                f"{photons} photons a kind, baked: {baking:.1f} ({used:.1f}) + {words}, "
                f"{rays / 1e6:.1f} Mrays, {path.stat().st_size / 1e6:.1f} MB, "
                f"flicker {100 * flicker(layers):.1f} %",
                flush=True,
            )
            if given.figure and photons == 8192:
                deviations = (one.std(axis=0, ddof=1) for one in (traced, layers))
                draw_flicker(layers.mean(axis=0), *deviations)


if __name__ == "__main__":
    main()
