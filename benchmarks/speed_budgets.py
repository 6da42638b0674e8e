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
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

#: Largest figures asked for.
SETUP, COLD, EMBREE, EFFICIENCY = 3.0, 30.0, 2.0, 0.9
#: Most memory that ten million triangles may take [MB], and quads along a side of them.
MOST_MEMORY, TEN_MILLION = 16_000, 2236
#: Passes of one measurement.
PASSES = 24
#: Scenes that stand for diffuse light, glass, many rays and many triangles.
SCENES = ("diffuse_box", "glass_box", "pool", "corridor", "million")
SAMPLES = ("cornell_glass", "cornell_corridor", "glass_caustics")


def main() -> None:
    """Measure all, or in the child process one thing."""
    parser = argparse.ArgumentParser(description="Measure the budgets.")
    parser.add_argument("--out", type=Path, default=ROOT / "benchmarks/results/budgets.json")
    parser.add_argument("--go-on", action="store_true", help="measure only what is missing")
    parser.add_argument("--child", nargs="+")
    args = parser.parse_args()
    if args.child:
        kind, *rest = args.child
        print(json.dumps(CHILDREN[kind](*rest)), flush=True)
        os._exit(0)
    found: dict[str, Any] = {"cores": len(os.sched_getaffinity(0)), "threads": {}, "setup": {}}
    if args.go_on and args.out.exists():
        found |= json.loads(args.out.read_text())
    found["load"] = os.getloadavg()[0]
    args.out.parent.mkdir(parents=True, exist_ok=True)
    for group, name, measure in measurements():
        place = found[group] if group else found
        if name not in place:
            place[name] = measure()
            print(group, name, place[name], file=sys.stderr, flush=True)
            args.out.write_text(json.dumps(found, indent=2) + "\n")
    print("\n".join(section(found)))


def measurements() -> Iterator[tuple[str, str, Callable[[], Any]]]:
    """All that is measured: where it is kept, its name, and how."""
    for name in SCENES:
        yield "threads", name, partial(both_threads, name)
    for name in SAMPLES:
        yield "setup", name, partial(sample, name)
    yield "", "million", partial(child, "start", "million")
    yield "", "ten_million", partial(child, "start", "ten_million")
    yield "", "warm", partial(child, "start", "glass_box")
    yield "", "cold", cold


def both_threads(name: str) -> dict[str, Any]:
    """Passes on one thread and on two."""
    return {threads: child("passes", name, threads) for threads in ("1", "2")}


def cold() -> dict[str, Any]:
    """The first start ever: no kernel is kept yet."""
    with tempfile.TemporaryDirectory() as folder:
        return child("start", "glass_box", PHOTON_MAP_CACHE_DIR=folder)


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
    if scene == "ten_million":
        from speed_caustics import million

        built = million(TEN_MILLION)
    else:
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
    best, work = float("inf"), float("inf")
    for seed in (1, 2):
        # From the first update with a pass on: before it lies the look for the balance.
        first, spent = None, 0.0
        for last in render(built, settings(seed, count, passes=PASSES)):
            if first is None and last.passes:
                first, spent = last, time.process_time()
        assert first is not None
        done = max(1, last.passes - first.passes)
        best = min(best, (last.seconds - first.seconds) / done)
        work = min(work, (time.process_time() - spent) / done)
    queries: list[Any] = []
    traced = recording(Intersector, queries)
    for update in render(built, settings(1, count, passes=4)):
        if update.passes == 0 and update.phase == "setup":
            queries.clear()
    for name, method in traced.items():
        setattr(Intersector, name, method)
    # Some of the recorded rays belong to the look before the first pass.
    rays = update.film.statistics.rays / 4
    share = rays / max(1, sum(len(query[2]) for query in queries))
    embree, bare = (
        share * min(both)
        for both in zip(*(replay(queries, count) for _ in range(3)), strict=True)
    )
    return {
        "pass": best, "pass_cpu": work, "embree": embree, "embree_cpu": bare, "rays": rays
    }  # fmt: skip


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


