"""What is known of a scene's needs: its plan, what the export lost, its last render.

Kept outside of Blender's data, because renders write it from a thread of their own; it is
forgotten when another file is loaded.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import bpy


class Insight(NamedTuple):
    """Stages (name, whether it is on, why), warnings of the export and of the plan, and a line
    about the last render."""

    stages: tuple[tuple[str, bool, str], ...] = ()
    exported: tuple[str, ...] = ()
    planned: tuple[str, ...] = ()
    result: str = ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """All of them."""
        return (*self.exported, *self.planned)


_LATEST: dict[int, Insight] = {}


def insight_of(scene: Any) -> Insight | None:
    """What is known of ``scene``, evaluated or not."""
    return _LATEST.get(_key(scene))


def remember(scene: Any, plan: Any, warnings: Sequence[str], result: str = "") -> None:
    """Keep the plan and the warnings of an export of ``scene``, and how its render ended."""
    stages = tuple((stage.name, bool(stage.on), stage.reason) for stage in plan.stages)
    before = insight_of(scene)
    if not result and before is not None:
        result = before.result
    _LATEST[_key(scene)] = Insight(stages, tuple(warnings), tuple(plan.warnings), result)


def remember_export(scene: Any, warnings: Sequence[str]) -> None:
    """Keep the warnings of an export of ``scene`` for a viewport, beside what is known."""
    before = insight_of(scene) or Insight()
    _LATEST[_key(scene)] = before._replace(exported=tuple(warnings))


def counted(warnings: Sequence[str]) -> str:
    """How many they are, in words."""
    return f"{len(warnings)} warning{'' if len(warnings) == 1 else 's'}"


def forget(*_: Any) -> None:
    """Forget everything."""
    _LATEST.clear()


def _key(scene: Any) -> int:
    return int(scene.original.session_uid)


@bpy.app.handlers.persistent
def _loaded(*_: Any) -> None:
    forget()


def register() -> None:
    """Forget when another file is loaded."""
    bpy.app.handlers.load_pre.append(_loaded)


def unregister() -> None:
    """Leave nothing behind."""
    bpy.app.handlers.load_pre.remove(_loaded)
    forget()
