"""The parity suite's part of docs/accuracy.md: both engines, each Blender at hand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import accuracy_pictures as pictures

from tests.parity import compare, protocol, runner
from tests.parity.cases import CASES, GROUPS
from tests.parity.compare import Verdict

WORDS = {
    "pass": "pass",
    "fail": "**FAILED**",
    "noisy": "**too noisy to tell**",
    "unsupported": "not supported yet",
    "differs": "Cycles differs",
    "error": "**ERROR**",
}


@dataclass(frozen=True)
class Run:
    """The verdicts of one Blender by scene; ``folder`` keeps the images."""

    blender: str
    folder: Path
    verdicts: dict[str, Verdict]


def run(python: str, folder: Path, names: Sequence[str]) -> Run:
    """Render and judge ``names`` with the Blender of ``python``."""
    runner.render(names, folder, python)
    facts = [runner.load(folder, name)[0] for name in names]
    versions = {fact["blender"] for fact in facts if "blender" in fact}
    verdicts = {name: runner.judge(folder, name) for name in names}
    return Run(" or ".join(sorted(versions)) or "?", folder, verdicts)


def section(runs: Sequence[Run], folder: Path) -> Iterator[str]:
    """Markdown lines; pictures go into ``folder``."""
    yield "## Parity with Cycles"
    yield ""
    yield METHOD.format(
        seeds=protocol.SEEDS, rounds=protocol.ROUNDS,
        enough=100 * protocol.ENOUGH, mean=100 * compare.MEAN,
        level=compare.LEVEL, block=compare.BLOCK, bias=100 * compare.PHOTON_BIAS,
        rounding=100 * compare.ROUNDING,
    )  # fmt: skip
    yield from counts(runs)
    missing = [name for name in CASES if name not in runs[0].verdicts]
    if missing:
        yield f"Not rendered in this run: {', '.join(missing)}."
        yield ""
    for group, cases in GROUPS.items():
        names = [name for name in cases if name in runs[0].verdicts]
        if not names:
            continue
        sheet = f"parity_{group.split()[-1]}.png"
        pictures.contact_sheet(runs[0].folder, names, folder / sheet)
        yield f"### {group[0].upper() + group[1:]}"
        yield ""
        yield f"![{group}: ours, Cycles, difference]({folder.name}/{sheet})"
        yield ""
        yield from table(names, runs)
    plot = "parity_means.png"
    pictures.means(runs, folder / plot)
    yield f"![difference of the mean of every scene]({folder.name}/{plot})"
    yield ""
    yield from reasons(runs)


METHOD = """\
Each scene is a variation of one option, built by code (`tests/parity/scenes_*.py`), 32x32
pixels, box filter of 1 pixel, 32 bounces, without denoising, clamping or light thresholds,
caustics on. Both engines render {seeds} independent seeds, and {seeds} more up to {rounds}
times, until the standard error of the image's mean is below {enough:g} %. A scene passes when

- the image's mean differs by at most {mean:g} % in every channel (a channel below a tenth of
  the brightest one is held to {mean:g} % of that tenth);
- no {block}x{block}-pixel block differs, by Welch's t-test over the seeds, Holm-corrected over
  the blocks and channels, at a level of {level:g} a scene. Allowed besides: {rounding:g} % of
  the image's mean for tables and float32, and {bias:g} % of the light that photon maps gave to
  the block, because a gather radius that is not zero yet biases it (it shrinks from pass to
  pass; the convergence section shows how);
- the standard error is below a third of the allowed difference, or the row says so.

"difference" is ours / Cycles - 1 of the image's mean, the channel that is off most, with the
standard error; "z" the worst block beyond what is allowed; "photons" the share of light by
photon maps. In the pictures: ours, Cycles, and the difference times 10 around grey.
"""


def counts(runs: Sequence[Run]) -> Iterator[str]:
    """How many scenes are in which state."""
    yield "| Blender | scenes | " + " | ".join(WORDS.values()) + " |"
    yield "|---" * (2 + len(WORDS)) + "|"
    for one in runs:
        states = [v.state for v in one.verdicts.values()]
        cells = " | ".join(str(states.count(state)) for state in WORDS)
        yield f"| {one.blender} | {len(states)} | {cells} |"
    yield ""


def table(names: Sequence[str], runs: Sequence[Run]) -> Iterator[str]:
    """One row a scene, three columns a Blender."""
    head = "".join(f" {one.blender} | difference [%] | z |" for one in runs)
    yield f"| scene | what | photons |{head}"
    yield "|---" * (3 + 3 * len(runs)) + "|"
    for name in names:
        cells = "".join(cell(one.verdicts[name]) for one in runs)
        photons = runs[0].verdicts[name].photons
        yield f"| {name} | {CASES[name].says} | {photons:.2f} |{cells}"
    yield ""


def cell(verdict: Verdict) -> str:
    """State, difference and z of one verdict."""
    if verdict.state == "error":
        return f" {WORDS['error']} | | |"
    worst = max(verdict.difference, key=abs)
    numbers = f"{100 * worst:+.2f} ± {100 * verdict.error:.2f} | {verdict.z:.1f}"
    return f" {WORDS[verdict.state]} | {numbers} |"


def reasons(runs: Sequence[Run]) -> Iterator[str]:
    """Why scenes did not pass."""
    lines: dict[str, list[str]] = {}
    for one in runs:
        for name, verdict in one.verdicts.items():
            if verdict.state != "pass":
                text = f"**{name}** ({WORDS[verdict.state].strip('*')}): {verdict.why}"
                lines.setdefault(text, []).append(one.blender)
    yield "### Scenes that are no plain pass, and why"
    yield ""
    for text, versions in lines.items():
        yield f"- {text} [{', '.join(versions)}]"
    if not lines:
        yield "None."
    yield ""
