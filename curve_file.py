"""The error over time of a render, as a table and as a plot beside its report."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .core.version import ENGINE, VERSION

if TYPE_CHECKING:
    from .core.report import CurvePoint

#: Columns of the table.
COLUMNS = ("pass", "seconds", "relative_error", "noise", "bias")


def write_curve_table(path: Path, points: Sequence[CurvePoint]) -> None:
    """Write ``points`` as CSV with a row of ``COLUMNS``; what is not known yet stays empty."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for point in points:
            errors = (point.error.relative_error, *point.error)
            known = (f"{error:.6g}" if math.isfinite(error) else "" for error in errors)
            writer.writerow((point.passes, f"{point.seconds:.3f}", *known))


def write_curve_plot(path: Path, points: Sequence[CurvePoint], title: str) -> None:
    """Draw ``points`` over the seconds of rendering, both axes logarithmic; SVG or PNG."""
    # Not pyplot: its state is shared with others in the process, and it looks for a window.
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 4.4), layout="constrained")
    axes = figure.add_subplot()
    known = [p for p in points if math.isfinite(p.error.noise) and p.seconds > 0]
    seconds = [p.seconds for p in known]
    for name, style, values in (
        ("noise and bias", "-", [p.error.relative_error for p in known]),
        ("noise", "--", [p.error.noise for p in known]),
        ("bias", ":", [p.error.bias for p in known]),
    ):
        if any(value > 0 for value in values):
            # A logarithmic axis has no place for what could not be told from 0.
            shown = [100 * value if value > 0 else math.nan for value in values]
            marker = "." if len(known) < 30 else ""
            axes.plot(seconds, shown, style, marker=marker, label=name, gid=name)
    if axes.lines:
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.legend()
    axes.set_xlabel("seconds of rendering")
    axes.set_ylabel("stated error of a typical pixel [%]")
    axes.set_title(title)
    axes.grid(True, which="both", alpha=0.3)
    figure.savefig(path, metadata={"Title": title}, dpi=120)


def curve_title(scene: str, width: int, height: int) -> str:
    """What a plot is of."""
    return f"{scene}, {width}x{height}, {ENGINE} {VERSION}"
