"""Renders scenes of the suite with both engines; one process of Blender.

    python -m tests.parity.worker OUT_FOLDER NAME...     (with a bpy wheel)

Each scene becomes ``NAME.npz`` (see ``save``), complete or not at all: a caller that ends this
process at a time limit starts it again with the scenes that are missing.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from numba.core import event

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

from cycles_peer import BOUNCES, quiet, render_image, set_up  # noqa: E402

from tests.blender.conftest import load_package  # noqa: E402
from tests.parity.case import Case  # noqa: E402
from tests.parity.cases import CASES  # noqa: E402
from tests.parity.protocol import ENOUGH, PULSE, ROUNDS, SEEDS  # noqa: E402
from tests.parity.stage import Stage  # noqa: E402

Image = np.ndarray


class Pulse(event.Listener):
    """Touches a file whenever an image is done or Numba begins or ends to compile."""

    def __init__(self, file: Path) -> None:
        self.file = file

    def on_start(self, event: Any) -> None:
        self.file.touch()

    def on_end(self, event: Any) -> None:
        self.file.touch()


def rounds(render: Callable[[int], Image], pulse: Path) -> tuple[Image, float]:
    """Images (seeds, h, w, 3) of seeds 1, 2, 3 ..., and the seconds they took."""
    images: list[Image] = []
    started = time.perf_counter()
    for _ in range(ROUNDS):
        for _ in range(SEEDS):
            images.append(render(len(images) + 1))
            pulse.touch()
        means = np.stack(images).mean(axis=(1, 2))
        error = means.std(axis=0, ddof=1) / np.sqrt(len(means))
        if (error <= ENOUGH * means.mean()).all():
            break
    return np.stack(images), time.perf_counter() - started


def build(case: Case, folder: Path) -> None:
    """Fill Blender with the scene of ``case``."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    case.build(Stage(folder, case.size))


def render_ours(case: Case, pulse: Path) -> dict[str, Any]:
    """Photon Map, the scene exported once by the render operator."""
    from photon_map.addon import headless
    from photon_map.addon.job import Job
    from photon_map.core import Settings, render

    scene = bpy.context.scene
    scene.render.engine = "PHOTONMAP"
    job = Job(export_only=True)
    with quiet():
        headless._run(scene, job, png_path=None)
    photons: list[Image] = []
    warnings = list(job.warnings)

    def image(seed: int) -> Image:
        settings = Settings(
            passes=case.passes, seed=seed, pixel_filter="BOX", filter_width=1.0, threads=2,
            photons_global=case.photons, photons_caustic=case.photons,
            camera_depth=BOUNCES, photon_depth=BOUNCES,
        )  # fmt: skip
        *_, update = render(job.scene, settings)
        if seed == 1:
            warnings.extend(update.plan.warnings)
        film = update.film
        bad = film.statistics.non_finite
        if bad:
            raise ValueError(f"{bad} samples were not finite")
        photons.append(film.resolve("caustics")[..., :3] + film.resolve("indirect")[..., :3])
        return np.array(film.resolve("combined")[::-1, :, :3], np.float64)

    images, seconds = rounds(image, pulse)
    by_photons = np.mean(photons, axis=0)[::-1]
    return {
        "ours": images, "photons": by_photons, "ours_seconds": seconds, "warnings": warnings
    }  # fmt: skip


def render_cycles(case: Case, pulse: Path) -> dict[str, Any]:
    """Cycles in the same Blender."""
    scene = bpy.context.scene
    set_up(scene, *case.size, threads=2)
    images, seconds = rounds(
        lambda seed: render_image(scene, seed=seed, samples=case.samples)[0], pulse
    )
    return {"cycles": images, "cycles_seconds": seconds}


def save(case: Case, out: Path) -> None:
    """Render ``case`` and write its images, or the traceback, to ``out/NAME.npz``.

    ``ours`` and ``cycles`` (seeds, h, w, 3), first row at the top; ``photons`` (h, w, 3) the
    share of ours that photon maps gave; ``facts`` a JSON of seconds and warnings.
    """
    kept: dict[str, Any] = {"error": ""}
    try:
        with tempfile.TemporaryDirectory() as folder:
            build(case, Path(folder))
            kept.update(render_ours(case, out / PULSE))
            kept.update(render_cycles(case, out / PULSE))
    except Exception:
        kept["error"] = traceback.format_exc(limit=-4)
    arrays = {k: np.float32(v) for k, v in kept.items() if isinstance(v, np.ndarray)}
    facts = {k: v for k, v in kept.items() if not isinstance(v, np.ndarray)}
    facts["blender"] = bpy.app.version_string
    partial = out / f"{case.name}.part"
    with open(partial, "wb") as file:
        np.savez_compressed(file, facts=json.dumps(facts), **arrays)
    partial.replace(out / f"{case.name}.npz")


def main() -> None:
    """Render the scenes named on the command line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=Path)
    parser.add_argument("names", nargs="+", choices=list(CASES), metavar="NAME")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    event.register("numba:compile", Pulse(args.out / PULSE))
    load_package().register()
    for name in args.names:
        started = time.perf_counter()
        save(CASES[name], args.out)
        sys.stderr.write(f"{name} {time.perf_counter() - started:.1f} s\n")
    sys.stdout.flush()
    # Blender's own threads may keep the interpreter from ending.
    os._exit(0)


if __name__ == "__main__":
    main()
