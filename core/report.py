"""What a render tells of itself, as plain data ready for JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .film.stated_error import StatedError
from .scene.scene import Scene
from .settings import Settings
from .version import ENGINE, VERSION

if TYPE_CHECKING:
    from .update import Update


@dataclass(frozen=True)
class CurvePoint:
    """The stated error after ``passes`` passes and ``seconds`` of rendering."""

    passes: int
    seconds: float
    error: StatedError


class ErrorCurve:
    """Error over time, collected from the updates of one render."""

    def __init__(self) -> None:
        self._points: list[CurvePoint] = []

    @property
    def points(self) -> tuple[CurvePoint, ...]:
        """One point for each pass count seen, in order."""
        return tuple(self._points)

    def add(self, update: Update) -> None:
        """Keep the update when it has passes that the last point had not."""
        if update.passes > (self._points[-1].passes if self._points else 0):
            self._points.append(CurvePoint(update.passes, update.seconds, update.error))


def completed(update: Update, settings: Settings) -> float:
    """Part of the render that is done, 0 to 1, by the limit that will be met first."""
    parts = [update.passes / settings.passes]
    if settings.seconds > 0:
        parts.append(update.seconds / settings.seconds)
    if settings.error_goal > 0 and 0 < update.relative_error < math.inf:
        # Noise falls with the root of the passes.
        parts.append((settings.error_goal / update.relative_error) ** 2)
    return float(min(1.0, max(parts)))


def render_report(
    update: Update, scene: Scene, settings: Settings, curve: Sequence[CurvePoint] = ()
) -> dict[str, Any]:
    """The report of a render that ended with ``update``.

    Times are seconds; ``relative_error`` is the square root of the image's estimated
    relative mean squared error (0.1: 10 % in a typical pixel), ``noise`` and ``bias`` are
    its parts, whose squares add up. A number that is not known yet, or not finite, is
    None: JSON has no word for it.
    """
    film = update.film
    statistics = film.statistics
    return {
        "engine": ENGINE,
        "version": VERSION,
        "scene": scene.name,
        "width": film.width,
        "height": film.height,
        "seed": settings.seed,
        "threads": settings.thread_count,
        "passes": update.passes,
        "seconds": _finite(update.seconds),
        "setup_seconds": _finite(update.setup_seconds),
        "photons_emitted": int(statistics.photons_emitted),
        "photons_stored": int(statistics.photons_stored),
        "photon_megabytes": round(update.photon_bytes / 2**20, 3),
        "rays": int(statistics.rays),
        "non_finite": int(statistics.non_finite),
        **_errors(update.error),
        "plan": [
            {"stage": stage.name, "on": bool(stage.on), "reason": stage.reason}
            for stage in update.plan.stages
        ],
        "curve": [
            {
                "pass": point.passes,
                "seconds": _finite(point.seconds),
                **_errors(point.error),
            }
            for point in curve
        ],
    }


def _errors(error: StatedError) -> dict[str, float | None]:
    return {
        "relative_error": _finite(error.relative_error),
        "noise": _finite(error.noise),
        "bias": _finite(error.bias),
    }


def _finite(value: float) -> float | None:
    number = float(value)
    return number if math.isfinite(number) else None
