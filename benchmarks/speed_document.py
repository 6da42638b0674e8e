"""Tables, plots and pictures of the benchmark, and `docs/benchmarks.md` around them."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path

import numpy as np
import speed_plots
from speed_cases import CASES
from speed_reference import Reference
from speed_run import Run, error_at, slope, time_to

OURS = "photonmap"
NAMES = {
    OURS: "Photon Map",
    "cycles": "Cycles",
    "mitsuba": "Mitsuba path",
    "luxcore_path": "LuxCore path + photon cache",
    "luxcore_bidir": "LuxCore bidirectional",
    "luxcore_vm": "LuxCore vertex merging",
    "luxcore_fine": "LuxCore photon cache",
    "luxcore_finer": "LuxCore path, fine photon cache",
    "povray": "POV-Ray photons",
}
#: Second of the last error in the tables.
AT_LAST = 30.0
#: relMSE of 10, 5 and 2 % in a typical pixel, and where bias shows.
GOALS = (0.01, 0.0025, 0.001, 0.0004)
#: What a cell says when the reference itself is noisier than the error asked for.
NOISY = "reference"
#: relMSE of a reference that can judge the smallest of the errors.
ENOUGH = 4e-4
TEXT = Path(__file__).with_name("speed_text.md")
Curves = dict[str, dict[str, Run]]


def curves_of(runs: Sequence[Run]) -> Curves:
    """Runs by scene and engine."""
    found: Curves = {}
    for run in runs:
        found.setdefault(run.scene, {})[run.engine] = run
    return found


def tables(runs: Sequence[Run], references: Mapping[str, Reference]) -> Iterator[str]:
    """All tables as Markdown lines."""
    curves = curves_of(runs)
    noise = {name: reference.noise for name, reference in references.items()}
    yield "## Against the targets"
    yield ""
    yield from target_table(curves, noise)
    yield ""
    yield "## Time to an error"
    yield ""
    yield from time_table(curves, noise)
    yield ""
    yield "## References"
    yield ""
    yield from reference_table(references)


def target_table(curves: Curves, noise: Mapping[str, float]) -> Iterator[str]:
    """The ratio to the best peer at relMSE 0.01, and who leads at 0.001."""
    yield (
        "| scene | Photon Map to 0.01 | best peer to 0.01 | ratio | target | | "
        "to 0.001, Photon Map | best peer | |"
    )
    yield "|---|---|---|---|---|---|---|---|---|"
    for name, engines in curves.items():
        if OURS not in engines or len(engines) < 2:
            continue
        if noise[name] > 0.01:
            yield (
                f"| {CASES[name].title} | {NOISY} | | | 1/{1 / CASES[name].target:g} |"
                + " |" * 4
            )
            continue
        case, cells = CASES[name], []
        for goal in (0.01, 0.001):
            ours = time_to(engines[OURS].rows, goal)
            peers = {k: time_to(r.rows, goal) for k, r in engines.items() if k != OURS}
            best = min(peers, key=lambda k: peers[k])
            cells.append((ours, best, peers[best], longest(engines)))
        (ours, best, peer, end), (ours_low, best_low, peer_low, _) = cells
        target = 1 / case.target
        yield (
            f"| {case.title} | {in_time(ours, end)} | {in_time(peer, end)} "
            f"({NAMES[best] if np.isfinite(peer) else 'none'}) | {ratio_of(ours, peer, end)} | "
            f"1/{target:g} | {verdict(ours, peer, end, case.target)} | "
            f"{in_time(ours_low, end)} | {in_time(peer_low, end)}"
            f"{' (' + NAMES[best_low] + ')' if np.isfinite(peer_low) else ''} | "
            f"{lead(ours_low, peer_low) if noise[name] < 0.001 else NOISY} |"
        )


def longest(engines: Mapping[str, Run]) -> float:
    """The end of the peers' curves [s]."""
    ends = [run.rows[-1].seconds for key, run in engines.items() if key != OURS and run.rows]
    return max(ends, default=float("nan"))


def in_time(seconds: float, end: float) -> str:
    """A time, or that it is not reached by ``end``."""
    return f"{seconds:.2g} s" if np.isfinite(seconds) else f"> {end:.0f} s"


def ratio_of(ours: float, peer: float, end: float) -> str:
    """Ours over the best peer's."""
    if not np.isfinite(ours):
        return "-"
    if not np.isfinite(peer):
        return f"< 1/{end / ours:.1f}"
    return f"1/{peer / ours:.1f}"


def verdict(ours: float, peer: float, end: float, target: float) -> str:
    """Whether the target is met, as far as the curves reach."""
    if not np.isfinite(ours):
        return "**missed**" if np.isfinite(peer) else "nobody there"
    if not np.isfinite(peer):
        return "met" if ours <= target * end else "peers too slow to tell"
    return "met" if ours <= target * peer else "**missed**"


