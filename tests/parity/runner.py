"""Runs the suite's workers with a time limit and judges what they leave."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tests.parity.case import Case
from tests.parity.cases import CASES
from tests.parity.compare import MEAN, Verdict, compare
from tests.parity.protocol import PULSE

ROOT = Path(__file__).resolve().parents[2]
#: Longest silence of a worker [s]: one image, or one kernel being compiled.
TIMEOUT = 400.0
#: How often a worker is looked at [s].
LOOK = 1.0
ENGINES = ("ours", "cycles")


def render(
    names: Sequence[str], out: Path, python: str = sys.executable, timeout: float = TIMEOUT
) -> None:
    """Render scenes into ``out``; a scene that hangs or crashes Blender leaves no file."""
    out.mkdir(parents=True, exist_ok=True)
    left = [name for name in names if not (out / f"{name}.npz").is_file()]
    while left:
        work(left, out, python, timeout)
        left = [name for name in left if not (out / f"{name}.npz").is_file()]
        if left:  # the first one ended or blocked the process
            write_error(out, left.pop(0), "Blender crashed or did not end in time")


def work(names: Sequence[str], out: Path, python: str, timeout: float) -> None:
    """One worker, ended when its pulse has been still for ``timeout`` seconds."""
    command = [python, "-m", "tests.parity.worker", str(out), *names]
    pulse = out / PULSE
    pulse.touch()
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "BLENDER_USER_RESOURCES": folder}
        with (
            open(out / "worker.log", "a") as log,
            subprocess.Popen(
                command, cwd=ROOT, env=environment, stdout=log, stderr=log
            ) as process,
        ):
            while time.time() - pulse.stat().st_mtime < timeout:
                try:
                    process.wait(LOOK)
                    break
                except subprocess.TimeoutExpired:
                    continue
            process.kill()


def write_error(out: Path, name: str, text: str) -> None:
    """Leave a file of a scene that was not rendered."""
    with open(out / f"{name}.npz", "wb") as file:
        np.savez(file, facts=json.dumps({"error": text}))


def load(out: Path, name: str) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Facts and images of one scene."""
    with np.load(out / f"{name}.npz") as kept:
        images = {key: np.float64(kept[key]) for key in kept if key != "facts"}
        return json.loads(str(kept["facts"])), images


def judge(out: Path, name: str) -> Verdict:
    """The verdict on a scene that was rendered into ``out``."""
    facts, images = load(out, name)
    case: Case = CASES[name]
    if facts["error"]:
        return Verdict("error", why=facts["error"].strip().splitlines()[-1])
    verdict = compare(images["ours"], images["cycles"], images["photons"])
    missing = [w for w in facts["warnings"] if not any(fine in w for fine in case.fine)]
    if missing:
        return Verdict(**{**vars(verdict), "state": "unsupported", "why": "; ".join(missing)})
    if case.truth is not None:
        return against_truth(case, verdict, images, case.truth())
    slight = all(-MEAN <= d <= MEAN + case.loses for d in verdict.difference)
    if verdict.state == "fail" and case.deviation and slight:
        why = f"{verdict.why}: {case.deviation}"
        return Verdict(**{**vars(verdict), "state": "differs", "why": why})
    return verdict


def against_truth(
    case: Case, verdict: Verdict, images: dict[str, np.ndarray], truth: Any
) -> Verdict:
    """Where Cycles is not the judge: ours has to meet the true mean."""
    ours, theirs = (images[name].mean(axis=(0, 1, 2)) / truth - 1 for name in ENGINES)
    means = " ".join(f"{x:.4f}" for x in np.ravel(truth))
    why = (
        f"closed form {means}, ours {100 * np.abs(ours).max():.2f} % off, Cycles "
        f"{100 * np.abs(theirs).max():.2f} %: {case.deviation}"
    )
    state = "differs" if np.abs(ours).max() <= MEAN else "fail"
    return Verdict(**{**vars(verdict), "state": state, "why": why})


def main() -> None:
    """Render and judge scenes: ``python -m tests.parity.runner OUT [NAME...]``."""
    out = Path(sys.argv[1])
    names = sys.argv[2:] or list(CASES)
    render(names, out)
    for name in names:
        v = judge(out, name)
        d = " ".join(f"{100 * x:+.3f}" for x in v.difference)
        facts, images = load(out, name)
        spent = [facts.get(f"{e}_seconds", 0.0) for e in ENGINES]
        seeds = [len(images.get(e, ())) for e in ENGINES]
        sys.stdout.write(
            f"{name:28} {v.state:12} {d} +- {100 * v.error:.3f} z {v.z:.1f} p {v.p:.2g} "
            f"ph {v.photons:.2f} s {spent[0]:.1f} {spent[1]:.1f} n {seeds} {v.why}\n"
        )


if __name__ == "__main__":
    main()
