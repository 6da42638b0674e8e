"""What `make cycles` refuses, and how it looks at memory."""

from __future__ import annotations

import importlib
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

TOOLS = Path(__file__).parents[1] / "tools"
ADDON = Path(__file__).parents[1] / "addon"
WAYS = ("escape", "twice", "undo", "load", "whole")


@pytest.fixture
def cycles(monkeypatch: pytest.MonkeyPatch) -> Any:
    """``tools/cycles_test.py``, which is no package."""
    monkeypatch.syspath_prepend(str(TOOLS))
    return importlib.import_module("cycles_test")


def found(cycles: Any, kept: float, first: float = 20.0, scatter: float = 4.0) -> Any:
    """Fifty cycles, each cancelled one of which keeps ``kept`` MB.

    The first ones load kernels; files and threads make one more or less than the next.
    """
    rng, entries, memory = random.Random(1), [], 1100.0
    for k in range(cycles.CYCLES):
        way = WAYS[k % len(WAYS)]
        memory += first / (k + 1) + (way != "whole") * kept
        entries.append(
            {"way": way, "seconds": 0.1, "left": 0.1, "load": 1.0, "threads": 12,
             "memory": rng.gauss(memory, scatter)}
        )  # fmt: skip
    return {"cycles": entries, "different": 0.0, "viewport": {"contrast": 0.2}}


def test_two_megabytes_kept_by_each_cancelled_render_are_refused(cycles: Any) -> None:
    from acceptance import AcceptanceError  # type: ignore[import-not-found]

    control = found(cycles, 0.0)
    cycles.judge(found(cycles, 0.0), control)
    with pytest.raises(AcceptanceError, match="memory grew by .* MB, with Cycles by"):
        cycles.judge(found(cycles, 2.0), control)


def test_growth_is_judged_beyond_that_of_cycles(cycles: Any) -> None:
    """A control that gives memory back makes the rule no stricter."""
    from acceptance import AcceptanceError

    cycles.judge(found(cycles, 0.2), found(cycles, -1.0))
    cycles.judge(found(cycles, 1.2), found(cycles, 1.0))
    with pytest.raises(AcceptanceError):
        cycles.judge(found(cycles, 3.0), found(cycles, 1.0))


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nobody is asked")
def test_memory_that_is_free_goes_back_to_the_system() -> None:
    """200 MB in pieces, all freed but the last one, which holds glibc's heap."""
    program = """
import sys
sys.path.insert(0, sys.argv[1])
from allocator import give_back
def resident():
    return int(open("/proc/self/statm").read().split()[1]) * 4096 / 2**20
held = [bytearray(b"x" * 50_000) for _ in range(4000)]
del held[:-1]
kept = resident()
assert "glibc" in give_back()
assert kept - resident() > 150, (kept, resident())
"""
    subprocess.run([sys.executable, "-c", program, str(ADDON)], check=True)
