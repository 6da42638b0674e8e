"""One engine renders one scene in a process of its own; images at growing times.

python benchmarks/speed_worker.py SCENE ENGINE --times 0.5,1,2 -o OUT.npz
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

MODULES = {
    "photonmap": "speed_photonmap",
    "cycles": "speed_cycles",
    "mitsuba": "speed_mitsuba",
    "mitsuba_light": "speed_light_tracing",
    "luxcore_path": "speed_luxcore",
    "luxcore_fine": "speed_luxcore",
    "luxcore_finer": "speed_luxcore",
    "luxcore_bidir": "speed_luxcore",
    "luxcore_vm": "speed_luxcore",
    "povray": "speed_povray",
}


def main() -> None:
    """Render and write what came out."""
    args = arguments()
    started = args.started or time.time()
    if args.engine.startswith("luxcore"):
        # Its allocator takes the whole process over, so it has to be there first.
        import_module("pyluxcore")
    import numpy as np
    from speed_cases import CASES

    building = time.perf_counter()
    scene = CASES[args.scene].build()
    building = time.perf_counter() - building
    module = import_module(MODULES[args.engine])
    start_up = begun = 0.0

    def ready() -> None:
        nonlocal start_up, begun
        start_up, begun = time.time() - started - building, time.process_time()

    times = [float(text) for text in args.times.split(",")]
    seconds, images, told = [], [], []
    for spent, image, *more in module.snapshots(
        scene, args.engine, times, args.seed, args.threads, ready
    ):
        seconds.append(spent)
        images.append(image.astype(np.float32))
        told.append(more[0] if more else {})
        work = time.process_time() - begun
    facts = {
        "engine": module.version(),
        "start_up": start_up,
        # Seconds of the processor for the last image, over all threads.
        "work": work,
        "load": os.getloadavg()[0],
        "peak_mb": peak_megabytes(),
    }
    texts = {"facts": json.dumps(facts), "told": json.dumps(told)}
    np.savez_compressed(args.out, seconds=seconds, images=images, **texts)
    # Blender's threads and LuxCore's sessions may keep the interpreter from ending.
    sys.stdout.flush()
    os._exit(0)


def peak_megabytes() -> float:
    """Most memory that this process had; `getrusage` would count its parent's as well."""
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    line = next(x for x in status.read_text().splitlines() if x.startswith("VmHWM"))
    return int(line.split()[1]) / 1024


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description="Render one scene with one engine.")
    parser.add_argument("scene")
    parser.add_argument("engine", choices=MODULES)
    parser.add_argument("--times", required=True)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--started", type=float, default=0.0, help="clock time of the start")
    parser.add_argument("-o", "--out", type=Path, required=True)
    return parser.parse_args()


if __name__ == "__main__":
    main()
