"""Runs the engines by turns, each render in a process of its own, and keeps the curves."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np
from measure import Image
from speed_reference import Reference

WORKER = Path(__file__).with_name("speed_worker.py")
#: Longest time a render may take beyond its last image [s].
PATIENCE = 240.0
#: When images are looked at, about [s].
TIMES = (0.25, 0.5, 1.0, 2.0, 3.5, 5.0, 8.0, 12.0, 20.0, 30.0)


@dataclass(frozen=True)
class Row:
    """One image. ``error``: relMSE, the reference's own noise taken off; ``mean``: the
    image's mean over the reference's."""

    scene: str
    engine: str
    seconds: float
    error: float
    mean: float
    start_up: float
    peak_mb: float
    version: str
    load: float


@dataclass(frozen=True)
class Run:
    """The curve of one engine on one scene, and its image closest to ``at`` seconds."""

    scene: str
    engine: str
    rows: tuple[Row, ...]
    seconds: tuple[float, ...] = ()
    images: tuple[Image, ...] = ()
    failure: str = ""


def run_engine(
    scene: str, engine: str, longest: float, seed: int, threads: int, out: Path
) -> str:
    """Render with one engine up to ``longest`` seconds; what went wrong, or ""."""
    times = [t for t in TIMES if t < 0.99 * longest] + [longest]
    command = [sys.executable, str(WORKER), scene, engine, "-o", str(out)]
    command += ["--times", ",".join(f"{t:g}" for t in times), "--seed", str(seed)]
    command += ["--threads", str(threads), "--started", str(time.time())]
    out.parent.mkdir(parents=True, exist_ok=True)
    out.unlink(missing_ok=True)
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=longest + PATIENCE
        )
    except subprocess.TimeoutExpired:
        return f"no end after {longest + PATIENCE:.0f} s"
    if done.returncode or not out.exists():
        lines = (done.stderr or done.stdout).strip().splitlines() or ["nothing said"]
        return lines[-1]
    return ""


def load_run(
    scene: str, engine: str, reference: Reference, out: Path, failure: str = ""
) -> Run:
    """The curve of the images in ``out``, as ``speed_worker.py`` left them."""
    if failure or not out.exists():
        return Run(scene, engine, (), failure=failure or "was not run")
    with np.load(out) as kept:
        seconds, images = kept["seconds"], kept["images"].astype(np.float64)
        facts = json.loads(str(kept["facts"]))
    rows = []
    for spent, image in zip(seconds, images, strict=True):
        error = reference.error(image)
        mean = float(image.mean() / reference.image.mean())
        rows.append(
            Row(
                scene, engine, float(spent), error, mean, facts["start_up"], facts["peak_mb"],
                facts["engine"], facts["load"],
            )
        )  # fmt: skip
    return Run(scene, engine, tuple(rows), tuple(map(float, seconds)), tuple(images))


def write_csv(path: Path, runs: Iterable[Run]) -> None:
    """All rows of all runs."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(field.name for field in fields(Row))
        for run in runs:
            for row in run.rows:
                values = [f"{v:.6g}" if isinstance(v, float) else v for v in astuple(row)]
                writer.writerow(values)


def time_to(rows: Sequence[Row], goal: float) -> float:
    """Seconds to relMSE ``goal``, on the straight lines between points in the logarithms.

    The crossing from which on the curve stays below counts; inf when there is none, and
    the first point's time when it is below already (an upper bound).
    """
    if not rows or rows[-1].error > goal:
        return float("inf")
    last = max((i for i, row in enumerate(rows) if row.error > goal), default=-1)
    if last < 0:
        return rows[0].seconds
    a, b = rows[last], rows[last + 1]
    low = max(b.error, 1e-9)
    part = np.log(a.error / goal) / np.log(a.error / low)
    return float(a.seconds * (b.seconds / a.seconds) ** part)


def error_at(rows: Sequence[Row], seconds: float) -> float:
    """relMSE after ``seconds``, interpolated likewise; NaN outside of the curve."""
    points = [(np.log(r.seconds), np.log(r.error)) for r in rows if r.error > 0]
    if not points or not points[0][0] <= np.log(seconds) <= points[-1][0] + 0.1:
        return float("nan")
    x, y = zip(*points, strict=True)
    return float(np.exp(np.interp(np.log(seconds), x, y)))


def slope(rows: Sequence[Row]) -> float:
    """Exponent of relMSE over time from the first second on, by least squares."""
    points = [(np.log(r.seconds), np.log(r.error)) for r in rows if r.error > 0]
    points = [p for p in points if p[0] >= np.log(0.9)] or points
    if len(points) < 2:
        return float("nan")
    x, y = np.array(points).T
    return float(np.polyfit(x, y, 1)[0])
