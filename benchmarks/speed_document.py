"""Tables, plots and pictures of the benchmark, and `docs/benchmarks.md` around them."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import speed_plots
from speed_calibration import calibration_section
from speed_cases import CASES
from speed_error import Measured, Reference
from speed_run import KNOWN, SURE, Crossing, Run, error_at, slope, time_to

OURS = "photonmap"
NAMES = {
    OURS: "Photon Map",
    "cycles": "Cycles",
    "mitsuba": "Mitsuba path",
    "mitsuba_light": "Mitsuba light tracing",
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
#: What a cell says when the reference's noise leaves too much doubt.
NOISY = "reference"
#: relMSE of a reference that can judge the smallest of the errors.
ENOUGH = 4e-4
TEXT = Path(__file__).with_name("speed_text.md")
#: Where the causes of missed targets begin in it.
CAUSES = "<!-- causes"
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
    yield "## Against the targets"
    yield ""
    yield from target_table(curves)
    yield ""
    yield from causes(curves)
    yield "## Time to an error"
    yield ""
    yield from time_table(curves)
    yield ""
    yield from calibration_section(curves)
    yield "## References"
    yield ""
    yield from reference_table(references)


def target_table(curves: Curves) -> Iterator[str]:
    """The ratio to the best peer at relMSE 0.01, and who leads at 0.001."""
    yield (
        "| scene | Photon Map to 0.01 | best peer to 0.01 | ratio | target | | "
        "to 0.001, Photon Map | best peer | |"
    )
    yield "|---|---|---|---|---|---|---|---|---|"
    for name, engines in curves.items():
        if OURS not in engines or len(engines) < 2:
            continue
        case, end = CASES[name], longest(engines)
        ours, best, peer = race(engines, 0.01)
        ours_low, best_low, peer_low = race(engines, 0.001)
        yield (
            f"| {case.title} | {in_time(ours, end)} | {in_time(peer, end)} ({best}) | "
            f"{ratio_of(ours, peer, end)} | 1/{1 / case.target:g} | "
            f"{verdict(ours, peer, end, case.target)} | "
            f"{in_time(ours_low, end)} | {in_time(peer_low, end)} ({best_low}) | "
            f"{lead(ours_low, peer_low)} |"
        )


def causes(curves: Curves) -> Iterator[str]:
    """Why targets are missed, one line a scene, as ``speed_text.md`` tells."""
    known = dict(
        line.split(": ", 1)
        for line in TEXT.read_text("utf-8").partition(CAUSES)[2].splitlines()
        if line.split(": ", 1)[0] in CASES
    )
    lines = []
    for name, engines in curves.items():
        if OURS not in engines or len(engines) < 2:
            continue
        end = longest(engines)
        ours, _, peer = race(engines, 0.01)
        if "missed" in verdict(ours, peer, end, CASES[name].target):
            text = known.get(name, "not profiled yet")
            last = engines[OURS].rows[-1] if engines[OURS].rows else None
            share = f" ({percent(last.embree)} of the time in Embree)" if last else ""
            lines.append(f"- {CASES[name].title}{share}: {text}.".replace("..", "."))
    if lines:
        yield "Why targets are missed:"
        yield ""
        yield from lines
        yield ""


def race(engines: Mapping[str, Run], goal: float) -> tuple[Crossing, str, Crossing]:
    """Our time to an error, and the name and the time of the best peer.

    A peer of whom the reference cannot tell counts only if no other is there.
    """
    peers = {k: time_to(r.rows, goal) for k, r in engines.items() if k != OURS}
    best = min(peers, key=lambda k: (np.isnan(peers[k].seconds), peers[k].seconds))
    if not np.isfinite(peers[best].seconds):
        # None is there; one that may be is told before those that are surely not.
        best = max(peers, key=lambda k: np.isnan(peers[k].seconds))
    name = NAMES[best] if np.isfinite(peers[best].seconds) else "none"
    return time_to(engines[OURS].rows, goal), name, peers[best]


def longest(engines: Mapping[str, Run]) -> float:
    """The end of the peers' curves [s]."""
    ends = [run.rows[-1].seconds for key, run in engines.items() if key != OURS and run.rows]
    return max(ends, default=float("nan"))


def in_time(time: Crossing, end: float) -> str:
    """A time, or that it is not reached by ``end``."""
    if np.isnan(time.seconds):
        return NOISY
    if not np.isfinite(time.seconds):
        return f"> {end:.0f} s"
    return f"{'< ' if time.below else ''}{time.seconds:.2g} s"


