"""A render without light transport: updates at once, so that the command line can be tried."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from photon_map.core.film.stated_error import UNKNOWN, StatedError
from photon_map.core.scene.scene import Scene
from photon_map.core.settings import Settings

#: Every pixel's colour grows from left to right, its red from bottom to top.
LAYERS = {
    "combined": 4, "emission": 3, "direct": 3, "caustics": 3, "indirect": 3, "depth": 1,
    "normal": 3, "albedo": 3,
}  # fmt: skip


class FakeFilm:
    LAYERS: ClassVar[dict[str, int]] = LAYERS

    def __init__(self, width: int, height: int) -> None:
        self.width, self.height = width, height
        self.statistics = SimpleNamespace(
            photons_emitted=10, photons_stored=5, rays=20, non_finite=0
        )

    def resolve(self, layer: str) -> NDArray[np.float32]:
        """Red is the row from the bottom, green the column, each from 0 to 1."""
        row, column = np.meshgrid(
            np.linspace(0, 1, self.height), np.linspace(0, 1, self.width), indexing="ij"
        )
        planes = [row, column, np.full_like(row, 0.25), np.ones_like(row)]
        return np.stack(planes[: LAYERS[layer]], axis=-1).astype(np.float32)


PLAN = SimpleNamespace(
    stages=(
        SimpleNamespace(name="caustic photons", on=True, reason="1 caster: 'Glass'"),
        SimpleNamespace(name="lens", on=False, reason="the aperture is closed"),
    ),
    warnings=("the scene has no light",),
)


@dataclass(frozen=True)
class FakeUpdate:
    passes: int
    film: FakeFilm
    phase: str = "render"
    seconds: float = 0.0
    error: StatedError = UNKNOWN
    setup_seconds: float = 0.5
    photon_bytes: int = 0
    message: str = ""
    plan: SimpleNamespace = field(default_factory=lambda: PLAN)

    @property
    def relative_error(self) -> float:
        return self.error.relative_error


@dataclass
class FakeRender:
    """Stands in for ``core.render``; keeps its arguments and whether it was closed."""

    at_pass: Callable[[int], None] = lambda i: None
    calls: list[tuple[Scene, Settings]] = field(default_factory=list)
    closed: bool = False

    def __call__(self, scene: Scene, settings: Settings) -> Iterator[FakeUpdate]:
        self.calls.append((scene, settings))
        assert scene.camera is not None
        film = FakeFilm(scene.camera.width, scene.camera.height)
        try:
            for i in range(min(settings.passes, 6)):
                self.at_pass(i)
                error = StatedError(1 / i, 0.0) if i > 1 else UNKNOWN
                phase = "render" if i else "compile"
                yield FakeUpdate(i, film, phase, 0.1 * i, error, message=f"{phase} {i}")
        finally:
            self.closed = True

    @property
    def settings(self) -> Settings:
        return self.calls[-1][1]
