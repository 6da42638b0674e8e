"""Error-over-time plots and equal-time strips."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from measure import Image
from PIL import Image as Picture
from speed_cases import CASES
from speed_error import Reference
from speed_run import Run

#: Seconds of rendering of the pictures in the strips.
AT = 5.0
STRIPS = (
    f"Each row one scene: the reference, Photon Map, then its peers in the order of the table "
    f"above, after about {AT:g} s of rendering."
)
COLORS = {
    "photonmap": "black", "mitsuba": "tab:green", "cycles": "tab:orange",
    "luxcore_path": "tab:cyan", "luxcore_bidir": "tab:pink", "luxcore_vm": "tab:blue",
    "povray": "tab:red",
}  # fmt: skip


def curves(
    path: Path, curves: Mapping[str, Mapping[str, Run]], names: Mapping[str, str]
) -> None:
    """One small plot per scene, logarithmic in both."""
    columns = 4
    rows = -(-len(curves) // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(3.1 * columns, 2.7 * rows), squeeze=False, sharex=True
    )
    shown: dict[str, object] = {}
    for axis, (scene, engines) in zip(axes.flat, curves.items(), strict=False):
        for engine, run in engines.items():
            points = [(r.seconds, r.error) for r in run.rows if r.error > 0]
            if points:
                width = 2.0 if engine == "photonmap" else 1.2
                line = axis.loglog(
                    *zip(*points, strict=True), color=COLORS.get(engine), linewidth=width,
                    marker=".", markersize=3,
                )  # fmt: skip
                shown[names[engine]] = line[0]
        for goal in (0.01, 0.0025, 0.0004):
            axis.axhline(goal, color="0.8", linewidth=0.6, zorder=0)
        axis.set_title(CASES[scene].title, fontsize=9)
        axis.tick_params(labelsize=7)
        axis.set_xlim(0.2, 36.0)
        axis.grid(True, which="major", color="0.93", linewidth=0.5)
    for axis in axes.flat[len(curves) :]:
        axis.axis("off")
    for axis in axes[-1]:
        axis.set_xlabel("seconds of rendering", fontsize=8)
    for axis in axes[:, 0]:
        axis.set_ylabel("relMSE", fontsize=8)
    figure.legend(
        list(shown.values()), list(shown), loc="lower center", ncol=6, fontsize=8, frameon=False
    )
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.savefig(path, dpi=90)
    plt.close(figure)


def strips(
    path: Path,
    curves: Mapping[str, Mapping[str, Run]],
    references: Mapping[str, Reference],
    names: Mapping[str, str],
) -> None:
    """Rows of pictures after the same time."""
    rows = []
    most = 1 + max(len(engines) for engines in curves.values())
    for scene, engines in curves.items():
        reference = references[scene].image
        white = float(np.quantile(reference, 0.97))
        tiles = [shown(reference, white)]
        for run in engines.values():
            image = image_at(run, AT)
            tiles.append(shown(np.zeros_like(reference) if image is None else image, white))
        blank = np.full_like(tiles[0], 255)
        tiles += [blank] * (most - len(tiles))
        rows.append(np.hstack(tiles))
    Picture.fromarray(np.vstack(rows)).quantize(256).save(path, optimize=True)


def image_at(run: Run, seconds: float) -> Image | None:
    """The first image after that time, else the last there is."""
    later = [i for i, s in enumerate(run.seconds) if s >= 0.98 * seconds]
    if not run.images:
        return None
    return run.images[later[0] if later else -1]


def shown(image: Image, white: float) -> np.ndarray:
    """Bytes for the screen; ``white`` is the radiance of white."""
    clipped = np.clip(np.nan_to_num(image) / white, 0.0, 1.0)
    return (255 * clipped ** (1 / 2.2) + 0.5).astype(np.uint8)
