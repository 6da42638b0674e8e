"""How fast each layer converges: its mean squared error against passes.

All runs of a layer share a scene and differ in the seed. The error at n passes has two
parts: the variance over seeds, and the squared bias of their mean against the truth. The
slope is fitted to the logarithms over the number of passes; its interval comes from the
seeds (jackknife).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from photon_map.core import Settings, render
from photon_map.core.camera_pass import light_image
from photon_map.core.photons.photon_map import Crowd
from photon_map.core.pilot import Radii
from photon_map.core.scene.builder import SceneBuilder, diffuse
from photon_map.core.scene.scene import Scene
from photon_map.tests import scenes
from photon_map.tests.analytic.cases import slab

Image = NDArray[np.float64]
PASSES = (4, 8, 16, 32, 64, 128, 256)


class Slope(NamedTuple):
    """d log(MSE) / d log(passes) with a 99 % interval, and what it was fitted to.

    ``mse``, ``variance`` and ``bias2`` (squared bias, its own noise taken off) per number
    of ``passes``, relative to the mean square of the truth; ``last`` is the slope over the
    last three. ``offset`` and ``offset_error``: the image's mean over the truth's, less 1,
    and its standard error.
    """

    layer: str
    slope: float
    low: float
    high: float
    last: float
    passes: tuple[int, ...]
    mse: Image
    variance: Image
    bias2: Image
    offset: Image
    offset_error: Image


def caustics(size: int = 12) -> tuple[Scene, Image]:
    """A lamp over a pane of glass: smooth light, known in closed form."""
    return slab(size)


@contextmanager
def even_discs() -> Iterator[None]:
    """Renders within have caustic discs of one size: no place counts for crowded.

    Crowded ones hold more than 8 photons and have a size of their own, which stays until the
    others, that shrink with the passes, are as small.
    """
    crowd_of = Radii.crowd_of

    def empty(radii: Radii, emitted: int) -> Crowd | None:
        crowd = crowd_of(radii, emitted)
        return crowd and crowd._replace(factor=0.0)

    with patch.object(Radii, "crowd_of", empty), discs_alone():
        yield


@contextmanager
def discs_alone() -> Iterator[None]:
    """Renders within have no photons connected with the camera: discs bring all caustics."""

    def none(so_far: Image) -> Image:
        return np.zeros_like(so_far)

    with patch.object(light_image, "connected_share", none):
        yield


def emission(size: int = 12) -> tuple[Scene, Image]:
    """Glowing tiles finer than a pixel: about half of each pixel shines."""
    b = SceneBuilder("tiles")
    glow, dark = b.add_material("glow", [], emission=2.0), b.add_material("dark", [])
    steps = np.linspace(-1, 1, 3 * size + 1)
    for i in range(3 * size):
        for j in range(3 * size):
            x, y, x1, y1 = steps[j], steps[i], steps[j + 1], steps[i + 1]
            tile = scenes.quad((x, y, 0), (x1, y, 0), (x1, y1, 0), (x, y1, 0))
            b.add_mesh(f"{i} {j}", *tile, glow if (i + j) % 2 else dark)
    fov = 2 * np.arctan(1 / 3)
    b.set_camera(scenes.camera((0, 0, 3), (0, 0, 0), size, size, up=(0, 1, 0), fov=fov))
    odd = np.add.outer(np.arange(3 * size), np.arange(3 * size)) % 2
    return b.build(), 2.0 * odd.reshape(size, 3, size, 3).mean(axis=(1, 3))


def direct(size: int = 12) -> tuple[Scene, Image]:
    """A large ball lamp over a floor: E = I cos / r^2 all the same."""
    b = scenes.floor_scene([diffuse(0.8)], size=size, height=3.0)
    b.add_point_light("lamp", (0.3, -0.2, 1.5), 5.0, 0.7)
    scene = b.build()

    def radiance(x: Image, y: Image) -> Image:
        return 0.8 / np.pi * 5.0 * 1.5 / ((x - 0.3) ** 2 + (y + 0.2) ** 2 + 2.25) ** 1.5

    return scene, scenes.floor_mean(scene, radiance)


def indirect(size: int = 8) -> tuple[Scene, Image]:
    """A lamp in the middle of a ball: a^2 Phi / (A pi (1 - a)) everywhere, no borders.

    That is by the flux Phi over the ball's own area A: between the flat faces of 20480 the
    radiance varies by less than 0.1 %, of 1280 it would be 0.5 % brighter than a true ball.
    """
    b = SceneBuilder("closed ball")
    points, faces = scenes.sphere((0, 0, 0), 1.0, 5)
    b.add_mesh("shell", points, faces, b.add_material("shell", [diffuse(0.5)]))
    b.add_point_light("lamp", (0, 0, 0), np.pi)
    target = (1, 0.3, 0.2)
    b.set_camera(scenes.camera((0.3, 0.1, 0), target, size, size, fov=np.radians(60)))
    a, c, d = (points[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(c - a, d - a), axis=1).sum() / 2
    return b.build(), np.full((size, size), 0.5 * 4 * np.pi / area)


def borders(size: int = 8) -> tuple[Scene, Image]:
    """The inside of a glowing box: as bright along its edges and in its corners as elsewhere.

    Of the radiance e / (1 - a) the walls' own glow and its first reflection are other layers.
    """
    return scenes.furnace_box(0.5, 1.0, size), np.full((size, size), 0.5)


#: What is rendered for each layer; "crowded discs" are caustics without connections, "even
#: discs" those where none counts for crowded either,
#: "borders" is the indirect layer where discs stick out.
CASES: dict[str, Callable[[], tuple[Scene, Image]]] = {
    "emission": emission, "direct": direct, "caustics": caustics,
    "crowded discs": caustics, "even discs": caustics, "indirect": indirect, "borders": borders,
}  # fmt: skip
_OPTIONS: dict[str, dict[str, Any]] = {
    "emission": {"photons_global": 0, "photons_caustic": 0},
    "direct": {"photons_global": 0, "photons_caustic": 0},
    "caustics": {"photons_global": 0, "photons_caustic": 8192},
    "crowded discs": {"photons_global": 0, "photons_caustic": 8192},
    "even discs": {"photons_global": 0, "photons_caustic": 8192},
    "indirect": {"photons_global": 8192, "photons_caustic": 0},
    "borders": {"photons_global": 8192, "photons_caustic": 0},
}


def snapshots(
    scene: Scene, layer: str, passes: Sequence[int], seed: int, **options: Any
) -> Image:
    """The layer (len(passes), h, w) after each number of passes of one render."""
    chosen = {"pixel_filter": "BOX", "filter_width": 1.0, "threads": 2, **options}
    out = []
    for count in passes:
        film = list(render(scene, Settings(passes=count, seed=seed, **chosen)))[-1].film
        assert film.statistics.non_finite == 0
        out.append(film.resolve(layer).mean(axis=2, dtype=np.float64))
    return np.array(out)


def fit(passes: Sequence[int], mse: Image) -> float:
    """Least-squares slope of log(mse) over log(passes)."""
    return float(np.polyfit(np.log(passes), np.log(mse), 1)[0])


def slope_of(layer: str, runs: Image, truth: Image, passes: Sequence[int]) -> Slope:
    """The slope of ``runs`` (seeds, passes, h, w) against ``truth`` (h, w)."""
    seeds = len(runs)
    scale = (truth**2).mean()
    square = ((runs - truth) ** 2).mean(axis=(2, 3)) / scale
    variance = runs.var(axis=0, ddof=1).mean(axis=(1, 2)) / scale
    bias2 = ((runs.mean(axis=0) - truth) ** 2).mean(axis=(1, 2)) / scale - variance / seeds
    slope = fit(passes, square.mean(axis=0))
    left_out = [fit(passes, np.delete(square, k, axis=0).mean(axis=0)) for k in range(seeds)]
    error = np.sqrt((seeds - 1) * np.var(left_out))
    reach = float(stats.t.ppf(0.995, seeds - 1) * error)
    last = fit(passes[-3:], square.mean(axis=0)[-3:])
    means = runs.mean(axis=(2, 3)) / truth.mean() - 1
    return Slope(layer, slope, slope - reach, slope + reach, last, tuple(passes),
                 square.mean(axis=0), variance, bias2, means.mean(axis=0),
                 means.std(axis=0, ddof=1) / np.sqrt(seeds))  # fmt: skip


def measure(case: str, seeds: int = 8, passes: Sequence[int] = PASSES, **options: Any) -> Slope:
    """Render ``case`` with ``seeds`` seeds at each of ``passes`` and fit."""
    scene, truth = CASES[case]()
    chosen = {**_OPTIONS[case], **options}
    layer = "caustics" if "discs" in case else "indirect" if case == "borders" else case
    within = {"even discs": even_discs, "crowded discs": discs_alone}.get(case, nullcontext)
    with within():
        runs = np.array([snapshots(scene, layer, passes, k, **chosen) for k in range(seeds)])
    return slope_of(case, runs, truth, passes)
