"""The long accuracy run: writes docs/accuracy.md and its pictures.

    python benchmarks/accuracy.py [--python OTHER_PYTHON ...] [--only PART ...]

With ``--keep`` a run goes on where an earlier one was stopped. PART: parity, caustics,
convergence, roughness, stability. ``--python`` adds a Python with another bpy to the parity
suite; one that is not there is named in the document. Needs the ``dev``, ``cli`` and
``blender`` extras. The document has no times or dates: the same code and wheels write the
same text.
"""

from __future__ import annotations

import argparse
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import accuracy_closed  # noqa: E402
import accuracy_parity  # noqa: E402
import accuracy_roughness  # noqa: E402

from tests.parity.cases import CASES  # noqa: E402

PARTS = ("parity", "caustics", "convergence", "roughness", "stability")
BROKEN = "This part did not run to its end"
TEXT = Path(__file__).with_name("accuracy_text.md")


def main() -> None:
    """Run the parts and write the document."""
    args = arguments()
    pictures = args.docs / "accuracy"
    pictures.mkdir(parents=True, exist_ok=True)
    if args.work.is_dir() and not args.keep:
        shutil.rmtree(args.work)
    lines = [*head(args)]
    for part in args.only:
        lines += section(part, args, pictures)
    (args.docs / "accuracy.md").write_text("\n".join(lines).rstrip() + "\n", "utf-8")


def section(part: str, args: argparse.Namespace, pictures: Path) -> list[str]:
    """The lines of one part; kept in ``--work``, from where ``--keep`` takes them."""
    kept = args.work / f"{part}.md"
    if args.keep and kept.is_file():
        return kept.read_text("utf-8").split("\n")
    started = time.perf_counter()
    lines = list(run(part, args, pictures))
    print(f"{part}: {time.perf_counter() - started:.0f} s", file=sys.stderr, flush=True)
    if not any(BROKEN in line for line in lines):
        args.work.mkdir(parents=True, exist_ok=True)
        kept.write_text("\n".join(lines), "utf-8")
    return lines


def run(part: str, args: argparse.Namespace, pictures: Path) -> Iterator[str]:
    """The lines of one part; one that breaks is written down as broken."""
    try:
        if part == "parity":
            pythons = [sys.executable, *(p for p in args.python if runs(p))]
            names = args.scenes or list(CASES)
            results = [
                accuracy_parity.run(python, args.work / f"parity{i}", names)
                for i, python in enumerate(pythons)
            ]
            yield from list(accuracy_parity.section(results, pictures))
        elif part == "caustics":
            yield from list(accuracy_closed.caustics(pictures))
        elif part == "convergence":
            yield from list(accuracy_closed.convergence(pictures))
        elif part == "roughness":
            yield from list(accuracy_roughness.roughness(pictures))
        else:
            yield from list(accuracy_closed.stability())
    except Exception as error:
        yield f"## {part.capitalize()}"
        yield ""
        yield f"**{BROKEN}:** {type(error).__name__}: {error}"
        yield ""
        print(f"{part}: {error!r}", file=sys.stderr, flush=True)


def runs(python: str) -> bool:
    """Whether ``python`` is there and has bpy."""
    command = [python, "-c", "import importlib.util as u; assert u.find_spec('bpy')"]
    try:
        return subprocess.run(command, capture_output=True, timeout=60).returncode == 0
    except OSError:
        return False


def head(args: argparse.Namespace) -> Iterator[str]:
    """Title, versions, and what was left out."""
    yield "# How accurate it is"
    yield ""
    yield "Written by `make accuracy` (`benchmarks/accuracy.py`); do not edit by hand."
    yield ""
    names = ("numpy", "numba", "embreex", "scipy")
    shown = ", ".join(f"{name} {version(name)}" for name in names)
    yield f"Python {platform.python_version()}, {shown}. All seeds are fixed."
    yield ""
    missing = [p for p in args.python if not runs(p)]
    if missing and "parity" in args.only:
        yield "Only one Blender was at hand: " + ", ".join(Path(p).name for p in missing)
        yield "is not there or has no `bpy`."
        yield ""
    left_out = [part for part in PARTS if part not in args.only]
    if left_out:
        yield f"Left out of this run: {', '.join(left_out)}."
        yield ""
    if args.note:
        yield f"**{args.note}**"
        yield ""
    yield TEXT.read_text("utf-8")


def arguments() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description="The long accuracy run.")
    parser.add_argument("--python", action="append", default=[], help="another Python with bpy")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--scenes", nargs="+", choices=list(CASES), metavar="SCENE")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs")
    parser.add_argument("--work", type=Path, default=ROOT / "renders" / "accuracy")
    parser.add_argument("--note", default="", help="a line about this run for the head")
    parser.add_argument(
        "--keep", action="store_true", help="take parts and scenes of an earlier run"
    )
    return parser.parse_args()


if __name__ == "__main__":
    main()