def replay(queries: list[Any], threads: int) -> tuple[float, float]:
    """Seconds, and those of the processor, of the queries alone, in the same batches."""
    copies = [None if q[4] is None else q[4].copy() for q in queries]

    def one(k: int) -> None:
        own, kind, origins, directions, _ = queries[k]
        # Embree itself: the render that asked is over, and its own methods say so.
        if kind == "nearest":
            own._scene.run(origins, directions, query="INTERSECT", output=1)
        else:
            own._scene.run(origins, directions, copies[k], query="OCCLUDED")

    begin, work = time.perf_counter(), time.process_time()
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(one, range(len(queries))))
    return time.perf_counter() - begin, time.process_time() - work


CHILDREN = {"start": start, "passes": passes}


def section(found: dict[str, Any]) -> Iterator[str]:
    """The table for the docs."""
    yield "## Budgets"
    yield ""
    yield (
        "Measured by `benchmarks/speed_budgets.py`. Bare Embree: every ray of four passes was "
        "recorded and traced again alone, in the same batches. Both are seconds of the "
        "processor over all threads, which other programs on the machine hardly change."
    )
    if found["load"] > 1.3 * found["cores"]:
        yield ""
        yield f"**Measured at a load of {found['load']:.1f}: to be repeated when it is quiet.**"
    yield ""
    yield "| budget | measured | asked | |"
    yield "|---|---|---|---|"
    starts = (
        ("cold", "first start ever, compiling", COLD), ("warm", "start, kernels kept", SETUP)
    )  # fmt: skip
    for which, text, limit in starts:
        if which in found:
            seconds = found[which]["seconds"]
            kept = mark(seconds, limit)
            yield f"| {text}, to the first pass | {seconds:.1f} s | {limit:g} s | {kept} |"
    for name, which in (("glass box", "warm"), ("a million triangles", "million")):
        if which in found:
            facts = found[which]
            yield f"| setup, {name} | {facts['setup']:.1f} s | stated | |"
            yield f"| peak memory, {name} | {facts['peak_mb']:.0f} MB | stated | |"
    if "ten_million" in found:
        facts = found["ten_million"]
        peak = facts["peak_mb"]
        yield f"| setup, ten million triangles | {facts['setup']:.0f} s | stated | |"
        yield (
            f"| peak memory, ten million triangles, the scene's making included | "
            f"{peak / 1000:.1f} GB | {MOST_MEMORY / 1000:.0f} GB | {mark(peak, MOST_MEMORY)} |"
        )
    for name, facts in found["setup"].items():
        setup = facts["setup"]
        yield (
            f"| setup of `{name}.blend` (with Blender's start {facts['whole']:.1f} s) | "
            f"{setup:.1f} s | {SETUP:g} s | {mark(setup, SETUP)} |"
        )
    yield ""
    yield (
        "| scene | pass, 1 thread | 2 threads | efficiency (asked 0.9) | rays a pass | "
        "a pass, processor | bare Embree | pass / Embree (asked 2.0) | share in Embree |"
    )
    yield "|---|---|---|---|---|---|---|---|---|"
    for name, both in found["threads"].items():
        one, two = both["1"], both["2"]
        efficiency = one["pass"] / two["pass"] / 2
        ratio = two["pass_cpu"] / two["embree_cpu"]
        yield (
            f"| {name.replace('_', ' ')} | {1000 * one['pass']:.0f} ms | "
            f"{1000 * two['pass']:.0f} ms | {efficiency:.2f} "
            f"{'met' if efficiency >= EFFICIENCY else '**missed**'} | {two['rays']:,.0f} | "
            f"{1000 * two['pass_cpu']:.0f} ms | {1000 * two['embree_cpu']:.0f} ms | "
            f"{ratio:.1f} {mark(ratio, EMBREE)} | "
            f"{100 / ratio:.0f} % |"
        )
    yield ""
    told = (Path(__file__).with_name("speed_text.md")).read_text("utf-8").splitlines()
    yield from (
        f"Where they are missed: {line[9:]}" for line in told if line[:9] == "budgets: "
    )


def mark(value: float, limit: float) -> str:
    """Whether a budget is kept."""
    return "met" if value <= limit else "**missed**"


if __name__ == "__main__":
    main()
