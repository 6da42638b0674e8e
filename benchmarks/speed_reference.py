"""References of the benchmark's scenes: converged by an engine that is not ours.

    python benchmarks/speed_reference.py [SCENE ...] [--seconds 600] [--error 2e-4]

Renders of different seeds are summed in float64 with their squares: the variance between
them is the reference's own relMSE, which a json beside it tells. Sums stay in ``--state``
so that a later run goes on where this one stopped. The image is stored as float16.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from measure import Image, read_exr, rel_mse, weighted_square

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
FOLDER = HERE / "references" / "speed"


@dataclass(frozen=True)
class Reference:
    """A converged image (h, w, 3); ``noise``: its own relMSE; ``facts``: its json."""

    image: Image
    noise: float
    facts: dict[str, Any]

    def error(self, image: Image) -> float:
        """relMSE of an image. The reference's noise, which is independent, is taken off."""
        return rel_mse(image, self.image) - self.noise


def load(name: str) -> Reference:
    """The kept reference; ``SystemExit`` when there is none, or of another scene."""
    path = FOLDER / f"{name}.exr"
    if not path.exists():
        raise SystemExit(f"no reference of {name}: python {Path(__file__).name} {name}")
    facts = json.loads(path.with_suffix(".json").read_text())
    from speed_cases import CASES

    if facts["digest"] != digest(CASES[name].build()):
        raise SystemExit(f"the reference of {name} shows another scene; make a new one")
    return Reference(read_exr(path), float(facts["rel_mse"]), facts)


def that_show(names: Sequence[str]) -> list[str]:
    """Columns that the picture depends on: all but the number that a user gives a material."""
    return [name for name in names if name != "index"]


def digest(scene: Any) -> str:
    """Fingerprint of a scene's tables."""
    total = hashlib.sha256()
    for key in ("vertices", "faces", "corner_normals", "materials", "lobes", "lights"):
        array = getattr(scene, key)
        if array.dtype.names:
            for name in that_show(array.dtype.names):
                total.update(np.round(np.asarray(array[name], float), 6).tobytes())
        else:
            total.update(np.round(array, 6).tobytes())
    camera = scene.camera
    for value in (camera.matrix, camera.lens, camera.lens_radius, camera.focus_distance):
        total.update((np.round(np.asarray(value, float), 6) + 0.0).tobytes())
    total.update(np.round(scene.world, 6).tobytes() + scene.world_map.tobytes())
    for name in ("closures",):
        for field in ("kind", "ior"):
            total.update(np.asarray(getattr(scene, name)[field], float).tobytes())
    return total.hexdigest()[:16]


def write_half(path: Path, image: Image) -> None:
    """Write (h, w, 3) as float16: exact to 0.05 %, relMSE 1e-7."""
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    planes = {
        letter: np.ascontiguousarray(image[..., i], dtype=np.float16)
        for i, letter in enumerate("RGB")
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    OpenEXR.File(header, planes).write(str(path))


def render_chunk(scene: str, engine: str, seconds: float, seed: int, threads: int) -> Any:
    """One independent image of ``engine``, its seconds and the engine's name."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.npz"
        command = [sys.executable, str(HERE / "speed_worker.py"), scene, engine]
        command += ["--times", f"{seconds:g}", "--seed", str(seed)]
        command += ["--threads", str(threads), "-o", str(out)]
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=9 * seconds + 600
        )
        if not out.exists():
            raise SystemExit(f"{engine} failed on {scene}: {done.stderr[-2000:]}")
        with np.load(out) as kept:
            name = json.loads(str(kept["facts"]))["engine"]
            return kept["images"][-1].astype(np.float64), float(kept["seconds"][-1]), name


@dataclass
class Sums:
    """Sums of independent images of one scene by one engine, kept in a file."""

    path: Path
    key: str
    total: Image
    squares: Image
    chunks: int = 0
    seconds: float = 0.0

    @classmethod
    def open(cls, folder: Path, name: str, engine: str, key: str) -> Sums:
        """Those kept in ``folder``, or none yet."""
        folder.mkdir(parents=True, exist_ok=True)
        sums = cls(folder / f"{name}_{engine}.npz", key, np.zeros(1), np.zeros(1))
        if sums.path.exists():
            with np.load(sums.path) as kept:
                if str(kept["key"]) == key:
                    sums.total, sums.squares = kept["total"], kept["squares"]
                    sums.chunks, sums.seconds = int(kept["chunks"]), float(kept["seconds"])
        return sums

    def add(self, image: Image, seconds: float) -> None:
        """Count one more image and keep the sums."""
        self.total, self.squares = self.total + image, self.squares + image**2
        self.chunks, self.seconds = self.chunks + 1, self.seconds + seconds
        values = {k: v for k, v in vars(self).items() if k != "path"}
        np.savez(self.path, **values)

    @property
    def mean(self) -> Image:
        """The image so far."""
        return self.total / self.chunks

    @property
    def error(self) -> float:
        """relMSE of the mean, from the variance between the images."""
        if self.chunks < 2:
            return float("inf")
        spread = np.maximum(self.squares - self.total**2 / self.chunks, 0.0)
        variance = spread / (self.chunks - 1) / self.chunks
        return float(weighted_square(variance, self.mean).mean())


def improve(case: Any, args: argparse.Namespace) -> float:
    """Add one image to a reference and write it; its relMSE now."""
    engine = args.engine or case.judge
    fingerprint = digest(case.build())
    sums = Sums.open(args.state, case.name, engine, f"{fingerprint} {engine}")
    seed = 7000 + sums.chunks
    image, seconds, name = render_chunk(case.name, engine, args.chunk, seed, args.threads)
    if not np.isfinite(image).all():
        raise SystemExit(f"{engine} gave a pixel that is not finite")
    sums.add(image, seconds)
    mean, error = sums.mean, sums.error
    facts = {
        "scene": case.name, "digest": fingerprint, "engine": name, "mode": engine,
        "chunks": sums.chunks, "seconds": round(sums.seconds, 1), "threads": args.threads,
        "rel_mse": error, "mean": [float(v) for v in mean.mean(axis=(0, 1))],
    }  # fmt: skip
    if args.engine is None and sums.chunks >= 2:
        write_half(FOLDER / f"{case.name}.exr", mean)
        text = json.dumps(facts, indent=2) + "\n"
        (FOLDER / f"{case.name}.json").write_text(text)
    print(
        case.name, engine, sums.chunks, f"relMSE {error:.2e} mean {mean.mean():.5f}", flush=True
    )
    return error


def main() -> None:
    """Always improve the worst reference, until all are good or the time is over."""
    args = arguments()
    from speed_cases import CASES

    chosen = [CASES[name] for name in args.scenes or CASES]
    errors = {case.name: float("inf") for case in chosen}
    started = time.monotonic()
    while max(errors.values()) > args.error and time.monotonic() - started < args.seconds:
        case = max(chosen, key=lambda each: errors[each.name])
        errors[case.name] = improve(case, args)


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description="Converged references of the scenes.")
    parser.add_argument("scenes", nargs="*", help="all when none is named")
    parser.add_argument("--engine", help="another engine, kept in the state only")
    parser.add_argument("--seconds", type=float, default=600.0, help="stop after this time")
    parser.add_argument("--chunk", type=float, default=30.0, help="seconds of one render")
    parser.add_argument("--error", type=float, default=2e-4, help="good enough")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--state", type=Path, default=HERE.parent / ".cache" / "references")
    return parser.parse_args()


if __name__ == "__main__":
    main()
