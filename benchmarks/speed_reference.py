"""References of the benchmark's scenes: converged by an engine that is not ours.

    python benchmarks/speed_reference.py [SCENE ...] [--seconds 600]

Renders of different seeds are summed in float64 in three independent parts, from which
`speed_error.py` knows the reference's own noise. Sums stay in ``--state`` so that a later
run goes on where this one stopped; without them it goes on from the stored reference, if one
engine judges all of it. The parts are stored as float16.
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
from measure import Image
from numpy.typing import NDArray
from speed_error import PARTS, Reference, noise_of

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
FOLDER = HERE / "references" / "speed"
#: relMSE that all references are brought to before one goes on to the next.
STEPS = (5e-3, 2e-3, 1e-3, 5e-4, 2e-4)


def load(name: str) -> Reference:
    """The kept reference; ``SystemExit`` when there is none, or of another scene."""
    path = FOLDER / f"{name}.exr"
    if not path.exists():
        raise SystemExit(f"no reference of {name}: python {Path(__file__).name} {name}")
    facts = json.loads(path.with_suffix(".json").read_text())
    from speed_cases import CASES

    if facts["digest"] != digest(CASES[name].build()):
        raise SystemExit(f"the reference of {name} shows another scene; make a new one")
    return Reference(read_parts(path), np.array(facts["work"]), facts)


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


def read_parts(path: Path) -> Image:
    """Parts (PARTS, h, w, 3) as ``write_parts`` left them."""
    import OpenEXR

    planes = OpenEXR.File(str(path), separate_channels=True).channels()
    return np.stack(
        [
            np.stack([planes[f"part{k}.{c}"].pixels for c in "RGB"], axis=-1)
            for k in range(PARTS)
        ]
    ).astype(np.float64)


def write_parts(path: Path, parts: Image) -> None:
    """Write (PARTS, h, w, 3) as float16: exact to 0.05 %, relMSE 1e-7."""
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    planes = {
        f"part{k}.{letter}": np.ascontiguousarray(part[..., i], dtype=np.float16)
        for k, part in enumerate(np.minimum(parts, np.finfo(np.float16).max))
        for i, letter in enumerate("RGB")
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    OpenEXR.File(header, planes).write(str(path))


def render_chunk(scene: str, engine: str, seconds: float, seed: int, threads: int) -> Any:
    """One independent image of ``engine``, and what its process tells."""
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
            facts = json.loads(str(kept["facts"]))
            return kept["images"][-1].astype(np.float64), facts


@dataclass
class Sums:
    """Sums of independent images of one scene by one engine, kept in a file.

    ``total`` (PARTS, h, w, 3): images times their work; ``work`` (PARTS,): seconds of the
    processor, so that an image of a busy minute does not weigh like one of a quiet minute.
    """

    path: Path
    key: str
    total: Image
    work: NDArray[np.float64]
    chunks: int = 0
    version: str = ""

    @classmethod
    def open(cls, folder: Path, name: str, engine: str, key: str) -> Sums:
        """Those kept in ``folder``, or none yet."""
        folder.mkdir(parents=True, exist_ok=True)
        nothing = np.zeros((PARTS, 1, 1, 1))
        sums = cls(folder / f"{name}_{engine}.npz", key, nothing, np.zeros(PARTS))
        if sums.path.exists():
            with np.load(sums.path) as kept:
                if str(kept["key"]) == key and "work" in kept:
                    sums.total, sums.work = kept["total"], kept["work"]
                    sums.chunks = int(kept["chunks"])
                    sums.version = str(kept["version"]) if "version" in kept else ""
        return sums

    def take_stored(self, name: str, fingerprint: str, engine: str) -> None:
        """Begin with the reference of ``name`` if ``engine`` alone has made all of it."""
        path = FOLDER / f"{name}.exr"
        if not path.exists():
            return
        facts = json.loads(path.with_suffix(".json").read_text())
        judges = facts["judges"]
        if facts["digest"] != fingerprint or list(judges) != [engine]:
            return
        self.work = np.array(facts["work"])
        self.total = read_parts(path) * self.work[:, None, None, None]
        self.chunks = judges[engine]["chunks"]
        self.version = judges[engine]["engine"]

    def add(self, image: Image, work: float, version: str = "") -> None:
        """Count one more image, by ``version`` of the engine, in the part that has least, and
        keep the sums."""
        part = int(np.argmin(self.work))
        more = np.zeros((PARTS, *image.shape))
        more[part] = image * work
        self.total = self.total + more
        self.work[part] += work
        self.chunks += 1
        self.version = version
        values = {k: v for k, v in vars(self).items() if k != "path"}
        partial = self.path.with_suffix(".part.npz")
        np.savez(partial, **values)
        partial.replace(self.path)

    @property
    def parts(self) -> Image:
        """The independent images so far."""
        mean: Image = self.total / self.work[:, None, None, None]
        return mean

    @property
    def error(self) -> float:
        """relMSE of all parts together."""
        return noise_of(self.parts, self.work) if self.work.all() else float("inf")


@dataclass
class Making:
    """A reference in the making: the sums of each of its engines, and where each counts.

    ``where`` (h, w) of an engine: the pixels that it judges.
    """

    case: Any
    fingerprint: str
    sums: dict[str, Sums]
    where: dict[str, NDArray[np.bool_]]

    @classmethod
    def open(cls, case: Any, args: argparse.Namespace) -> Making:
        """What is kept of it."""
        scene = case.build()
        fingerprint = digest(scene)
        engines = (args.engine,) if args.engine else case.judges
        sums = {e: Sums.open(args.state, case.name, e, f"{fingerprint} {e}") for e in engines}
        if args.engine is None and not sums[engines[0]].chunks:
            sums[engines[0]].take_stored(case.name, fingerprint, engines[0])
        assert scene.camera is not None
        everywhere = np.ones((scene.camera.height, scene.camera.width), np.bool_)
        if len(engines) == 1:
            return cls(case, fingerprint, sums, {engines[0]: everywhere})
        from speed_first_hits import diffuse_pixels
        from speed_parts import parts_of

        diffuse = diffuse_pixels(parts_of(scene))
        return cls(
            case, fingerprint, sums, dict(zip(engines, (~diffuse, diffuse), strict=True))
        )

    @property
    def is_whole(self) -> bool:
        """Whether every engine has given all its parts."""
        return all(s.work.all() for s in self.sums.values())

    @property
    def parts(self) -> Image:
        """The parts (PARTS, h, w, 3), each pixel of the engine that judges it."""
        return np.sum(
            [s.parts * self.where[e][..., None] for e, s in self.sums.items()], axis=0
        )

    @property
    def work(self) -> NDArray[np.float64]:
        """Seconds (PARTS,) of the processor; between the parts as in the engines' mean."""
        works = [s.work for s in self.sums.values()]
        shares = np.mean([work / work.sum() for work in works], axis=0)
        whole: NDArray[np.float64] = shares * np.sum(works)
        return whole

    def errors(self) -> dict[str, float]:
        """What each engine adds to relMSE; inf before all have given all parts."""
        if not self.is_whole:
            return {e: 0.0 if s.work.all() else float("inf") for e, s in self.sums.items()}
        parts, work = self.parts, self.work
        mean = np.tensordot(work / work.sum(), parts, axes=1)
        return {
            e: noise_of(np.where(self.where[e][..., None], parts, mean), s.work)
            for e, s in self.sums.items()
        }

    @property
    def error(self) -> float:
        """relMSE of all parts together."""
        return sum(self.errors().values())

    @property
    def next_engine(self) -> str:
        """The one whose next second takes most off the error."""
        errors = self.errors()
        return max(errors, key=lambda e: errors[e] / max(self.sums[e].work.sum(), 1e-9))


