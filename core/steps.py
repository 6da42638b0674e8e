"""Work in rounds of parts that need nothing of each other: whoever drives it runs them.

A generator yields the parts of a round, functions and their arguments, and is sent what they
have returned, in their order. So the same code runs on one thread or on all of a render.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import Any, TypeAlias, TypeVar

_T = TypeVar("_T")

Part: TypeAlias = tuple[Any, ...]
Steps: TypeAlias = Generator[list[Part], list[Any], _T]


def run(steps: Steps[_T]) -> _T:
    """All parts one after another; what ``steps`` return."""
    found: list[Any] | None = None
    while True:
        try:
            parts = next(steps) if found is None else steps.send(found)
        except StopIteration as end:
            result: _T = end.value
            return result
        found = [work(*arguments) for work, *arguments in parts]
