"""A core that only pretends to render: what it yields tells every pixel's place."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np


def update(
    phase: str, passes: int, film: Any, error: float, seconds: float, plan: Any = None
) -> Any:
    """Looks like ``core.Update``, whose import needs Numba."""
    return SimpleNamespace(
        phase=phase, passes=passes, film=film, relative_error=error, seconds=seconds,
        setup_seconds=0.5, plan=plan, message="", photon_bytes=3 << 20,
    )  # fmt: skip


class FakeFilm:
    """A ramp in which every pixel tells its place.

    The direct light's red is the column and its green the row from the bottom, both of the
    whole image; its blue counts the faces of the scene.
    """

    def __init__(self, region: tuple[int, int, int, int], faces: int) -> None:
        x0, y0, x1, y1 = region
        self.width, self.height, self.passes, self.nbytes = x1 - x0, y1 - y0, 0, 1 << 20
        self.statistics = SimpleNamespace(non_finite=0, rays=1_500_000, photons_emitted=1000)
        rows, columns = np.mgrid[y0:y1, x0:x1]
        direct = np.stack([columns, rows, np.full_like(rows, faces)], axis=2)
        self.layers = {
            "diffuse_direct": direct,
            "seen_emission": self.flat(0.25),
            "caustics": self.flat(0.5),
            "transmission_indirect": self.flat(0.125),
            "normal": self.flat(0.0, 0.6, 0.8),
            "distance": self.flat(7.0),
            "end_albedo": self.flat(0.1, 0.2, 0.3),
            "end_normal": self.flat(0.0, 0.0, -1.0),
            "end_depth": self.flat(8.0),
            "error": self.flat(0.01),
            "photon_density": self.flat(4000.0),
            "combined": np.concatenate([direct + 0.875, self.flat(1.0)], axis=2),
        }
        for layer in ("seen_emission", "caustics", "transmission_indirect"):
            self.layers[layer] = np.repeat(self.layers[layer], 3, axis=2)
        self.LAYERS = {name: layer.shape[2] for name, layer in self.layers.items()}

    def flat(self, *values: float) -> np.ndarray:
        return np.broadcast_to(values, (self.height, self.width, len(values)))

    def resolve(self, layer: str) -> np.ndarray:
        assert self.passes > 0
        return np.ascontiguousarray(self.layers[layer], dtype=np.float32)


class FakeCore:
    """Takes the place of ``core.render``, with ``FakeFilm``."""

    def __init__(self) -> None:
        self.passes_made = 0
        self.closed = 0
        self.fail_at: int | None = None
        self.error: BaseException = ValueError("the core broke")
        self.on_pass: Callable[[int], None] = lambda number: None
        self.warnings: tuple[str, ...] = ()

    def render(self, scene: Any, settings: Any, kept: Any = None) -> Iterator[Any]:
        x0, y0, x1, y1 = settings.region or (0, 0, scene.camera.width, scene.camera.height)
        film = FakeFilm((x0, y0, x1, y1), len(scene.faces))
        plan = SimpleNamespace(stages=(), warnings=self.warnings)
        try:
            yield update("setup", 0, film, float("inf"), 0.0, plan)
            for number in range(settings.passes):
                if number == self.fail_at:
                    raise self.error
                film.passes = number + 1
                self.passes_made = number + 1
                self.on_pass(number + 1)
                yield update("render", number + 1, film, 0.5, number + 1.0, plan)
            yield update("done", settings.passes, film, 0.5, 1.0, plan)
        finally:
            self.closed += 1
