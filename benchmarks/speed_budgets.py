"""The budgets: start-up, compiling, threads, bare Embree, memory; each measured.

    python benchmarks/speed_budgets.py

writes `benchmarks/results/budgets.json`, of which `speed.py --docs docs` makes a table.
Every figure comes from a process of its own.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

#: Largest figures asked for.
SETUP, COLD, EMBREE, EFFICIENCY = 3.0, 30.0, 2.0, 0.9
#: Passes of one measurement.
PASSES = 24
#: Scenes that stand for diffuse light, glass, many rays and many triangles.
SCENES = ("diffuse_box", "glass_box", "pool", "corridor", "million")
SAMPLES = ("cornell_glass", "cornell_corridor", "glass_caustics")


def main() -> None:
    """Measure all, or in the child process one thing."""
    parser = argparse.ArgumentParser(description="Measure the budgets.")
    parser.add_argument("--out", type=Path, default=ROOT / "benchmarks/results/budgets.json")
    parser.add_argument("--child", nargs="+")
    args = parser.parse_args()
    if args.child:
        kind, *rest = args.child
        print(json.dumps(CHILDREN[kind](*rest)), flush=True)
        os._exit(0)
    found: dict[str, Any] = {"cores": len(os.sched_getaffinity(0)), "threads": {}, "setup": {}}
    with tempfile.TemporaryDirectory() as folder:
        found["cold"] = child("start", "glass_box", PHOTON_MAP_CACHE_DIR=folder)
        found["warm"] = child("start", "glass_box", PHOTON_MAP_CACHE_DIR=folder)
    found["million"] = child("start", "million")
    for name in SAMPLES:
        found["setup"][name] = sample(name)
    for name in SCENES:
        one, two = child("passes", name, "1"), child("passes", name, "2")
        found["threads"][name] = {"1": one, "2": two}
        print(name, one, two, file=sys.stderr, flush=True)
    found["load"] = os.getloadavg()[0]
    args.out.parent.mkdir(parents=True, exist_ok=True)
    args.out.write_text(json.dumps(found, indent=2) + "\n")
    print("\n".join(section(found)))


def child(*arguments: str, **environment: str) -> dict[str, Any]:
    """What one measurement in a fresh process says."""
    started = time.time()
    done = subprocess.run(
        [sys.executable, __file__, "--child", *arguments],
        capture_output=True, text=True, timeout=1200,
        env={**os.environ, **environment, "BENCH_STARTED": repr(started)},
    )  # fmt: skip
    if done.returncode:
        raise SystemExit(done.stderr)
    found: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return found


def start(scene: str) -> dict[str, Any]:
    """Seconds from the start of the process to the first pass, scene building left out."""
    from speed_cases import CASES
    from speed_worker import peak_megabytes

    began = time.perf_counter()
    built = CASES[scene].build()
    building = time.perf_counter() - began
    from speed_photonmap import settings

    from photon_map.core import render

    begin = time.perf_counter()
    for update in render(built, settings(0, len(os.sched_getaffinity(0)), passes=1)):
        setup = update.setup_seconds
    whole = time.time() - float(os.environ["BENCH_STARTED"]) - building
    return {
        "seconds": whole,
        "setup": setup,
        "render": time.perf_counter() - begin,
        "peak_mb": peak_megabytes(),
    }


def sample(name: str) -> dict[str, Any]:
    """Seconds before the first pass of a sample file, by the command line."""
    with tempfile.TemporaryDirectory() as folder:
        report, out = Path(folder) / "r.json", Path(folder) / "o.exr"
        command = [sys.executable, "-m", "photon_map.cli", "render"]
        command += [str(ROOT / "sample_blends" / f"{name}.blend"), "-o", str(out)]
        command += ["--passes", "1", "--size", "128x128", "--report", str(report)]
        # The first run compiles what this scene needs.
        for _ in range(2):
            began = time.perf_counter()
            subprocess.run(command, check=True, capture_output=True, timeout=1200)
            whole = time.perf_counter() - began
        facts = json.loads(report.read_text())
    return {"whole": whole, "setup": facts["setup_seconds"]}


def passes(scene: str, threads: str) -> dict[str, Any]:
    """Time of a pass, and of bare Embree for the very same rays on as many threads."""
    from speed_cases import CASES
    from speed_photonmap import settings

    from photon_map.core import render
    from photon_map.core.geometry.intersector import Intersector

    built, count = CASES[scene].build(), int(threads)
    deque(render(built, settings(1, count, passes=2)), maxlen=1)
    best = float("inf")
    for seed in (1, 2):
        last = deque(render(built, settings(seed, count, passes=PASSES)), maxlen=1)[0]
        best = min(best, last.seconds / PASSES)
    queries: list[Any] = []
    traced = recording(Intersector, queries)
    for update in render(built, settings(1, count, passes=4)):
        if update.passes == 0 and update.phase == "setup":
            queries.clear()
    for name, method in traced.items():
        setattr(Intersector, name, method)
    embree = min(replay(queries, count) for _ in range(3)) / 4
    rays = sum(len(query[2]) for query in queries) / 4
    return {"pass": best, "embree": embree, "rays": rays}


def recording(owner: type, queries: list[Any]) -> dict[str, Any]:
    """Have ``owner`` keep copies of all queries; its methods as they were."""
    kept = {name: getattr(owner, name) for name in ("nearest", "is_free")}

    def nearest(self: Any, origins: Any, directions: Any) -> Any:
        queries.append((self, "nearest", origins.copy(), directions.copy(), None))
        return kept["nearest"](self, origins, directions)

    def is_free(self: Any, origins: Any, directions: Any, lengths: Any) -> Any:
        queries.append((self, "is_free", origins.copy(), directions.copy(), lengths.copy()))
        return kept["is_free"](self, origins, directions, lengths)

    setattr(owner, "nearest", nearest)  # noqa: B010
    setattr(owner, "is_free", is_free)  # noqa: B010
    return kept


def replay(queries: list[Any], threads: int) -> float:
    """Seconds of the queries alone, in the same batches."""
    copies = [None if q[4] is None else q[4].copy() for q in queries]

    def one(k: int) -> None:
        own, kind, origins, directions, _ = queries[k]
        if kind == "nearest":
            own.nearest(origins, directions)
        else:
            own.is_free(origins, directions, copies[k])

    begin = time.perf_counter()
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(one, range(len(queries))))
    return time.perf_counter() - begin


CHILDREN = {"start": start, "passes": passes}


def section(found: dict[str, Any]) -> Iterator[str]:
    """The table for the docs."""
    yield "## Budgets"
    yield ""
    yield (
        "Measured by `benchmarks/speed_budgets.py`. Bare Embree: every ray of four passes was "
        "recorded and traced again alone, in the same batches on as many threads."
    )
    if found["load"] > 1.3 * found["cores"]:
        yield ""
        yield f"**Measured at a load of {found['load']:.1f}: to be repeated when it is quiet.**"
    yield ""
    yield "| budget | measured | asked | |"
    yield "|---|---|---|---|"
    warm, cold = found["warm"]["seconds"], found["cold"]["seconds"]
    limits = (("first start ever, compiling", cold, COLD), ("start, kernels kept", warm, SETUP))
    for text, seconds, limit in limits:
        kept = mark(seconds, limit)
        yield f"| {text}, to the first pass | {seconds:.1f} s | {limit:g} s | {kept} |"
    for name, which in (("glass box", "warm"), ("a million triangles", "million")):
        yield f"| peak memory, {name} | {found[which]['peak_mb']:.0f} MB | stated | |"
    large = found["million"]["setup"]
    yield f"| setup of a million triangles | {large:.1f} s | stated | |"
    for name, facts in found["setup"].items():
        setup = facts["setup"]
        yield (
            f"| setup of `{name}.blend` (with Blender's start {facts['whole']:.1f} s) | "
            f"{setup:.1f} s | {SETUP:g} s | {mark(setup, SETUP)} |"
        )
    yield ""
    yield (
        "| scene | pass, 1 thread | 2 threads | efficiency (asked 0.9) | rays a pass | "
        "bare Embree, 2 threads | pass / Embree (asked 2.0) | share in Embree |"
    )
    yield "|---|---|---|---|---|---|---|---|"
    for name, both in found["threads"].items():
        one, two = both["1"], both["2"]
        efficiency = one["pass"] / two["pass"] / 2
        ratio = two["pass"] / two["embree"]
        yield (
            f"| {name.replace('_', ' ')} | {1000 * one['pass']:.0f} ms | "
            f"{1000 * two['pass']:.0f} ms | {efficiency:.2f} "
            f"{'met' if efficiency >= EFFICIENCY else '**missed**'} | {two['rays']:,.0f} | "
            f"{1000 * two['embree']:.0f} ms | {ratio:.1f} {mark(ratio, EMBREE)} | "
            f"{100 / ratio:.0f} % |"
        )


def mark(value: float, limit: float) -> str:
    """Whether a budget is kept."""
    return "met" if value <= limit else "**missed**"


if __name__ == "__main__":
    main()
