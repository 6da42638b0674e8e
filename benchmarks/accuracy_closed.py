"""Closed forms and convergence in docs/accuracy.md: caustics, slopes, the stability tests."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import accuracy_pictures as pictures

ROOT = Path(__file__).resolve().parents[1]
PASSES = (1, 4, 16, 64, 256)
#: Slopes of the mean squared error over passes that theory allows, by layer. Layers without
#: photons may be steeper: Sobol points are.
CAUSTIC_SLOPES = (-0.75, -0.60)
OTHER_SLOPES = (-1.05, -0.90)
STABILITY_TIMEOUT = 2400.0

SLOPES = """\
Slope of log MSE over log passes with a 99 % interval over seeds (`tests/convergence`).
Progressive photon mapping with alpha = 2/3 makes an error shrink like passes^(-2/3) (Knaus
and Zwicker 2011): the caustics where all discs are of even size. Crowded discs are smaller
from the first pass on and stay as they are until the others are as small, after thousands of
passes here: theirs is a mean of equal estimates, 1/passes. The discs of the global map shrink
with 0.95, so the indirect layer falls almost like plain averaging; its two scenes are a ball,
where all noise is that of the photons, and a glowing box, where discs stick out over borders.
Layers without photons are averages of scrambled Sobol points, steeper than 1/passes where
light is smooth (Owen 1997), so theirs is a bound on one side: at least as steep as -0.9. The
mean is the image's at the most passes over the truth, less 1: within its error, or, for
caustics, a bias that falls on with their discs.

| layer | slope | interval | last three | wanted | mean | bias, share of error | state |
|---|---|---|---|---|---|---|---|"""

HARD_CASES = """\
Each row by its tests in `tests/stability`, in every variation; all renders of it fail on NaN,
infinity or negative light. The deviation is the largest one of an image's mean from the closed
form, noise included; the tests hold it by its confidence interval, and most of them hold the
pixels too. A row without one is held by equality or bounds."""


def caustics(folder: Path) -> Iterator[str]:
    """Error of each closed-form caustic at growing numbers of passes."""
    from photon_map.tests.analytic.cases import CASES, table

    yield "## Caustics with a closed form"
    yield ""
    yield "Relative RMS error over the pixels that the closed form covers (`tests/analytic`),"
    yield "and the error of the mean at the last number of passes. Photons are those of a pass."
    yield ""
    yield (
        "| caustic | closed form | photons | "
        + " | ".join(f"{n}" for n in PASSES)
        + " | mean |"
    )
    yield "|---" * (4 + len(PASSES)) + "|"
    rows: dict[str, Sequence[Any]] = {}
    for case in CASES:
        results = rows[case.name] = table(case, PASSES)
        cells = " | ".join(f"{r.error:.4f}" for r in results)
        photons = results[-1].photons // results[-1].passes
        mean = f"{100 * results[-1].mean_error:+.2f} %"
        law = case.law.replace("|", r"\|")
        yield f"| {case.name} | {law} | {photons} | {cells} | {mean} |"
    pictures.errors(rows, folder / "caustics.png")
    yield ""
    yield f"![error against photons]({folder.name}/caustics.png)"
    yield ""
    for name, results in rows.items():
        file = f"caustic_{name.replace(' ', '_')}.png"
        pictures.pair(results[-1], name, folder / file)
        yield f"![{name}]({folder.name}/{file})"
        yield ""


def convergence(folder: Path) -> Iterator[str]:
    """Slope of the mean squared error of each layer over passes."""
    from photon_map.tests.convergence.slopes import CASES, measure

    yield "## Convergence"
    yield ""
    yield SLOPES
    rows = [measure(case) for case in CASES]
    for row in rows:
        low, high = CAUSTIC_SLOPES if row.layer == "even discs" else OTHER_SLOPES
        steeper = row.layer in ("emission", "direct")
        wanted = f"at most {high:.2f}" if steeper else f"{low:.2f} to {high:.2f}"
        mean = f"{100 * row.offset[-1]:+.2f} ± {100 * row.offset_error[-1]:.2f} %"
        bias = max(0.0, float(row.bias2[-1] / row.mse[-1]))
        yield (
            f"| {row.layer} | {row.slope:.3f} | {row.low:.3f} to {row.high:.3f} "
            f"| {row.last:.3f} | {wanted} | {mean} | {bias:.2f} "
            f"| {slope_state(row, -math.inf if steeper else low, high)} |"
        )
    pictures.slopes(rows, folder / "convergence.png")
    yield ""
    yield f"![mean squared error over passes]({folder.name}/convergence.png)"
    yield ""


def slope_state(row: Any, low: float, high: float) -> str:
    """Whether the interval of a slope meets what is wanted, or lies beyond it."""
    if row.low > high:
        return "**FAILED**: slower than wanted"
    return "pass" if row.high >= low else "faster than wanted"


def stability() -> Iterator[str]:
    """Outcome of every row of the stability suite."""
    from photon_map.tests.stability.rows import ROWS

    outcomes = stability_outcomes()
    yield "## Hard cases"
    yield ""
    yield HARD_CASES
    yield ""
    yield "| case | held to | tests | cases | deviation | state |"
    yield "|---|---|---|---|---|---|"
    for row in ROWS:
        found = [o for name in row.tests for o in outcomes.get(name, [])]
        missing = [name for name in row.tests if name not in outcomes]
        noted = [o.deviation for o in found if o.deviation is not None]
        bad = [f"**{o.state}** `{o.name}`" for o in found if o.state != "pass"]
        bad += [f"**missing** `{name}`" for name in missing]
        tests = ", ".join(name.replace("_", " ") for name in row.tests)
        worst = f"{max(noted):.1e}" if noted else ""
        state = "; ".join(bad) or "pass"
        yield f"| {row.case} | {row.law} | {tests} | {len(found)} | {worst} | {state} |"
    yield ""


class Outcome(NamedTuple):
    """One variation of a test: ``state`` is pass, failure, error or skipped."""

    name: str
    state: str
    deviation: float | None


def stability_outcomes() -> dict[str, list[Outcome]]:
    """Outcomes by test, from a run of pytest."""
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder) / "report.xml"
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
        # Only this kind of report holds what the tests have noted.
        command += [f"--junitxml={report}", "-o", "junit_family=xunit1", "tests/stability"]
        subprocess.run(
            command, cwd=ROOT, env=dict(os.environ), timeout=STABILITY_TIMEOUT,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        cases = list(ElementTree.parse(report).iter("testcase"))
    outcomes: dict[str, list[Outcome]] = {}
    for case in cases:
        name = case.get("name", "").removeprefix("test_").replace("|", " or ")
        bad = [child.tag for child in case if child.tag in ("failure", "error", "skipped")]
        noted = [p.get("value") for p in case.iter("property") if p.get("name") == "deviation"]
        deviation = float(noted[0]) if noted and noted[0] else None
        outcome = Outcome(name, bad[0] if bad else "pass", deviation)
        outcomes.setdefault(name.partition("[")[0], []).append(outcome)
    return outcomes
