"""Figures of docs/search.md, shadow_photons.md and baking.md, of numbers that were measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

PICTURES = Path(__file__).parents[1] / "docs" / "pictures"
#: What happened to a pixel's shadow ray: none was due, asked, saved as lit or dark, wrong.
NONE, ASKED, LIT, DARK, WRONG = range(5)
SHADES = ("#202028", "#e0b040", "#f4f4ee", "#5878a8", "#e02020")
MEANINGS = ("no light", "asked", "lit, saved", "dark, saved", "wrong")


class Search(NamedTuple):
    """One row of the comparison of searches: seconds for building, microseconds a query."""

    count: int
    wanted: int
    radius: float
    grid_build: float
    grid: float
    tree_build: float
    tree_radius: float
    tree_count: float


def save(figure: Figure, name: str) -> None:
    """Write docs/pictures/NAME.png without what would change its bytes."""
    figure.savefig(PICTURES / f"{name}.png", dpi=90, metadata={"Software": None})


def draw_search(rows: Sequence[Search]) -> None:
    """Time of building and asking over the number of photons, and over the radius."""
    figure = Figure(figsize=(9.0, 2.8), layout="constrained")
    build, ask, wide = figure.subplots(1, 3)
    counts = sorted({row.count for row in rows})
    for name, column, shade in (("grid", "grid_build", "C0"), ("tree", "tree_build", "C1")):
        times = [np.mean([getattr(r, column) for r in rows if r.count == c]) for c in counts]
        build.loglog(counts, np.multiply(times, 1e3), "o-", color=shade, label=name)
    kinds = (
        ("grid", "grid", "C0"), ("tree, by radius", "tree_radius", "C1"),
        ("tree, by count", "tree_count", "C2"),
    )  # fmt: skip
    for name, column, shade in kinds:
        some = [row for row in rows if row.wanted == 50]
        ask.loglog(
            [r.count for r in some], [getattr(r, column) for r in some], "o-", color=shade,
            label=name,
        )  # fmt: skip
        some = [row for row in rows if row.count == counts[-1]]
        wide.loglog(
            [r.radius for r in some], [getattr(r, column) for r in some], "o-", color=shade
        )
    build.set(xlabel="photons", ylabel="built [ms]")
    ask.set(xlabel="photons, 50 in the disc", ylabel="asked [us]")
    for axis in (ask, wide):
        plain_ticks(axis.yaxis, (1, 2, 5, 10, 20, 50))
    plain_ticks(wide.xaxis, (0.01, 0.02, 0.04))
    number = f"{counts[-1]:,}".replace(",", " ")
    wide.set(xlabel=f"radius [m], {number} photons")
    build.legend(fontsize=7)
    ask.legend(fontsize=7)
    save(figure, "photon_search")


def plain_ticks(axis: Any, places: Sequence[float]) -> None:
    """Numbers as people write them along a logarithmic ``axis``."""
    axis.set_ticks(places, [f"{place:g}" for place in places])
    axis.set_ticks([], minor=True)


def draw_culling(rows: Mapping[int, tuple[float, float, float]]) -> None:
    """Nanoseconds a ray of Embree alone, of spheres, of Embree behind them, by bodies."""
    figure = Figure(figsize=(4.5, 2.6), layout="constrained")
    axis = figure.subplots()
    places = np.arange(len(rows))
    alone, spheres, rest = np.array(list(rows.values())).T
    axis.bar(places - 0.2, alone, 0.36, label="Embree alone", color="C0")
    axis.bar(places + 0.2, spheres, 0.36, label="spheres", color="C1")
    axis.bar(places + 0.2, rest, 0.36, bottom=spheres, label="Embree behind them", color="C2")
    axis.set_xticks(places, [f"{bodies} bodies" if bodies > 1 else "1 body" for bodies in rows])
    axis.set(ylabel="ns a ray")
    axis.legend(fontsize=7)
    save(figure, "bounding_spheres")


def draw_verdicts(maps: Mapping[str, NDArray[np.int8]]) -> None:
    """What shadow photons decide, pixel by pixel (h, w) of ``ASKED`` and so on."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    figure = Figure(figsize=(9.0, 2.9), layout="constrained")
    shades: Any = ListedColormap(SHADES)
    for axis, (name, picture) in zip(figure.subplots(1, len(maps)), maps.items(), strict=True):
        axis.imshow(
            picture, origin="lower", cmap=shades, vmin=-0.5, vmax=4.5, interpolation="nearest"
        )
        axis.set_title(name, fontsize=8)
        axis.set(xticks=[], yticks=[])
    patches = [
        Patch(facecolor=shade, edgecolor="0.5", label=name)
        for shade, name in zip(SHADES, MEANINGS, strict=True)
    ]
    figure.legend(handles=patches, loc="outside lower center", ncols=5, fontsize=8)
    save(figure, "shadow_photons")


def draw_flicker(
    frame: NDArray[np.float64], traced: NDArray[np.float64], baked: NDArray[np.float64]
) -> None:
    """A place's caustic in the mean, and how far it moves in time, (h, w) each."""
    figure = Figure(figsize=(8.0, 3.0), layout="constrained")
    axes = figure.subplots(1, 3)
    top = float(np.nanpercentile(frame, 99.5))
    worst = float(np.nanpercentile(traced, 99.5))
    for axis, picture, name, most, shades in zip(
        axes,
        (frame, traced, baked),
        ("baked, mean of 24 frames", "deviation in time, traced", "the same, baked"),
        (top, worst, worst),
        ("gray", "magma", "magma"),
        strict=True,
    ):
        shown = axis.imshow(picture, origin="lower", cmap=shades, vmin=0.0, vmax=most)
        axis.set_title(name, fontsize=9)
        axis.set(xticks=[], yticks=[])
        figure.colorbar(shown, ax=axis, shrink=0.7)
    save(figure, "baked_maps")
