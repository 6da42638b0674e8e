"""Speed against error: Photon Map and its peers on twelve scenes.

    python benchmarks/speed.py [--quick] [--only SCENE ...] [--seconds 30]

Renders every scene with every engine that makes sense on it, by turns, each in a fresh
process; writes `benchmarks/results/speed.csv`, and with `--docs` the tables, plots and
pictures of `docs/benchmarks.md`. Without arguments it takes under 30 minutes on 2 cores,
`--quick` under 5. Needs the ``bench`` and ``blender`` extras.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import speed_document  # noqa: E402
import speed_reference  # noqa: E402
from speed_cases import CASES, Case  # noqa: E402
from speed_run import Run, load_run, run_engine, write_csv  # noqa: E402

OURS = "photonmap"
#: Seconds of rendering of each engine: as long as the tables ask, and in the quick run.
LONGEST, QUICK = 30.0, 8.0
#: What a render takes beyond its curve on a calm machine, in the mean: Python, the scene,
#: start and last image (measured: 1 to 8 s, with a million triangles 15 to 25 s) [s].
AROUND = 6.0


def main() -> None:
    """Run, print and write."""
    args = arguments()
    chosen = [CASES[name] for name in args.only] if args.only else list(CASES.values())
    if args.quick and not args.only:
        chosen = [case for case in chosen if case.quick]
    started = time.perf_counter()
    minutes = planned(chosen, args) / 60
    print(f"about {minutes:.0f} minutes on a calm machine", file=sys.stderr, flush=True)
    references = {case.name: speed_reference.load(case.name) for case in chosen}
    runs: list[Run] = []
    for case in chosen:
        for engine in engines(case, args):
            longest = seconds_each(args)
            out, failure = args.keep / f"{case.name}_{engine}.npz", ""
            if not args.kept:
                failure = run_engine(case.name, engine, longest, args.seed, args.threads, out)
            runs.append(load_run(case.name, engine, references[case.name], out, failure))
            report(runs[-1])
    kept = ROOT / ".cache" / "speed_quick.csv" if args.quick else args.results / "speed.csv"
    write_csv(kept, runs)
    minutes = (time.perf_counter() - started) / 60
    lines = [*speed_document.tables(runs, references)]
    print("\n".join(lines))
    print(f"\n{minutes:.1f} minutes, load {os.getloadavg()[0]:.1f} at the end", file=sys.stderr)
    if args.docs:
        speed_document.write(args.docs, runs, references, minutes, args.results)


def seconds_each(args: argparse.Namespace) -> float:
    """Seconds of rendering of one engine."""
    return float(args.seconds or (QUICK if args.quick else LONGEST))


def planned(chosen: Sequence[Case], args: argparse.Namespace) -> float:
    """Seconds that the whole run should take."""
    renders = sum(len(engines(case, args)) for case in chosen)
    return renders * (seconds_each(args) + AROUND)


def engines(case: Case, args: argparse.Namespace) -> tuple[str, ...]:
    """Who renders ``case``: ours first."""
    peers = case.quick if args.quick and case.quick else case.peers
    both = (OURS, *peers)
    return tuple(name for name in both if not args.engines or name in args.engines)


def report(run: Run) -> None:
    """One line to whoever waits."""
    last = run.rows[-1] if run.rows else None
    text = run.failure or (last and f"relMSE {last.error:.5f} at {last.seconds:.1f} s")
    print(f"{run.scene:12s} {run.engine:14s} {text}", file=sys.stderr, flush=True)


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description="Photon Map and its peers.")
    parser.add_argument("--quick", action="store_true", help="fewer scenes, peers, seconds")
    parser.add_argument("--only", nargs="+", choices=CASES, help="these scenes")
    parser.add_argument("--engines", nargs="+", help="these engines")
    parser.add_argument("--seconds", type=float, help="of rendering, for each engine")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)))
    results = Path(__file__).with_name("results")
    parser.add_argument("--results", type=Path, default=results, help="folder of the csv")
    keep = ROOT / ".cache" / "speed"
    parser.add_argument("--keep", type=Path, default=keep, help="folder of the images")
    parser.add_argument("--kept", action="store_true", help="render nothing, use those kept")
    parser.add_argument("--docs", type=Path, help="folder of benchmarks.md, to write it anew")
    return parser.parse_args()


if __name__ == "__main__":
    main()
