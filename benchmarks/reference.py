"""A converged reference of a .blend, made with Cycles, that knows its own error.

    python benchmarks/reference.py sample_blends/cornell_glass.blend --size 128x128 \
        -o benchmarks/references/cornell_glass_128.exr

Chunks of different seeds are summed in float64 with their squares: the variance between
chunks is the reference's own relMSE. The image and a json beside it are written after every
chunk; ``--state`` keeps the sums, so that a later run goes on where this one stopped.
Needs the ``bpy`` wheel (5.0 was used) and OpenEXR.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from cycles_peer import open_scene, render_image
from measure import Image, weighted_square, write_exr
from scene_digest import scene_digest


@dataclass
class Sums:
    """Sums over chunks: of the pixels, and of their squares."""

    total: Image
    squares: Image
    chunks: int = 0
    seconds: float = 0.0

    def add(self, image: Image, seconds: float) -> None:
        """Count one more chunk (h, w, 3)."""
        self.total += image
        self.squares += image**2
        self.chunks += 1
        self.seconds += seconds

    @property
    def mean(self) -> Image:
        """The image so far."""
        return self.total / self.chunks

    def error_map(self) -> Image:
        """relMSE of the mean per pixel and channel, from the variance between chunks."""
        if self.chunks < 2:
            return np.full_like(self.total, np.inf)
        spread = self.squares - self.total**2 / self.chunks
        variance = np.maximum(spread, 0.0) / (self.chunks - 1) / self.chunks
        return weighted_square(variance, self.mean)

    def save(self, path: Path, key: str) -> None:
        """Keep the sums; ``key`` says what they are sums of."""
        with open(path.with_suffix(".part"), "wb") as file:
            np.savez(
                file,
                total=self.total,
                squares=self.squares,
                chunks=self.chunks,
                seconds=self.seconds,
                key=key,
            )
        path.with_suffix(".part").replace(path)

    @classmethod
    def load(cls, path: Path, key: str) -> Sums:
        """Sums kept by ``save``; ``ValueError`` when they are of another scene or size."""
        with np.load(path) as kept:
            if str(kept["key"]) != key:
                raise ValueError(f"{path} holds sums of {kept['key']}, not of {key}")
            return cls(
                kept["total"], kept["squares"], int(kept["chunks"]), float(kept["seconds"])
            )


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description="Converged Cycles reference of a .blend.")
    parser.add_argument("blend", type=Path)
    parser.add_argument("-o", "--out", type=Path, required=True, help="the .exr to write")
    parser.add_argument("--size", default="128x128", help="WIDTHxHEIGHT")
    parser.add_argument("--samples", type=int, default=512, help="samples a pixel and chunk")
    parser.add_argument("--error", type=float, default=3e-4, help="stop below this relMSE")
    parser.add_argument("--seconds", type=float, default=1800.0, help="stop after this time")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--state", type=Path, help=".npz with the sums, to go on later")
    return parser.parse_args()


def describe(sums: Sums, args: argparse.Namespace, digest: str, engine: str) -> dict[str, Any]:
    """What the json beside the image says."""
    error = sums.error_map()
    return {
        "scene": args.blend.name,
        "scene_digest": digest,
        "engine": engine,
        "filter": "box",
        "samples": sums.chunks * args.samples,
        "chunks": sums.chunks,
        "seconds": round(sums.seconds, 1),
        "threads": args.threads,
        "rel_mse": float(error.mean()),
        "rel_mse_median": float(np.median(error)),
        "rel_mse_largest": float(error.max()),
        "mean": [float(value) for value in sums.mean.mean(axis=(0, 1))],
    }


def main() -> None:
    """Render chunks until the error, or the time, is reached."""
    args = arguments()
    width, height = (int(side) for side in args.size.split("x"))
    scene = open_scene(args.blend, width, height, args.threads)
    digest = scene_digest(scene)
    key = f"{args.blend.name} {digest} {args.size} {args.samples}"
    shape = (height, width, 3)
    sums = Sums(np.zeros(shape), np.zeros(shape))
    if args.state is not None and args.state.exists():
        sums = Sums.load(args.state, key)
    engine = f"Cycles, bpy {bpy.app.version_string}"
    started = time.monotonic()
    while sums.chunks < 2 or (
        time.monotonic() - started < args.seconds
        and float(sums.error_map().mean()) > args.error
    ):
        # Seeds are counted, so that a continued run never repeats one.
        image, seconds = render_image(scene, seed=1000 + sums.chunks, samples=args.samples)
        if not np.isfinite(image).all():
            raise SystemExit("Cycles gave a pixel that is not finite")
        sums.add(image, seconds)
        if args.state is not None:
            sums.save(args.state, key)
        report = describe(sums, args, digest, engine)
        write_exr(args.out, sums.mean, {"source": engine})
        args.out.with_suffix(".json").write_text(json.dumps(report, indent=2) + "\n")
        print(
            f"chunk {sums.chunks}: {seconds:.1f} s, relMSE {report['rel_mse']:.2e}", flush=True
        )
    # Blender's own threads may keep the interpreter from ending.
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