def improve(making: Making, args: argparse.Namespace) -> None:
    """Add one image to a reference and write it."""
    case, engine = making.case, making.next_engine
    sums = making.sums[engine]
    seed = 7000 + sums.chunks
    image, told = render_chunk(case.name, engine, args.chunk, seed, args.threads)
    if not np.isfinite(image).all():
        raise SystemExit(f"{engine} gave a pixel that is not finite")
    sums.add(image, told["work"], told["engine"])
    error = making.error
    if args.engine is None and making.is_whole:
        parts, work = making.parts, making.work
        facts = {
            "scene": case.name, "digest": making.fingerprint,
            "judges": {
                e: {
                    "engine": s.version, "chunks": s.chunks, "work": float(s.work.sum()),
                    "pixels": float(making.where[e].mean()), "rel_mse": making.errors()[e],
                }
                for e, s in making.sums.items()
            },
            "work": [round(w, 1) for w in work], "rel_mse": error,
            "mean": [float(v) for v in parts.mean(axis=(0, 1, 2))],
        }  # fmt: skip
        write_parts(FOLDER / f"{case.name}.exr", parts)
        text = json.dumps(facts, indent=2) + "\n"
        (FOLDER / f"{case.name}.json").write_text(text)
    print(
        time.strftime("%H:%M"), case.name, engine, sums.chunks, f"work {told['work']:.1f}",
        f"relMSE {error:.2e} mean {image.mean():.5f}", flush=True,
    )  # fmt: skip


def next_one(makings: Sequence[Making]) -> Making | None:
    """Whose turn it is: of those above the first step that not all have reached, the one
    that has least far to go; None when all have reached the last."""
    for step in STEPS:
        left: list[tuple[float, Making]] = []
        for making in makings:
            error = making.error
            work = sum(float(s.work.sum()) for s in making.sums.values())
            if error > step:
                left.append(
                    (work * (error / step - 1.0) if np.isfinite(error) else work, making)
                )
        if left:
            return min(left, key=lambda pair: pair[0])[1]
    return None


def main() -> None:
    """Improve the references step by step, until all are good or the time is over."""
    args = arguments()
    from speed_cases import CASES

    chosen = [CASES[name] for name in args.scenes or CASES]
    started = time.monotonic()
    while time.monotonic() - started < args.seconds:
        making = next_one([Making.open(case, args) for case in chosen])
        if making is None:
            return
        improve(making, args)


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description="Converged references of the scenes.")
    parser.add_argument("scenes", nargs="*", help="all when none is named")
    parser.add_argument("--engine", help="another engine, kept in the state only")
    parser.add_argument("--seconds", type=float, default=600.0, help="stop after this time")
    parser.add_argument("--chunk", type=float, default=30.0, help="seconds of one render")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--state", type=Path, default=HERE.parent / ".cache" / "references")
    return parser.parse_args()


if __name__ == "__main__":
    main()
