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
from typing import NamedTuple

import numpy as np
from measure import Image
from speed_error import Measured, Reference

WORKER = Path(__file__).with_name("speed_worker.py")
#: Longest time a render may take beyond its last image: the first compiles our kernels [s].
PATIENCE = 420.0
#: When images are looked at, about [s].
TIMES = (0.25, 0.5, 1.0, 2.0, 3.5, 5.0, 8.0, 12.0, 20.0, 30.0)


#: A measured relMSE is known when its standard error is at most this part of it; above that
#: only what lies so many standard errors away is told from it.
KNOWN, SURE = 0.15, 2.0


@dataclass(frozen=True)
class Row:
    """One image. ``error``: relMSE, the reference's own noise taken off, ``deviation`` its
    standard error; ``mean``: the image's mean over the reference's; ``embree``: share of
    the processor's time in ray queries. ``passes``, and how wrong the engine says that the
    image is (roots of relMSE), are known of Photon Map alone."""

    scene: str
    engine: str
    seconds: float
    error: float
    deviation: float
    mean: float
    start_up: float
    peak_mb: float
    version: str
    load: float
    passes: int = 0
    stated: float = float("nan")
    noise: float = float("nan")
    bias: float = float("nan")
    embree: float = float("nan")

    @property
    def is_known(self) -> bool:
        """Whether the reference leaves no more than ``KNOWN`` of doubt."""
        return self.deviation <= KNOWN * self.error

    @property
    def most(self) -> float:
        """What the error is surely below."""
        return max(self.error, 0.0) + SURE * self.deviation


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
        told = json.loads(str(kept["told"]))
    rows = []
    for spent, image, more in zip(seconds, images, told, strict=True):
        error, deviation = reference.error(image)
        mean = float(image.mean() / reference.image.mean())
        rows.append(
            Row(
                scene, engine, float(spent), error, deviation, mean, facts["start_up"],
                facts["peak_mb"], facts["engine"], facts["load"], **more,
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


class Crossing(NamedTuple):
    """When a curve comes to an error: ``seconds`` [s], inf if not within the curve, an upper
    bound if ``below``; NaN when the reference is too noisy to say."""

    seconds: float
    below: bool = False


def time_to(rows: Sequence[Row], goal: float) -> Crossing:
    """When relMSE falls to ``goal``, on the straight lines between points in the logarithms.

    The crossing from which on the curve stays below counts; the first point's time is an
    upper bound when it is below already. Where the doubt that the reference leaves is
    above ``KNOWN`` of the goal, the first point from which on all are surely below it is a
    bound too.
    """
    if not rows:
        return Crossing(float("inf"))
    above = [i for i, row in enumerate(rows) if row.error > goal]
    near = rows[above[-1]] if above else rows[0]
    last = above[-1] if above else -1
    around = rows[max(0, last) : last + 2]
    if any(row.deviation > KNOWN * goal and abs(row.error - goal) < SURE * row.deviation
           for row in around):  # fmt: skip
        doubtful = [i for i, row in enumerate(rows) if row.most > goal]
        first = doubtful[-1] + 1 if doubtful else 0
        if first < len(rows):
            return Crossing(rows[first].seconds, below=True)
        return Crossing(float("nan"))
    if last == len(rows) - 1:
        return Crossing(float("inf"))
    if last < 0:
        return Crossing(near.seconds, below=True)
    a, b = rows[last], rows[last + 1]
    low = max(b.error, 1e-9)
    part = np.log(a.error / goal) / np.log(a.error / low)
    return Crossing(float(a.seconds * (b.seconds / a.seconds) ** part))


def error_at(rows: Sequence[Row], seconds: float) -> Measured:
    """relMSE after ``seconds``, interpolated likewise, and its standard error.

    NaN outside of the curve.
    """
    if not rows or not rows[0].seconds <= seconds <= 1.1 * rows[-1].seconds:
        return Measured(float("nan"), float("nan"))
    times = np.log([r.seconds for r in rows])
    k = int(np.clip(np.searchsorted(times, np.log(seconds)), 1, len(rows) - 1))
    a, b = rows[max(0, k - 1)], rows[k] if len(rows) > 1 else rows[0]
    span = np.log(b.seconds / a.seconds)
    part = float(np.clip(np.log(seconds / a.seconds) / span, 0.0, 1.0)) if span > 0 else 0.0
    deviation = (1 - part) * a.deviation + part * b.deviation
    if a.error <= 0 or b.error <= 0:
        return Measured((1 - part) * a.error + part * b.error, deviation)
    return Measured(float(np.exp(
        (1 - part) * np.log(a.error) + part * np.log(b.error)
    )), deviation)  # fmt: skip


def slope(rows: Sequence[Row]) -> float:
    """Exponent of relMSE over time from the first second on, by least squares.

    Only points whose error is known count; NaN where they do not span a factor of two.
    """
    points = [(np.log(r.seconds), np.log(r.error)) for r in rows if r.error > 0 and r.is_known]
    points = [p for p in points if p[0] >= np.log(0.9)] or points
    if len(points) < 2 or points[-1][0] - points[0][0] < np.log(2.0):
        return float("nan")
    x, y = np.array(points).T
    return float(np.polyfit(x, y, 1)[0])
