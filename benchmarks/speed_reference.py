"""References of the benchmark's scenes: converged by an engine that is not ours.

    python benchmarks/speed_reference.py SCENE [--seconds 600] [--error 3e-4]

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


def digest(scene: Any) -> str:
    """Fingerprint of a scene's tables."""
    total = hashlib.sha256()
    for key in ("vertices", "faces", "corner_normals", "materials", "lobes", "lights"):
        array = getattr(scene, key)
        if array.dtype.names:
            for name in array.dtype.names:
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


def main() -> None:
    """Render until the error or the time is reached, and keep the mean."""
    args = arguments()
    from speed_cases import CASES

    case = CASES[args.scene]
    engine = args.engine or case.judge
    key = f"{digest(case.build())} {engine}"
    args.state.mkdir(parents=True, exist_ok=True)
    state = args.state / f"{case.name}_{engine}.npz"
    total: Any = 0.0
    squares: Any = 0.0
    chunks, spent, started = 0, 0.0, time.monotonic()
    if state.exists():
        with np.load(state) as kept:
            if str(kept["key"]) == key:
                total, squares = kept["total"], kept["squares"]
                chunks, spent = int(kept["chunks"]), float(kept["seconds"])
    while True:
        image, seconds, name = render_chunk(
            case.name, engine, args.chunk, 7000 + chunks, args.threads
        )
        if not np.isfinite(image).all():
            raise SystemExit(f"{engine} gave a pixel that is not finite")
        total, squares = total + image, squares + image**2
        chunks, spent = chunks + 1, spent + seconds
        np.savez(state, total=total, squares=squares, chunks=chunks, seconds=spent, key=key)
        if chunks < 2:
            continue
        mean = total / chunks
        variance = np.maximum(squares - total**2 / chunks, 0.0) / (chunks - 1) / chunks
        error = float(weighted_square(variance, mean).mean())
        facts = {
            "scene": case.name, "digest": key.split()[0], "engine": name, "mode": engine,
            "chunks": chunks, "seconds": round(spent, 1), "threads": args.threads,
            "rel_mse": error, "mean": [float(v) for v in mean.mean(axis=(0, 1))],
        }  # fmt: skip
        if args.engine is None:
            write_half(FOLDER / f"{case.name}.exr", mean)
            text = json.dumps(facts, indent=2) + "\n"
            (FOLDER / f"{case.name}.json").write_text(text)
        print(
            case.name, engine, chunks, f"relMSE {error:.2e} mean {mean.mean():.5f}", flush=True
        )
        if error <= args.error or time.monotonic() - started > args.seconds:
            break


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description="Converged reference of a benchmark scene.")
    parser.add_argument("scene")
    parser.add_argument("--engine", help="another engine, kept in the state only")
    parser.add_argument("--seconds", type=float, default=600.0, help="stop after this time")
    parser.add_argument("--chunk", type=float, default=30.0, help="seconds of one render")
    parser.add_argument("--error", type=float, default=3e-4, help="stop below this relMSE")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--state", type=Path, default=HERE.parent / ".cache" / "references")
    return parser.parse_args()


if __name__ == "__main__":
    main()
