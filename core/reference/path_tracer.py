"""The reference: light transport by plain path tracing, each path class in its layer.

Unbiased and slow. Camera paths with light sampling at every non-specular vertex (D), lamp
shapes and emitters found through specular chains (S), no depth limit but Russian roulette.
The layers follow the first D vertex after the eye, in Heckbert's notation: emission L S* E,
direct L D S* E, caustics L S+ D S* E, indirect all the rest. Lights without extent cannot
be found through a specular chain: their caustics are missing here, and only theirs.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..jit import allocating_kernel as kernel
from ..scene.scene import Scene, SceneError
from .camera import film_plane, primary_ray
from .flat import Flat, flatten
from .media import SLOTS, Stack, start_inside
from .vector import start, vec
from .walk import LAYERS, walk

Image = NDArray[np.float64]
LAYER_NAMES = ("emission", "direct", "caustics", "indirect", "combined")


@dataclass(frozen=True)
class Reference:
    """Means and variances of the means, layer -> (h, w, 3), row 0 at the bottom.

    ``reference["direct"]`` is ``reference.mean["direct"]``. Layers: emission, direct,
    caustics, indirect and combined, their sum.
    """

    mean: dict[str, Image]
    variance: dict[str, Image]
    samples: int

    def __getitem__(self, layer: str) -> Image:
        return self.mean[layer]


def trace(scene: Scene, samples: int, seed: int = 0, threads: int = 2) -> Reference:
    """Trace ``samples`` independent paths per pixel, box filter of one pixel.

    The result depends on (scene, samples, seed) alone, not on ``threads``.
    Raises ``SceneError`` without camera, ``ValueError`` when samples is below 2.
    """
    if scene.camera is None:
        raise SceneError(f"scene '{scene.name}' has no camera")
    if samples < 2:
        raise ValueError(f"samples is {samples}, a variance needs at least 2")
    flat, camera = flatten(scene), film_plane(scene.camera)
    height, width = scene.camera.height, scene.camera.width
    total = np.zeros((height, width, LAYERS + 1, 3))
    square = np.zeros_like(total)
    media = np.zeros(SLOTS, np.int64)
    start_inside(flat, vec(camera[3]), media)

    def one(line: int) -> None:
        _trace_line(flat, camera, media, line, samples, seed, total[line], square[line])

    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(one, range(height)))
    mean = total / samples
    # Two-pass precision is not needed: the spread of a pixel is of the order of its mean.
    variance = np.maximum(square / samples - mean**2, 0.0) / (samples - 1)
    return Reference(
        {name: mean[:, :, i] for i, name in enumerate(LAYER_NAMES)},
        {name: variance[:, :, i] for i, name in enumerate(LAYER_NAMES)},
        samples,
    )


@kernel
def _trace_line(
    s: Flat, camera: Image, media: Stack, line: int, samples: int, seed: int,
    total: Image, square: Image,
) -> None:  # fmt: skip
    """Add the samples of one row of pixels to ``total`` and ``square`` (w, LAYERS + 1, 3)."""
    stream = np.zeros(1, np.uint64)
    stack, scratch = np.zeros(SLOTS, np.int64), np.zeros(SLOTS, np.int64)
    light = np.zeros((LAYERS + 1, 3))
    width = len(total)
    for column in range(width):
        start(stream, seed, line * width + column)
        for _ in range(samples):
            light[:] = 0.0
            stack[:] = media
            origin, direction, far = primary_ray(camera, column, line, stream)
            walk(s, origin, direction, far, stack, scratch, stream, light)
            for c in range(3):
                for layer in range(LAYERS):
                    light[LAYERS, c] += light[layer, c]
                for layer in range(LAYERS + 1):
                    total[column, layer, c] += light[layer, c]
                    square[column, layer, c] += light[layer, c] * light[layer, c]
