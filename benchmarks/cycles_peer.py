"""Cycles as an honest peer: unbiased settings, box filter, no denoising, no clamping.

    python benchmarks/cycles_peer.py FILE.blend --size 128x128 --seconds 10 -o OUT.exr

renders for that time (counted by Cycles, scene synchronisation excluded) and prints a line
of json. Needs the ``bpy`` wheel and OpenEXR.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import bpy
import OpenEXR
from measure import Image, read_exr
from scene_digest import scene_digest

#: More samples than any time limit lets Cycles take.
ENDLESS = 1 << 24
#: Bounces of every kind; Russian roulette ends nearly all paths long before.
BOUNCES = 32


def open_scene(blend: Path, width: int, height: int, threads: int) -> bpy.types.Scene:
    """Open ``blend`` and set Cycles up on it (``set_up``)."""
    with quiet():
        bpy.ops.wm.open_mainfile(filepath=str(blend.resolve()))
    scene: bpy.types.Scene = bpy.context.scene
    set_up(scene, width, height, threads)
    return scene


def set_up(scene: bpy.types.Scene, width: int, height: int, threads: int) -> None:
    """Set Cycles up on ``scene`` so that its mean is right.

    Blender's defaults would soften caustics (``blur_glossy``), skip weak lamps
    (``light_sampling_threshold``), stop early where it looks smooth (adaptive sampling) and
    correlate neighbouring pixels (a wide filter).
    """
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = width, height
    render.resolution_percentage = 100
    render.use_border = False
    render.use_persistent_data = False
    render.threads_mode = "FIXED"
    render.threads = threads
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.image_settings.color_mode = "RGB"
    render.use_compositing = render.use_sequencer = False
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.pixel_filter_type = "BOX"
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.light_sampling_threshold = 0.0
    cycles.blur_glossy = 0.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", BOUNCES)
    cycles.transparent_max_bounces = BOUNCES


def render_image(scene: bpy.types.Scene, *, seed: int, samples: int) -> tuple[Image, float]:
    """One render of ``samples`` a pixel: the image (h, w, 3), row 0 at the top, and seconds.

    The seconds are those of ``write_image``.
    """
    scene.cycles.seed = seed
    scene.cycles.samples = samples
    scene.cycles.time_limit = 0.0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "image.exr"
        seconds = write_image(scene, path)
        return read_exr(path), seconds


def write_image(scene: bpy.types.Scene, path: Path) -> float:
    """Render to an EXR; the seconds of synchronising, rendering and writing together."""
    scene.render.filepath = str(path.resolve())
    started = time.perf_counter()
    with quiet():
        bpy.ops.render.render(write_still=True)
    return time.perf_counter() - started


def main() -> None:
    """Render one file for a given time."""
    parser = argparse.ArgumentParser(description="Render a .blend with Cycles for a time.")
    parser.add_argument("blend", type=Path)
    parser.add_argument("-o", "--out", type=Path, required=True)
    parser.add_argument("--size", default="128x128", help="WIDTHxHEIGHT")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=2)
    args = parser.parse_args()
    width, height = (int(side) for side in args.size.split("x"))
    scene = open_scene(args.blend, width, height, args.threads)
    scene.cycles.seed = args.seed
    scene.cycles.samples = ENDLESS
    scene.cycles.time_limit = args.seconds
    seconds = write_image(scene, args.out)
    report = {
        "engine": f"Cycles, bpy {bpy.app.version_string}",
        "seconds": rendering_seconds(args.out),
        "whole_seconds": seconds,
        "scene_digest": scene_digest(scene),
    }
    print(json.dumps(report))
    # Blender's own threads may keep the interpreter from ending.
    sys.stdout.flush()
    os._exit(0)


def rendering_seconds(path: Path) -> float:
    """Seconds of rendering alone, as Cycles wrote them into its EXR (as ``MM:SS.ss``)."""
    header = OpenEXR.File(str(path), header_only=True).header()
    key = next(key for key in header if key.endswith(".render_time"))
    seconds = 0.0
    for part in header[key].split(":"):
        seconds = 60.0 * seconds + float(part)
    return seconds


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Blender's own lines on standard output go nowhere."""
    kept = os.dup(1)
    with open(os.devnull, "wb") as sink:
        os.dup2(sink.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)


if __name__ == "__main__":
    main()
