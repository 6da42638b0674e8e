"""Figures of the report that are no plain render: the two normalisations, and the lens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from PIL import Image
from scipy.spatial import cKDTree

from photon_map.core import Scene, Settings, render
from photon_map.core.photon_view import view_photons
from photon_map.core.prepared import prepare
from photon_map.image_file import srgb

if TYPE_CHECKING:
    from photon_map.core import Update

ROOT = Path(__file__).parents[1]
#: Radius of the report's caustic estimates [m].
REPORT_RADIUS = 0.1
NEIGHBOURS = 48
#: So few photons that single ones are seen on the walls, and what they are scaled to.
FEW_PHOTONS = 1500
WRONG_BRIGHTNESS = 0.25
BOX = Settings(passes=24, pixel_filter="BOX", filter_width=1.0)
#: Of lens_blur.blend: distances of its frames 1, 2, ..., of its focus; radius of its lens [m].
DISTANCES = (1.0, 1.4, 2.0, 2.6, 3.4, 4.2, 5.0)
FOCUS, LENS_RADIUS = 2.0, 0.12
#: Half an edge of its square over the distance, half its view [degrees], pixels a side.
HALF, HALF_VIEW, SIDE = 0.01, 15.0, 65

PAGE = """
### Figure 3: wrong and right normalisation of caustics

| ![two normalisations](gallery/normalisation.png) |
|---|
| {normalisation} |

Left what went wrong: the mean power of the photons within 0.1 m, as for the report's diffuse
light. Wherever a single photon lies, as on the walls, it is as bright as at the focus, in
discs of that radius. The report then divided the sum by the number of caustic photons and
scaled it by hand. Right the density estimate as it is here: flux per area of a disc that
follows the pixel, so the focus is bright because photons are dense there; nothing is set by
hand. The left picture has 1500 caustic photons and a scale by hand, and all other light as on
the right: what stays bright below the sphere is the lamp's spot on the ceiling, which gather
rays see through the sphere.

### Figure 4: the lens

| ![lens](gallery/lens.png) |
|---|
| {lens} |

Left the report's lens: a ray through the middle of the lens and one through its rim meet in the
plane of focus. Right what it blurs: radius of the disc on the image of a small glowing square
at a distance, measured (dots, from the second moment of the picture) and by
c = R abs(d - f) / f, in the plane of the square (line). The sample `lens_blur.blend` has a
frame for each distance, of 65x65 pixels.
"""


class Drawn(NamedTuple):
    """What the renders of a figure said, and what their caption says besides."""

    updates: list[Update]
    words: str


def normalisation(path: Path) -> Drawn:
    """Both ways to turn caustic photons into light, side by side."""
    from photon_map.addon import headless

    sample = ROOT / "sample_blends" / "caustic_sphere.blend"
    got = headless.export_file(sample, size=(320, 240), overrides=vars(BOX))
    scene, settings = got.scene, got.settings
    *_, last = render(scene, settings)
    film = last.film
    combined = film.resolve("combined")[..., :3].astype(np.float64)
    caustics = film.resolve("caustics").astype(np.float64)
    wrong = mean_power(scene, settings, film.resolve("depth")[..., 0])
    wrong *= film.resolve("albedo")
    wrong *= WRONG_BRIGHTNESS / np.percentile(wrong[wrong > 0], 90)
    both = np.concatenate([combined - caustics + wrong, combined], axis=1)
    Image.fromarray(np.rint(255 * srgb(both[::-1])).astype(np.uint8)).save(path)
    return Drawn([last], "on the right")


def mean_power(scene: Scene, settings: Settings, depth: np.ndarray) -> np.ndarray:
    """The report's first estimate at each pixel: the mean power of the photons near by."""
    prepared = prepare(scene, settings)
    camera = prepared.camera
    y, x = np.indices(depth.shape) + 0.5
    right = x * camera.step_x + camera.left
    up = y * camera.step_y + camera.bottom
    way = right[..., None] * camera.axes[0] + up[..., None] * camera.axes[1] + camera.axes[2]
    places = camera.position + prepared.centre.origin + depth[..., None] * way
    view = view_photons(scene, replace(settings, photons_caustic=FEW_PHOTONS))
    view = view.only(view.caustic)
    distance, nearest = cKDTree(view.position).query(
        places.reshape(-1, 3), k=NEIGHBOURS, distance_upper_bound=REPORT_RADIUS
    )
    found = np.isfinite(distance)
    flux = np.concatenate([view.flux, np.zeros((1, 3), np.float32)])[nearest]
    count = np.maximum(found.sum(axis=1), 1)
    return (flux.sum(axis=1) / count[:, None]).reshape(*depth.shape, 3).astype(np.float64)


