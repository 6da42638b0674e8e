"""Small plots and contact sheets for docs/accuracy.md; the same bytes for the same numbers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib import pyplot as plt
from PIL import Image as PilImage

from tests.parity import runner

matplotlib.use("Agg")
#: Scenes in a row of a contact sheet, magnification, gap in pixels.
COLUMNS, ZOOM, GAP = 5, 2, 4
SIDE = 40


def save(figure: Any, path: Path) -> None:
    """Write without the date and versions that would change the bytes."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=80, bbox_inches="tight", metadata={"Software": None})
    plt.close(figure)


def shown(image: Any, exposure: float) -> Any:
    """Linear (h, w, 3) as bytes."""
    x = np.clip(image * exposure, 0.0, 1.0)
    srgb = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return np.uint8(np.round(255 * srgb))


def contact_sheet(folder: Path, names: Sequence[str], path: Path) -> None:
    """Ours, Cycles and ten times the difference of every scene, in the order of ``names``."""
    cells = []
    for name in names:
        _, images = runner.load(folder, name)
        cell = np.full((SIDE, 3 * SIDE, 3), 64, np.uint8)
        if "cycles" in images:
            ours, theirs = images["ours"].mean(axis=0), images["cycles"].mean(axis=0)
            scale = 0.9 / max(np.percentile(theirs, 98.0), 1e-9)
            difference = np.clip(0.5 + 10.0 * (ours - theirs) * scale, 0.0, 1.0)
            trio = (shown(ours, scale), shown(theirs, scale), np.uint8(255 * difference))
            for i, one in enumerate(trio):
                cell[: one.shape[0], i * SIDE : i * SIDE + one.shape[1]] = one
        cells.append(np.pad(cell, ((0, GAP), (0, GAP), (0, 0)), constant_values=255))
    while len(cells) % COLUMNS:
        cells.append(np.full_like(cells[0], 255))
    rows = [np.hstack(cells[i : i + COLUMNS]) for i in range(0, len(cells), COLUMNS)]
    sheet = np.vstack(rows).repeat(ZOOM, axis=0).repeat(ZOOM, axis=1)
    path.parent.mkdir(parents=True, exist_ok=True)
    PilImage.fromarray(sheet).quantize(192, dither=PilImage.Dither.NONE).save(
        path, optimize=True
    )


def means(runs: Sequence[Any], path: Path) -> None:
    """Difference of the mean of every scene with its standard error, one series a Blender."""
    figure, axes = plt.subplots(figsize=(9.0, 3.0))
    for number, one in enumerate(runs):
        verdicts = [v for v in one.verdicts.values() if v.state in ("pass", "fail", "noisy")]
        worst = [100 * max(v.difference, key=abs) for v in verdicts]
        errors = [200 * v.error for v in verdicts]
        x = np.arange(len(verdicts)) + 0.3 * number
        axes.errorbar(
            x, np.clip(worst, -1.5, 1.5), errors, fmt=".", ms=4, lw=0.8,
            label=f"Blender {one.blender}",
        )  # fmt: skip
    for limit in (-0.5, 0.5):
        axes.axhline(limit, color="0.5", lw=0.8, ls="--")
    axes.set_ylim(-1.6, 1.6)
    axes.set_xlabel("scene, in the order of the tables (supported ones)")
    axes.set_ylabel("difference of the mean [%], 2 SE")
    axes.legend(loc="upper right", fontsize=8)
    save(figure, path)


def errors(rows: dict[str, Sequence[Any]], path: Path) -> None:
    """Relative RMS error of each closed-form caustic against the photons emitted."""
    figure, axes = plt.subplots(figsize=(6.5, 4.0))
    for name, results in rows.items():
        axes.loglog(
            [r.photons for r in results],
            [r.error for r in results],
            "o-",
            ms=3,
            lw=1,
            label=name,
        )
    axes.set_xlabel("photons emitted")
    axes.set_ylabel("relative RMS error against the closed form")
    axes.legend(fontsize=7)
    axes.grid(alpha=0.3)
    save(figure, path)


def pair(result: Any, title: str, path: Path) -> None:
    """A caustic as rendered, its closed form, and the profile along the middle row."""
    figure, axes = plt.subplots(1, 3, figsize=(9.0, 2.6))
    top = np.nanpercentile(result.expected, 99.0)
    for ax, picture, name in zip(
        axes, (result.found, result.expected), ("rendered", "closed form"), strict=False
    ):
        ax.imshow(picture, cmap="magma", vmin=0.0, vmax=top, origin="lower")
        ax.set_title(f"{title}: {name}", fontsize=8)
        ax.set_axis_off()
    middle = result.found.shape[0] // 2
    axes[2].plot(result.expected[middle], "k-", lw=1, label="closed form")
    axes[2].plot(result.found[middle], ".", ms=4, label="rendered")
    axes[2].set_title("middle row", fontsize=8)
    axes[2].legend(fontsize=7)
    save(figure, path)


def slopes(rows: Sequence[Any], path: Path) -> None:
    """Mean squared error of each layer against passes."""
    figure, axes = plt.subplots(figsize=(6.0, 3.6))
    for row in rows:
        label = f"{row.layer}: {row.slope:.2f}"
        axes.loglog(row.passes, row.mse, "o-", ms=3, lw=1, label=label)
    axes.set_xlabel("passes")
    axes.set_ylabel("mean squared error")
    axes.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    axes.grid(alpha=0.3, which="both")
    save(figure, path)


def roughness(rows: dict[str, Sequence[Any]], path: Path) -> None:
    """Mean against the reference and noise of every sweep, over the roughness."""
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 3.8))
    for name, points in rows.items():
        x = [p.roughness for p in points]
        if points[0].truth == points[0].truth:
            off = [100 * (p.mean / p.truth - 1) for p in points]
            spread = [200 * (p.error**2 + p.truth_error**2) ** 0.5 / p.truth for p in points]
            axes[0].errorbar(x, off, spread, fmt="o-", ms=3, lw=1, capsize=2, label=name)
        axes[1].semilogy(x, [p.noise for p in points], "o-", ms=3, lw=1, label=name)
    axes[0].axhline(0.0, color="0.5", lw=0.8)
    axes[0].set_ylabel("mean against the reference [%], 2 SE")
    axes[1].set_ylabel("relative MSE of one render")
    for ax in axes:
        ax.set_xlabel("roughness")
        ax.grid(alpha=0.3, which="both")
        ax.legend(fontsize=7)
    save(figure, path)
