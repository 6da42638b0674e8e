"""One scene of the parity suite: what it varies, how it is built and how long it renders."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

Build = Callable[[Any], None]


@dataclass(frozen=True)
class Case:
    """One scene. ``build`` gets a ``Stage`` and fills Blender's empty scene.

    ``passes`` of ours and ``samples`` of Cycles are those of one seed; ``photons`` of each
    kind a pass, -1: the engine's own choice. ``deviation`` says in what Cycles is not the
    judge here; then ``truth`` gives the image's mean (one number, or one a channel) by a
    closed form, or the text has the proof and blocks may differ while the means still have
    to agree.
    ``loses`` is the part of the mean that Cycles lacks, measured in a scene with a closed form.
    ``fine`` are warnings of the export that take nothing from the scene.
    """

    name: str
    says: str
    build: Build
    passes: int = 32
    samples: int = 64
    photons: int = -1
    size: tuple[int, int] = (32, 32)
    quick: bool = False
    deviation: str = ""
    truth: Callable[[], Any] | None = None
    loses: float = 0.0
    fine: tuple[str, ...] = ()


def case(says: str, **options: Any) -> Callable[[Build], Case]:
    """Make a scene's builder a ``Case`` of the function's name."""
    return lambda build: Case(build.__name__, says, build, **options)


def cases_of(*modules: Any) -> dict[str, Case]:
    """All cases of ``modules`` by name, in the order in which they are written."""
    found: dict[str, Case] = {}
    for module in modules:
        for value in vars(module).values():
            if isinstance(value, Case):
                assert value.name not in found, f"two cases are called {value.name}"
                found[value.name] = value
    return found
