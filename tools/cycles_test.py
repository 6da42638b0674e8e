"""Fifty renders in a real Blender's window that do not end well: `make cycles BLENDER=path`.

Each is started by F12 while a rendered viewport shows its own, after edits, undo and redo in
that, and ended by Escape, a second F12 and Escape, undo, a file that is loaded, or by itself
(`cycle_steps.py`). Blender must bear it, quickly; no thread of ours may be left when the view
is closed, memory may not grow by more than with Cycles, which goes through the same cycles
before, and the last picture must be that of a Blender that has rendered nothing before. Ends
with 1 otherwise.

Memory is looked at when the allocator has given back what was free. `--planted 2` has each
cancelled render keep 2 MB, which must be refused. `--engine CYCLES` shows what Blender alone
keeps. BLENDER and `--xvfb` as for `window_test.py`.
"""

from __future__ import annotations

import argparse
import os
import statistics
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
from acceptance import ROOT, Blender, check  # type: ignore[import-not-found]
from PIL import Image
from window_test import (  # type: ignore[import-not-found]
    LEAST_CONTRAST,
    MOST_CANCEL,
    PASSES,
    SEEDS,
    headless_picture,
    installed,
    steps_in,
    try_as_asked,
)

CYCLES = 50
#: Files that are loaded over each other.
SAMPLES = ("cornell_glass", "gem")
#: Pixels of the last picture.
SIZE = (160, 120)
#: Threads that render have ended so many seconds after their view was closed.
MOST_LEFT = 1.0
#: The middle memory [MB] of so many cycles may grow so much more to that of the last ones than
#: with Cycles, after the first ones, which load kernels: half of what it would be if each
#: cancelled render kept 2 MB.
SEVERAL, MOST_GROWTH = 15, 16.0
#: Share of the last picture's pixels that may differ by more than rounding.
MOST_DIFFERENT = 0.01


class Watch(threading.Thread):
    """Looks at the memory and the threads of a process, whose number comes in a file.

    From outside, as a Blender in a chroot may have no `/proc`.
    """

    def __init__(self, file: Path) -> None:
        super().__init__(daemon=True)
        self._file = file
        self._ended = threading.Event()
        #: When [s, monotonic], how much [MB], and threads.
        self.seen: list[tuple[float, float, int]] = []

    def run(self) -> None:
        """Until it is told to end, or the process has ended."""
        while not self._ended.wait(0.1):
            if not self._file.is_file() or not (number := self._file.read_text()):
                continue
            try:
                lines = Path(f"/proc/{number}/status").read_text().splitlines()
            except OSError:  # it has ended, or this is no Linux
                return
            told = dict(line.split(":", 1) for line in lines)
            if "VmRSS" in told:
                memory = int(told["VmRSS"].split()[0]) / 1024
                self.seen.append((time.monotonic(), memory, int(told["Threads"])))

    def end(self) -> None:
        """Have it end, and wait."""
        self._ended.set()
        self.join()

    def within(self, begin: float, end: float) -> tuple[float, int]:
        """Least memory [MB] and threads seen in a time."""
        seen = [entry for entry in self.seen if begin <= entry[0] <= end]
        check(seen, "nobody looked at Blender's memory: this takes Linux and its /proc")
        return min(entry[1] for entry in seen), min(entry[2] for entry in seen)


def drive(
    blender: Blender, display: str, folder: Path, engine: str, planted: float = 0.0
) -> dict[str, Any]:
    """Run the cycles; what they found, with memory and threads after each."""
    files = []
    for name in SAMPLES:
        files.append(folder / f"{name}.blend")
        files[-1].write_bytes((ROOT / f"sample_blends/{name}.blend").read_bytes())
    job = {
        "cycles": CYCLES, "files": [str(file) for file in files], "passes": PASSES,
        "seed": SEEDS[0], "size": SIZE, "engine": engine, "planted": planted,
    }  # fmt: skip
    ours = engine == "PHOTONMAP"
    if ours:
        expected = headless_picture(blender, files[0], *SIZE, SEEDS[0])
        for file in files[1:]:  # compiles
            headless_picture(blender, file, 64, 64, 0)
    number = folder / "pid"
    number.unlink(missing_ok=True)
    watch = Watch(number)
    watch.start()
    try:
        found: dict[str, Any] = steps_in(
            blender, display, folder, "cycle_steps.py", files[0], job
        )
    finally:
        watch.end()
    for entry in found["cycles"]:
        unsettled, _ = watch.within(*entry.pop("unsettled"))
        entry["memory"], entry["threads"] = watch.within(*entry.pop("settled"))
        entry["free"] = unsettled - entry["memory"]
    if ours:
        last = Image.open(folder / "last.png").convert("RGB")
        far = np.abs(np.asarray(last)[::-1] / np.float32(255) - expected).max(axis=2)
        found["different"] = float((far > 1.5 / 255).mean())
    return found


