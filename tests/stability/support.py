"""Renders for the stability suite: every one is checked for NaN, infinity and sign."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from photon_map.core import Film, Settings, render
from photon_map.core.scene.scene import Scene
from photon_map.core.scene.tables import LightKind

#: Deviations that the running test has measured, for docs/accuracy.md (``conftest.py``).
NOTED: list[float] = []
LIGHT = ("emission", "direct", "caustics", "indirect")
Layers = dict[str, NDArray[np.float64]]


def note(found: ArrayLike, expected: ArrayLike) -> None:
    """Keep how far the mean of ``found`` is off that of what is ``expected``.

    Relative to it, except where nothing is expected.
    """
    wanted = float(np.mean(expected))
    NOTED.append(abs(float(np.mean(found)) - wanted) / (abs(wanted) or 1.0))


def film_of(scene: Scene, **options: Any) -> Film:
    """The film of a small render; fails on any NaN, infinity or negative light."""
    chosen: dict[str, Any] = {
        "passes": 8, "pixel_filter": "BOX", "filter_width": 1.0, "threads": 2, **options,
    }  # fmt: skip
    film = list(render(scene, Settings(**chosen)))[-1].film
    assert film.statistics.non_finite == 0, "NaN or infinity in a sample"
    for name in film.LAYERS:
        values = film.resolve(name)
        assert np.isfinite(values).all(), f"{name}: not finite"
        if name != "normal":
            assert (values >= 0).all(), f"{name}: negative"
    return film


def shot(scene: Scene, **options: Any) -> Layers:
    """Light layers (h, w, 3) of a small render and their sum ``total``."""
    film = film_of(scene, **options)
    layers = {name: film.resolve(name).astype(np.float64) for name in LIGHT}
    layers["total"] = sum(layers.values(), np.zeros_like(layers["direct"]))
    return layers


def family(scene: Scene, runs: int = 8, seed: int = 0, **options: Any) -> Layers:
    """``shot`` of ``runs`` seeds from ``seed`` on, stacked: layer -> (runs, h, w, 3)."""
    films = [shot(scene, seed=seed + k, **options) for k in range(runs)]
    return {name: np.array([f[name] for f in films]) for name in films[0]}


def moved(scene: Scene, scale: float = 1.0, offset: ArrayLike = (0, 0, 0)) -> Scene:
    """``scene`` times ``scale``, then moved: it shows the same picture.

    Radiances and irradiances stay; intensities [W/sr] grow with the area.
    """
    shift = np.asarray(offset, float)
    lights = scene.lights.copy()
    lights["position"] = lights["position"] * scale + shift
    lights["radius"] *= scale
    # The sizes of a spot stretch its cone: they have no unit.
    area = lights["kind"] != LightKind.SPOT
    lights["size_x"][area] *= scale
    lights["size_y"][area] *= scale
    lights["emission"][np.isin(lights["kind"], (LightKind.POINT, LightKind.SPOT))] *= scale**2
    camera = scene.camera
    assert camera is not None
    matrix = camera.matrix.copy()
    matrix[:3, 3] = matrix[:3, 3] * scale + shift
    camera = replace(
        camera,
        matrix=matrix,
        lens_radius=camera.lens_radius * scale,
        focus_distance=camera.focus_distance * scale,
    )
    vertices = scene.vertices * scale + shift
    return replace(scene, vertices=vertices, lights=lights, camera=camera)


def standard_error(runs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of the mean over axis 0."""
    error: NDArray[np.float64] = runs.std(axis=0, ddof=1) / np.sqrt(len(runs))
    return error
