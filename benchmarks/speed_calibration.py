"""How the error that Photon Map states compares with the one that is measured."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from speed_cases import CASES
from speed_run import Row, Run

OURS = "photonmap"
#: True over stated error, as roots of relMSE: what is asked for, from how many passes on.
LOW, HIGH, SHARE, FIRST = 0.75, 1.33, 0.9, 8
#: Passes of the table's columns.
PASSES = (8, 16, 32, 64, 128, 256, 512)
#: The stated error at which a render with an error goal of 5 % ends.
GOAL = 0.05


def ratio(row: Row) -> float:
    """True over stated error; NaN where the reference does not tell the true one."""
    if not row.is_known or not 0.0 < row.stated < math.inf:
        return float("nan")
    return math.sqrt(row.error) / row.stated


def points(rows: Sequence[Row]) -> list[Row]:
    """The images at the powers of two of the passes from ``FIRST`` on, whose error is known."""
    found = []
    for row in rows:
        passes = max((p for p in PASSES if p <= row.passes), default=0)
        near = passes and row.passes <= 1.25 * passes
        if near and not any(passes <= r.passes <= 1.25 * passes for r in found):
            found.append(row)
    return [row for row in found if not math.isnan(ratio(row))]


def at_goal(rows: Sequence[Row], goal: float = GOAL) -> float:
    """The true error where the stated one falls to ``goal``, on a straight line between the
    logarithms; NaN where it does not, or the reference does not tell."""
    for before, after in zip(rows, rows[1:], strict=False):
        if before.stated > goal >= after.stated and not math.isnan(ratio(after)):
            if math.isnan(ratio(before)):
                return goal * ratio(after)
            part = math.log(before.stated / goal) / math.log(before.stated / after.stated)
            both = ratio(before) ** (1.0 - part) * ratio(after) ** part
            return goal * both
    return float("nan")


def calibration_section(curves: Mapping[str, Mapping[str, Run]]) -> Iterator[str]:
    """The table of true over stated error."""
    ours = {name: engines[OURS].rows for name, engines in curves.items() if OURS in engines}
    if not any(ours.values()):
        return
    yield "## Stated error against true error"
    yield ""
    found = [ratio(row) for rows in ours.values() for row in points(rows)]
    good = sum(LOW <= value <= HIGH for value in found)
    if found:
        yield (
            f"True over stated error (roots of relMSE, noise and bias together) at powers of "
            f"two of the passes: {good} of {len(found)} points "
            f"({100 * good / len(found):.0f} %) lie within {LOW:g} to {HIGH:g}; "
            f"{100 * SHARE:.0f} % are asked from pass {FIRST} on. The last columns: the true "
            f"error of a render that stops where it states {100 * GOAL:g} % (asked: "
            f"{100 * LOW * GOAL:.2f} to {100 * HIGH * GOAL:.2f} %), and the parts of the last "
            "statement. A dash: the render was not there, or its reference is too noisy to say."
            " Light that no path has found yet is in no statement; at few passes, light that "
            "one of four replicates alone has found makes it too large."
        )
        yield ""
    heads = " | ".join(f"{passes}" for passes in PASSES)
    yield f"| scene | {heads} | within | at {100 * GOAL:g} % | noise | bias |"
    yield "|---|" + "---|" * (len(PASSES) + 4)
    for name, rows in ours.items():
        if rows:
            yield f"| {CASES[name].title} | " + " | ".join(cells(rows)) + " |"
    yield ""


def cells(rows: Sequence[Row]) -> Iterator[str]:
    """One row of the table."""
    known = points(rows)
    for passes in PASSES:
        at = [row for row in known if passes <= row.passes <= 1.25 * passes]
        yield marked(ratio(at[0]), LOW, HIGH) if at else "-"
    inside = sum(LOW <= ratio(row) <= HIGH for row in known)
    yield f"{inside} of {len(known)}"
    goal = at_goal(rows)
    yield "-" if math.isnan(goal) else marked(100 * goal, 100 * LOW * GOAL, 100 * HIGH * GOAL)
    last = rows[-1]
    yield f"{100 * last.noise:.1f} %"
    yield f"{100 * last.bias:.1f} %"


def marked(value: float, low: float, high: float) -> str:
    """Two decimals, bold where it is outside of what is asked."""
    text = f"{value:.2f}"
    return text if low <= value <= high else f"**{text}**"