def blur(update: Update, distance: float) -> float:
    """Radius [m] of the blur of the square ``distance`` away, in its own plane."""
    image = update.film.resolve("emission")[..., 0].astype(np.float64)
    axis = np.arange(SIDE) - (SIDE - 1) / 2
    pixel = 2 * np.tan(np.radians(HALF_VIEW)) * distance / SIDE
    moment = (image * axis**2).sum() / image.sum() * pixel**2
    # A disc of radius c has c^2 / 4; the square and the pixel add theirs.
    own = (HALF * distance) ** 2 / 3 + pixel**2 / 12
    return float(2 * np.sqrt(max(0.0, moment - own)))


def lens(path: Path) -> Drawn:
    """The report's diagram beside measured blur."""
    from photon_map.addon import headless

    sample = ROOT / "sample_blends" / "lens_blur.blend"
    settings = {**vars(BOX), "passes": 128}
    updates = [
        headless.render_file(sample, frame=k, size=(SIDE, SIDE), overrides=settings).update
        for k in range(1, len(DISTANCES) + 1)
    ]
    radii = [blur(*found) for found in zip(updates, DISTANCES, strict=True)]
    wanted = expected(np.array(DISTANCES))
    worst = float(abs(np.array(radii) - wanted).max())
    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    drawn, measured = figure.subplots(1, 2)
    drawn.axvline(0, color="0.5", lw=4, alpha=0.4)
    drawn.axvline(2.0, color="0.5", ls="--")
    for height in (-0.4, 0.0, 0.4):
        drawn.plot([0, 2.0, 2.6], [height, 0.5, 0.5 + 0.3 * (0.5 - height)], color="C0")
    drawn.plot([-0.6, 0.0], [-0.15, 0.0], color="C0", ls=":")
    drawn.annotate("lens", (0.0, -0.62), ha="center")
    drawn.annotate("plane of focus", (2.0, -0.62), ha="center")
    drawn.annotate("p", (1.1, 0.32), color="C0")
    drawn.annotate("d", (-0.12, 0.2), color="C0")
    drawn.annotate("v", (0.9, 0.5), color="C0")
    drawn.set(xlim=(-0.8, 2.8), ylim=(-0.75, 0.8), xticks=[], yticks=[])
    line = np.linspace(0.8, 5.0, 200)
    measured.plot(line, expected(line), color="0.5")
    measured.plot(DISTANCES, radii, "o", color="C1")
    measured.set(xlabel="distance [m], focus at 2 m", ylabel="radius of the blur [m]")
    figure.savefig(path, dpi=100)
    words = (
        f"the worst of {len(DISTANCES)} dots, seconds of all of them; each dot lies within "
        f"{1000 * worst:.1f} mm of the line"
    )
    return Drawn(updates, words)


def expected(distance: np.ndarray) -> np.ndarray:
    """Radius [m] of the blur at distances, in their own planes."""
    return LENS_RADIUS * abs(distance - FOCUS) / FOCUS


def page(captions: dict[str, str]) -> str:
    """The figures' part of the gallery's page."""
    return PAGE.format(**captions)


FIGURES: dict[str, Callable[[Path], Drawn]] = {"normalisation": normalisation, "lens": lens}
