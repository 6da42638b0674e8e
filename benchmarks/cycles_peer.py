"""Cycles as an honest peer: unbiased settings, box filter, no denoising, no clamping."""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import bpy
from measure import Image, read_exr

#: Bounces of every kind; Russian roulette ends nearly all paths long before.
BOUNCES = 32


def open_scene(blend: Path, width: int, height: int, threads: int) -> bpy.types.Scene:
    """Open ``blend`` and set Cycles up on it so that its mean is right.

    Blender's defaults would soften caustics (``blur_glossy``), skip weak lamps
    (``light_sampling_threshold``), stop early where it looks smooth (adaptive sampling) and
    correlate neighbouring pixels (a wide filter).
    """
    with quiet():
        bpy.ops.wm.open_mainfile(filepath=str(blend.resolve()))
    scene: bpy.types.Scene = bpy.context.scene
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
    return scene


def render_image(
    scene: bpy.types.Scene, *, seed: int, samples: int, time_limit: float = 0.0
) -> tuple[Image, float]:
    """One render: the image (h, w, 3), row 0 at the top, and the seconds it took.

    The seconds are those of the whole operator: scene synchronisation (0.1 s in the samples),
    rendering, and writing the file. ``time_limit`` (0 = none) counts rendering only.
    """
    scene.cycles.seed = seed
    scene.cycles.samples = samples
    scene.cycles.time_limit = time_limit
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "image.exr"
        scene.render.filepath = str(path)
        started = time.perf_counter()
        with quiet():
            bpy.ops.render.render(write_still=True)
        seconds = time.perf_counter() - started
        return read_exr(path), seconds


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