def growth(values: list[float]) -> float:
    """How much more the last of them are than those after the first."""
    before = values[SEVERAL : 2 * SEVERAL]
    return statistics.median(values[-SEVERAL:]) - statistics.median(before)


def told_growth(found: dict[str, Any]) -> float:
    """How much memory [MB] has come to be kept."""
    return growth([entry["memory"] for entry in found["cycles"]])


def tell(found: dict[str, Any], engine: str) -> None:
    """Print what was found."""
    entries = found["cycles"]
    print(f"  {engine}, {len(entries)} cycles:")
    for way in dict.fromkeys(entry["way"] for entry in entries):
        seconds = [entry["seconds"] for entry in entries if entry["way"] == way]
        if any(seconds):
            median, most = statistics.median(seconds), max(seconds)
            print(f"  ended by {way}: {median:.2f} s in the median, {most:.2f} at most")
    left = [entry["left"] for entry in entries]
    print(f"  last thread after closing the view: {max(left):.2f} s at most")
    free = f"beside what {' and '.join(found['allocators'])} kept free"
    print(f"  memory grew by {told_growth(found):.1f} MB {free}")
    for key in ("memory", "free", "threads", "objects", "load"):
        print(f"  {key} after cycles: " + " ".join(f"{entry[key]:.0f}" for entry in entries))
    if "different" in found:
        print(f"  pixels of the last picture that differ: {found['different']:.4f}")


def judge(found: dict[str, Any], control: dict[str, Any]) -> None:
    """Raise at what a user would not have liked to see; ``control``: with Cycles."""
    entries = found["cycles"]
    check(len(entries) == CYCLES, f"only {len(entries)} cycles")
    for entry in entries:
        shared = max(1.0, entry["load"] / (os.cpu_count() or 1))
        check(entry["seconds"] <= MOST_CANCEL * shared, f"does not end at once: {entry}")
        check(entry["left"] <= MOST_LEFT * shared, f"threads go on: {entry}")
    grown, usual = told_growth(found), told_growth(control)
    check(
        grown - max(usual, 0.0) <= MOST_GROWTH,
        f"memory grew by {grown:.1f} MB, with Cycles by {usual:.1f}",
    )
    more = growth([entry["threads"] for entry in entries])
    check(more <= 0, f"{more} threads more than before")
    check(found["different"] <= MOST_DIFFERENT, f"last picture: {found['different']} is wrong")
    check(found["viewport"]["contrast"] >= LEAST_CONTRAST, "the last viewport is blank")


def try_cycles(
    command: str, xvfb: str, folder: Path, shots: Path, engine: str, planted: float
) -> None:
    """The whole of it, below ``folder``; screenshots are copied to ``shots``."""
    begin = time.monotonic()
    with installed(command, xvfb, folder, shots) as (blender, display):
        # Glibc's heaps, one for each of the first threads, lend each other nothing. (Where
        # Blender has it from elsewhere this changes nothing.)
        blender.environment["MALLOC_ARENA_MAX"] = "1"
        control = drive(blender, display, folder, "CYCLES")
        tell(control, "Cycles")
        if engine == "CYCLES":
            return
        found = drive(blender, display, folder, engine, planted)
    tell(found, "Photon Map")
    print(f"  all of it took {time.monotonic() - begin:.0f} s")
    judge(found, control)
    print(f"  passed; the screenshots are in {shots}")


def options(parser: argparse.ArgumentParser) -> None:
    """What else the command line may say."""
    parser.add_argument(
        "--engine", choices=("PHOTONMAP", "CYCLES"), default="PHOTONMAP",
        help="CYCLES: what Blender keeps without us, and nothing else",
    )  # fmt: skip
    parser.add_argument(
        "--planted", type=float, default=0.0, metavar="MB",
        help="a leak of so much in each cancelled render, which must be refused",
    )  # fmt: skip


if __name__ == "__main__":
    try_as_asked(__doc__ or "", try_cycles, ROOT / "renders/cycles", options)