def lead(ours: float, peer: float) -> str:
    """Who is first at the smaller error."""
    if not np.isfinite(ours) and not np.isfinite(peer):
        return "nobody there"
    return "ahead" if ours < peer else "**behind**"


def time_table(curves: Curves, noise: Mapping[str, float]) -> Iterator[str]:
    """One row per scene and engine."""
    goals = " | ".join(f"to {goal:g}" for goal in GOALS)
    yield (
        f"| scene | engine | {goals} | relMSE at 5 s | at {AT_LAST:g} s | slope | mean | "
        "start-up | memory |"
    )
    yield "|---|---|" + "---|" * (len(GOALS) + 6)
    for name, engines in curves.items():
        for engine, run in engines.items():
            head = f"| {CASES[name].title} | {NAMES[engine]} | "
            if not run.rows:
                yield head + f"failed: {run.failure} |" + " |" * (len(GOALS) + 5)
                continue
            end = run.rows[-1].seconds
            cells = [
                in_time(time_to(run.rows, goal), end) if goal > noise[name] else NOISY
                for goal in GOALS
            ]
            cells += [number(error_at(run.rows, at)) for at in (5.0, AT_LAST)]
            last = run.rows[-1]
            cells += [f"{slope(run.rows):.2f}", f"{100 * (last.mean - 1):+.1f} %"]
            cells += [f"{last.start_up:.1f} s", f"{last.peak_mb:.0f} MB"]
            yield head + " | ".join(cells) + " |"


def number(value: float) -> str:
    """Two digits, or a dash."""
    return f"{value:.2g}" if np.isfinite(value) else "-"


def reference_table(references: Mapping[str, Reference]) -> Iterator[str]:
    """Who made the references, and how wrong they are."""
    rough = [name for name, reference in references.items() if reference.noise > ENOUGH]
    if rough:
        yield (
            f"**{len(rough)} of {len(references)} references are noisier than {ENOUGH:g}**: "
            'where a table says "reference" nothing can be said of that error yet. `make '
            "bench-references` goes on with them, for some hours on a quiet machine."
        )
        yield ""
    yield "| scene | rendered by | seconds of 2 threads | its own relMSE |"
    yield "|---|---|---|---|"
    for name, reference in references.items():
        facts = reference.facts
        by = facts["engine"] + (
            "" if facts["mode"] == "mitsuba" else f", {NAMES[facts['mode']]}"
        )
        noise = f"{reference.noise:.1e}"
        yield f"| {CASES[name].title} | {by} | {facts['seconds']:.0f} | {noise} |"


def write(
    docs: Path,
    runs: Sequence[Run],
    references: Mapping[str, Reference],
    minutes: float,
    results: Path,
) -> None:
    """`benchmarks.md` with its pictures in `docs/benchmarks`."""
    curves = curves_of(runs)
    pictures = docs / "benchmarks"
    pictures.mkdir(parents=True, exist_ok=True)
    speed_plots.curves(pictures / "curves.png", curves, NAMES)
    speed_plots.strips(pictures / "strips.png", curves, references, NAMES)
    lines = [TEXT.read_text("utf-8").rstrip(), "", *machine(runs, minutes), ""]
    lines += [*tables(runs, references), ""]
    lines += ["## Error over time", "", "![relMSE over seconds](benchmarks/curves.png)", ""]
    lines += ["## The same time", "", speed_plots.STRIPS, "", "![](benchmarks/strips.png)", ""]
    budgets = results / "budgets.json"
    if budgets.exists():
        import speed_budgets

        lines += [*speed_budgets.section(json.loads(budgets.read_text()))]
    (docs / "benchmarks.md").write_text("\n".join(lines).rstrip() + "\n", "utf-8")


def machine(runs: Sequence[Run], minutes: float) -> Iterator[str]:
    """Where and with what it ran; a loaded machine is named as one."""
    versions = sorted({row.version for run in runs for row in run.rows})
    loads = [row.load for run in runs for row in run.rows]
    yield (
        f"Measured on {date.today().isoformat()}: {len(os.sched_getaffinity(0))} cores "
        f"({platform.machine()}), Python {platform.python_version()}; "
        f"{', '.join(versions)}. "
        + (f"{minutes:.0f} minutes." if minutes >= 1 else "Written from renders kept before.")
    )
    last = max((row.seconds for run in runs for row in run.rows), default=0.0)
    if last < 0.95 * AT_LAST:
        yield ""
        yield f"A shortened run: no curve goes beyond {last:.0f} s, {AT_LAST:g} are asked."
    busy = float(np.mean(loads)) if loads else 0.0
    if busy > 1.3 * len(os.sched_getaffinity(0)):
        yield ""
        yield (
            f"**The machine was shared: a mean load of {busy:.1f}.** All times are longer than "
            "on a quiet one and differ by chance; the run is to be repeated."
        )
