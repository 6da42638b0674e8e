"""The sweep of roughness in docs/accuracy.md: means against the reference, and noise."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import accuracy_pictures as pictures

PASSES, SEEDS, SAMPLES = 8, 8, 6000

TEXT = """\
Between a mirror and a diffuse surface the engine hands over from caustic photons and chains of
rays to the global photon map and final gathering. {passes} passes, {seeds} seeds, 16x16
pixels, the roughness as Blender shows it (`tests/roughness`). First the difference of the
image's mean from `core/reference` in percent, with the standard error of both; for
Principled, which the reference does not know, the distance of the mean from the cubic through
its four neighbours in the square root of the roughness. Then the noise: the relative mean
squared error of one render. An island would be a roughness whose squared error is far above
the least on both sides: what is listed is the most that any point is.
"""


def roughness(folder: Path) -> Iterator[str]:
    """Tables of means and noise by roughness, the verdicts, and a plot."""
    from photon_map.tests.roughness.judge import farthest, island, roughest_jump
    from photon_map.tests.roughness.sweep import ROUGHNESS, SWEEPS, Point, measure

    yield "## No cliff between smooth and rough"
    yield ""
    yield TEXT.format(passes=PASSES, seeds=SEEDS)
    rows: dict[str, list[Point]] = {
        name: [measure(sweep, r, PASSES, SEEDS, SAMPLES) for r in ROUGHNESS]
        for name, sweep in SWEEPS.items()
    }
    yield from table("difference [%]", rows, difference)
    yield from table("noise", rows, lambda points, i: f"{points[i].noise:.2g}")
    yield "| scene | what | farthest [%] | z beyond 1 % | largest jump [%] | island of noise |"
    yield "|---|---|---|---|---|---|"
    for name, points in rows.items():
        jump, _ = roughest_jump(points)
        off = z = "no reference"
        if SWEEPS[name].reference:
            worst, most = farthest(points)
            off, z = f"{100 * worst.value:+.2f} at {worst.roughness:g}", f"{most:.1f}"
        top = island(points)
        yield (
            f"| {name} | {SWEEPS[name].says} | {off} | {z} "
            f"| {100 * jump.value:+.2f} at {jump.roughness:g} "
            f"| x{max(1.0, top.value):.1f} at {top.roughness:g} |"
        )
    pictures.roughness(rows, folder / "roughness.png")
    yield ""
    yield f"![mean and noise over the roughness]({folder.name}/roughness.png)"
    yield ""


def difference(points: Sequence, i: int) -> str:
    """Distance of point ``i`` from the reference or from its neighbours' curve, in percent."""
    from photon_map.tests.roughness.judge import between

    point = points[i]
    if point.truth == point.truth:
        error = (point.error**2 + point.truth_error**2) ** 0.5 / point.truth
        return f"{100 * (point.mean / point.truth - 1):+.2f} ± {100 * error:.2f}"
    if not 2 <= i < len(points) - 2:
        return ""
    off, error = between(points, i)
    return f"{100 * off / point.mean:+.2f} ± {100 * error / point.mean:.2f}"


def table(title: str, rows: dict, cell) -> Iterator[str]:
    """One row a roughness, one column a sweep."""
    count = len(next(iter(rows.values())))
    yield f"| {title} | " + " | ".join(rows) + " |"
    yield "|---" * (1 + len(rows)) + "|"
    for i in range(count):
        first = next(iter(rows.values()))[i].roughness
        yield f"| {first:g} | " + " | ".join(cell(points, i) for points in rows.values()) + " |"
    yield ""
