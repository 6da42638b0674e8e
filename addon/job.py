"""What a caller outside Blender's user interface wants from the next render.

The command line cannot pass arguments to a render callback, because Blender makes the
engine object. So it sets ``CURRENT`` around the operator and the engine reads it there. A
context variable ends with its ``with`` block and belongs to one thread, so that nothing is
left behind for a later render.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..core import Scene, Settings, Update


@dataclass
class Job:
    """Wishes of the caller, and what the render leaves for them.

    ``overrides`` are fields of ``core.settings.Settings`` that win over the file's.
    With several view layers the first one rendered is kept. ``failure`` is a text, because
    the traceback of an exception would keep the engine alive longer than Blender does.
    """

    overrides: Mapping[str, Any] = field(default_factory=dict)
    on_update: Callable[[Update], bool | None] | None = None
    export_only: bool = False
    layer: str | None = None
    scene: Scene | None = None
    settings: Settings | None = None
    update: Update | None = None
    warnings: tuple[str, ...] = ()
    failure: str = ""
    interrupted: bool = False

    def exported(
        self, layer: str, scene: Scene, settings: Settings, warnings: tuple[str, ...]
    ) -> None:
        """Keep what was exported for ``layer``, if it is the first one."""
        if self.layer is None:
            self.layer, self.scene, self.settings = layer, scene, settings
            self.warnings = warnings
        else:
            self.warnings += (
                f"view layer '{layer}' is rendered, but only '{self.layer}' is kept apart",
            )

    def updated(self, layer: str, update: Update) -> bool:
        """Pass an update on to the caller; whether they want the render to end."""
        if layer == self.layer:
            self.update = update
        return bool(self.on_update is not None and self.on_update(update))


CURRENT: ContextVar[Job | None] = ContextVar("photon_map_job", default=None)


@contextmanager
def running(job: Job) -> Iterator[Job]:
    """Make ``job`` the one that render callbacks see inside the block."""
    token = CURRENT.set(job)
    try:
        yield job
    finally:
        CURRENT.reset(token)