def ratio_of(ours: Crossing, peer: Crossing, end: float) -> str:
    """Ours over the best peer's."""
    if not np.isfinite(ours.seconds) or np.isnan(peer.seconds):
        return "-"
    if not np.isfinite(peer.seconds):
        return f"< 1/{end / ours.seconds:.1f}"
    # The bounds of both: the ratio of an upper bound over a time is an upper bound.
    sign = "?" if peer.below else "<" if ours.below else ""
    return f"{sign} 1/{peer.seconds / ours.seconds:.1f}".strip()


def verdict(ours: Crossing, peer: Crossing, end: float, target: float) -> str:
    """Whether the target is met, as far as the curves and the reference reach."""
    if np.isnan(ours.seconds) or np.isnan(peer.seconds):
        return NOISY
    if not np.isfinite(ours.seconds):
        return "**missed**" if np.isfinite(peer.seconds) else "nobody there"
    if not np.isfinite(peer.seconds):
        return "met" if ours.seconds <= target * end else "peers too slow to tell"
    if ours.seconds <= target * peer.seconds:
        return "met"
    return "curves begin too late" if ours.below else "**missed**"


def lead(ours: Crossing, peer: Crossing) -> str:
    """Who is first at the smaller error."""
    if np.isnan(ours.seconds) or np.isnan(peer.seconds):
        return NOISY
    if not np.isfinite(ours.seconds) and not np.isfinite(peer.seconds):
        return "nobody there"
    return "ahead" if ours.seconds < peer.seconds else "**behind**"


def time_table(curves: Curves) -> Iterator[str]:
    """One row per scene and engine."""
    goals = " | ".join(f"to {goal:g}" for goal in GOALS)
    yield (
        f"| scene | engine | {goals} | relMSE at 5 s | at {AT_LAST:g} s | slope | mean | "
        "Embree | start-up | memory |"
    )
    yield "|---|---|" + "---|" * (len(GOALS) + 7)
    for name, engines in curves.items():
        for engine, run in engines.items():
            head = f"| {CASES[name].title} | {NAMES[engine]} | "
            if not run.rows:
                yield head + f"failed: {run.failure} |" + " |" * (len(GOALS) + 6)
                continue
            end = run.rows[-1].seconds
            cells = [in_time(time_to(run.rows, goal), end) for goal in GOALS]
            cells += [measured(error_at(run.rows, at)) for at in (5.0, AT_LAST)]
            last = run.rows[-1]
            cells += [number(slope(run.rows)), f"{100 * (last.mean - 1):+.1f} %"]
            cells += [percent(last.embree)]
            cells += [f"{last.start_up:.1f} s", f"{last.peak_mb:.0f} MB"]
            yield head + " | ".join(cells) + " |"


def measured(value: Measured) -> str:
    """An error that is known, or what it is surely below."""
    if np.isnan(value.error) or value.deviation <= KNOWN * value.error:
        return number(value.error)
    return f"< {number(max(value.error, 0.0) + SURE * value.deviation)}"


def percent(share: float) -> str:
    """A share, or a dash."""
    return f"{100 * share:.0f} %" if np.isfinite(share) else "-"


def number(value: float) -> str:
    """Two digits, or a dash."""
    return f"{value:.2g}" if np.isfinite(value) else "-"


def reference_table(references: Mapping[str, Reference]) -> Iterator[str]:
    """Who made the references, and how wrong they are."""
    rough = [name for name, reference in references.items() if reference.noise > ENOUGH]
    if rough:
        yield (
            f"{len(rough)} of {len(references)} references are noisier than {ENOUGH:g}. Errors "
            "below a reference's own are told where its noise leaves less than "
            f"{100 * KNOWN:.0f} % of doubt (see above). `make bench-references` goes on with "
            "them, for some hours on a quiet machine."
        )
        yield ""
    yield "| scene | rendered by | seconds of the processor | its own relMSE |"
    yield "|---|---|---|---|"
    for name, reference in references.items():
        by = "; ".join(judged(*pair) for pair in reference.facts["judges"].items())
        noise = f"{reference.noise:.1e}"
        yield f"| {CASES[name].title} | {by} | {reference.work.sum():.0f} | {noise} |"


def judged(mode: str, facts: Mapping[str, Any]) -> str:
    """Who made a reference, and of which part of the pixels."""
    by = facts["engine"] + ("" if mode == "mitsuba" else f", {NAMES[mode]}")
    share = facts["pixels"]
    return by if share == 1.0 else f"{by} ({100 * share:.0f} % of the pixels)"


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
    text = TEXT.read_text("utf-8").partition(CAUSES)[0].rstrip()
    lines = [text, "", *machine(runs, minutes), ""]
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
