"""Figures of the report that are no plain render: the two normalisations, and the lens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image
from scipy.spatial import cKDTree

from photon_map.core import CameraData, Scene, SceneBuilder, Settings, render
from photon_map.core.photon_view import view_photons
from photon_map.core.prepared import prepare
from photon_map.image_file import srgb

ROOT = Path(__file__).parents[1]
#: Radius of the report's caustic estimates [m].
REPORT_RADIUS = 0.1
NEIGHBOURS = 48
#: So few photons that single ones are seen on the walls, and what they are scaled to.
FEW_PHOTONS = 1500
WRONG_BRIGHTNESS = 0.25
BOX = Settings(passes=24, pixel_filter="BOX", filter_width=1.0)

PAGE = """
### Figure 3: wrong and right normalisation of caustics

![two normalisations](gallery/normalisation.png)

Left what went wrong: the mean power of the photons within 0.1 m, as for the report's diffuse
light. Wherever a single photon lies, as on the walls, it is as bright as at the focus, in
discs of that radius. The report then divided the sum by the number of caustic photons and
scaled it by hand. Right the density estimate as it is here: flux per area of a disc that
follows the pixel, so the focus is bright because photons are dense there; nothing is set by
hand. The left picture has 1500 caustic photons and a scale by hand, and all other light as on
the right: what stays bright below the sphere is the lamp's spot on the ceiling, which gather
rays see through the sphere.

### Figure 4: the lens

![lens](gallery/lens.png)

Left the report's lens: a ray through the middle of the lens and one through its rim meet in the
plane of focus. Right what it blurs: radius of the disc on the image of a small glowing square
at a distance, measured (dots, from the second moment of the picture) and by
c = R abs(d - f) / f, in the plane of the square (line).
"""


def normalisation(path: Path) -> None:
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


def blur(distance: float, focus: float, radius: float, size: int = 65) -> float:
    """Measured radius [m] of the blur of a small glowing square ``distance`` away."""
    b = SceneBuilder("lens")
    h = 0.01 * distance
    corners = [(-h, -h, 0), (h, -h, 0), (h, h, 0), (-h, h, 0)]
    glow = b.add_material("glow", [], emission=1.0)
    b.add_mesh("spot", corners, [(0, 1, 2), (0, 2, 3)], glow)
    matrix = np.eye(4)
    matrix[2, 3] = distance
    lens = 36.0 / (2 * np.tan(np.radians(15)))
    b.set_camera(
        CameraData(
            width=size, height=size, matrix=matrix, lens=lens, lens_radius=radius,
            focus_distance=focus,
        )
    )  # fmt: skip
    *_, last = render(b.build(), replace(BOX, passes=128))
    image = last.film.resolve("emission")[..., 0].astype(np.float64)
    axis = np.arange(size) - (size - 1) / 2
    pixel = 2 * np.tan(np.radians(15)) * distance / size
    moment = (image * axis**2).sum() / image.sum() * pixel**2
    # A disc of radius c has c^2 / 4; the square and the pixel add theirs.
    return float(2 * np.sqrt(max(0.0, moment - h**2 / 3 - pixel**2 / 12)))


def lens(path: Path) -> None:
    """The report's diagram beside measured blur."""
    focus, radius = 2.0, 0.12
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
    measured.plot(line, radius * abs(line - focus) / focus, color="0.5")
    for distance in (1.0, 1.4, 2.0, 2.6, 3.4, 4.2, 5.0):
        measured.plot(distance, blur(distance, focus, radius), "o", color="C1")
    measured.set(xlabel="distance [m], focus at 2 m", ylabel="radius of the blur [m]")
    figure.savefig(path, dpi=100)


FIGURES: dict[str, Callable[[Path], None]] = {"normalisation": normalisation, "lens": lens}
