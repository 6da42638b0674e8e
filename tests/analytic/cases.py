"""Caustics that have a closed form, through the whole engine: error against passes.

``make accuracy`` tabulates and plots ``table(case)`` for each of ``CASES``; the tests
beside this file hold them to bounds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from photon_map.core import Settings, render
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse, mirror
from photon_map.core.scene.scene import Scene
from photon_map.tests import scenes
from photon_map.tests.analytic.optics import (
    nephroid,
    pixel_means,
    radial_irradiance,
    reflectance,
    through_ball,
    through_lens,
)

Image = NDArray[np.float64]
PHOTONS = 32768
ALBEDO = 0.8


class Result(NamedTuple):
    """One render against the closed form.

    ``error``: root of the mean squared difference over the compared pixels, relative to
    the root mean square of the closed form; ``mean_error`` of the image's mean; pictures
    (h, w), NaN where nothing is compared; ``photons`` emitted in all passes together.
    """

    passes: int
    photons: int
    error: float
    mean_error: float
    found: Image
    expected: Image


@dataclass(frozen=True)
class Case:
    """A scene with the closed form of its caustic layer; ``law`` says which it is."""

    name: str
    law: str
    make: Callable[[], tuple[Scene, Image]]

    def measure(self, passes: int, seed: int = 0, **options: Any) -> Result:
        """Render ``passes`` passes and compare."""
        scene, expected = self.make()
        chosen: dict[str, Any] = {
            "photons_caustic": PHOTONS, "photons_global": 0, "caustic_radius": 1.0,
            "pixel_filter": "BOX", "filter_width": 1.0, "photon_depth": 64, "threads": 2,
            **options,
        }  # fmt: skip
        film = list(render(scene, Settings(passes=passes, seed=seed, **chosen)))[-1].film
        assert film.statistics.non_finite == 0
        found = film.resolve("caustics").mean(axis=2, dtype=np.float64)
        compared = np.isfinite(expected)
        x, y = found[compared], expected[compared]
        error = float(np.sqrt(((x - y) ** 2).mean() / (y**2).mean()))
        mean_error = float(x.mean() / y.mean() - 1)
        photons = film.statistics.photons_emitted
        found = np.where(compared, found, np.nan)
        return Result(film.passes, photons, error, mean_error, found, expected)


def table(
    case: Case, passes: Sequence[int] = (1, 4, 16, 64, 256), seed: int = 0
) -> list[Result]:
    """``case`` at growing numbers of passes."""
    return [case.measure(count, seed) for count in passes]


def _grid(size: int, half: float) -> tuple[Image, Image, float]:
    """Pixel middles x (columns) and y (rows, bottom first) of a square image, and its step."""
    step = 2 * half / size
    axis = (np.arange(size) + 0.5) * step - half
    x, y = np.meshgrid(axis, axis)
    return x, y, step


def _floor(size: int, half: float, height: float, floor: float = 4.0) -> SceneBuilder:
    """A floor at z = 0 seen from ``height``; the image shows ``half`` to each side."""
    b = SceneBuilder("caustic")
    b.add_mesh("floor", *scenes.plane(floor), b.add_material("grey", [diffuse(ALBEDO)]))
    fov = 2 * np.arctan(half / height)
    b.set_camera(scenes.camera((0, 0, height), (0, 0, 0), size, size, up=(0, 1, 0), fov=fov))
    return b


def slab(size: int = 24) -> tuple[Scene, Image]:
    """A lamp over a pane: Snell's shift, and the pane's inner reflections one by one."""
    n, low, high, lamp, half = 1.5, 0.5, 0.8, 1.2, 0.7
    b = _floor(size, half, 0.45)
    b.add_mesh(
        "slab", *scenes.glass_slab(n, low, high, 6.0), b.add_material("g", [dielectric(n)])
    )
    b.add_point_light("lamp", (0, 0, lamp), 4.0)
    theta = np.linspace(0, np.radians(75), 200001)
    inside = np.arcsin(np.sin(theta) / n)
    f = reflectance(np.cos(theta), n)
    x, y, _ = _grid(size, half)
    edges = np.linspace(0, 1.5 * half, 2000)
    total = np.zeros(len(edges) - 1)
    power = 4.0 * 2 * np.pi * np.diff(-np.cos(theta))
    for k in range(6):
        way = (lamp - high + low) * np.tan(theta) + (2 * k + 1) * (high - low) * np.tan(inside)
        share = (1 - f) ** 2 * f ** (2 * k)
        at = (way[1:] + way[:-1]) / 2
        total += np.histogram(at, edges, weights=power * (share[1:] + share[:-1]) / 2)[0]
    e = total / (np.pi * np.diff(edges**2))
    return b.build(), ALBEDO / np.pi * pixel_means(x, y, 2 * half / size, edges, e)


def plane_mirror(size: int = 24) -> tuple[Scene, Image]:
    """A lamp beside a mirror: E = I cos / r^2 of the virtual lamp behind it."""
    half = 1.1
    b = _floor(size, half, 3.0)
    wall = scenes.quad((2, -1.5, 0), (2, 1.5, 0), (2, 1.5, 1.2), (2, -1.5, 1.2))
    b.add_mesh("mirror", *wall, b.add_material("mirror", [mirror(1.0)]))
    b.add_point_light("lamp", (0.5, 0.2, 1.5), 4.0)
    x, y, step = _grid(size, half)
    # Seen from the virtual lamp the picture is far: the middle stands for the pixel.
    e = 4.0 * 1.5 / ((x - 3.5) ** 2 + (y - 0.2) ** 2 + 2.25) ** 1.5
    return b.build(), ALBEDO / np.pi * e


def _smooth_ball(b: SceneBuilder, centre: float, radius: float, n: float) -> None:
    ball = scenes.sphere((0, 0, centre), radius, 5)
    normals = scenes.sphere_normals(ball, (0, 0, centre))
    b.add_mesh("ball", *ball, b.add_material("glass", [dielectric(n)]), normals)


def ball_lens(size: int = 32) -> tuple[Scene, Image]:
    """Sun along the axis of a glass ball, beyond its focus: the Jacobian of the rays."""
    n, radius, centre, half = 1.5, 1.0, 3.0, 1.2
    b = _floor(size, half, 1.9)
    _smooth_ball(b, centre, radius, n)
    b.add_sun_light("sun", scenes.DOWN, 3.0)
    h = np.linspace(0, radius * (1 - 1e-9), 400001)
    edges = np.linspace(0, 1.5 * half, 1500)
    e = np.zeros(len(edges) - 1)
    for inner in range(6):
        landed, share = through_ball(h, n, centre, radius, inner)
        e += 3.0 * radial_irradiance(h, landed, share, edges)
    x, y, step = _grid(size, half)
    expected = ALBEDO / np.pi * pixel_means(x, y, step, edges, e)
    # Compared is the disc of the rays that pass straight: at its rim they graze the ball.
    return b.build(), np.where(np.hypot(x, y) < 0.85, expected, np.nan)


def _lens(radius: float, aperture: float, middle: float) -> tuple[scenes.Mesh, NDArray]:
    """Two caps of balls of ``radius`` that meet at ``aperture``: (mesh, corner normals)."""
    drop = np.sqrt(radius**2 - aperture**2)
    rings, around = 96, 192
    r = aperture * np.linspace(0, 1, rings + 1)
    a = 2 * np.pi * np.arange(around) / around
    points, normals, faces = [], [], []
    for side in (1.0, -1.0):
        first = len(points)
        for ring in r:
            z = np.sqrt(radius**2 - ring**2)
            for t in a:
                at = np.array([ring * np.cos(t), ring * np.sin(t), side * z])
                normals.append(at / radius)
                points.append(at + (0, 0, middle - side * drop))
        for i in range(rings):
            for j in range(around):
                p, q = first + i * around + j, first + i * around + (j + 1) % around
                s, t = p + around, q + around
                both = [(p, s, t), (p, t, q)] if i else [(p, s, t)]
                faces += both if side > 0 else [face[::-1] for face in both]
    mesh = np.array(points), np.array(faces)
    return mesh, np.array(normals)[mesh[1]].astype(np.float32)


def thin_lens(size: int = 32) -> tuple[Scene, Image]:
    """Sun through a lens of f = R / (2 (n - 1)) = 2 m on a floor at 0.75 f."""
    n, radius, aperture, middle, half = 1.5, 2.0, 0.25, 1.5, 0.1
    b = _floor(size, half, 1.2)
    mesh, normals = _lens(radius, aperture, middle)
    b.add_mesh("lens", *mesh, b.add_material("glass", [dielectric(n)]), normals)
    b.add_sun_light("sun", scenes.DOWN, 3.0)
    drop = np.sqrt(radius**2 - aperture**2)
    h = np.linspace(0, aperture, 200001)
    landed, share = through_lens(h, n, (middle - drop, radius), (middle + drop, radius), 0.0)
    edges = np.linspace(0, 1.5 * half, 3000)
    e = 3.0 * radial_irradiance(h, landed, share, edges)
    # Light reflected twice inside is focused in front of the floor and spread widely:
    # F^2 of it over a disc of 3.6 times the lens's radius, far below the noise.
    x, y, step = _grid(size, half)
    return b.build(), ALBEDO / np.pi * pixel_means(x, y, step, edges, e)


def nephroid_cup(size: int = 48) -> tuple[Scene, Image]:
    """Sun into half a cylinder: caustic at s = R cos(phi) / 2, its cusp at R / 2."""
    radius, elevation, height = 1.0, np.radians(30), 0.6
    b = _floor(size, 1.0, 3.0, floor=1.5)
    count = 512
    phi = np.linspace(-np.pi / 2, np.pi / 2, count + 1)
    ring = np.stack([np.cos(phi), np.sin(phi)], axis=1) * radius
    points = np.concatenate([np.c_[ring, 0 * phi], np.c_[ring, 0 * phi + height]])
    k = np.arange(count)
    faces = np.concatenate(
        [np.stack([k, k + count + 1, k + 1], 1),
         np.stack([k + 1, k + count + 1, k + count + 2], 1)]
    )  # fmt: skip
    normals = (-points / radius * (1, 1, 0))[faces].astype(np.float32)
    b.add_mesh("cup", points, faces, b.add_material("silver", [mirror(1.0)]), normals)
    to_sun = (-np.cos(elevation), 0, np.sin(elevation))
    b.add_sun_light("sun", scenes.look_at(to_sun, (0, 0, 0)), 3.0)
    x, y, step = _grid(size, 1.0)
    edges = np.linspace(-1, 1, size + 1)
    expected = ALBEDO / np.pi * 3.0 * nephroid(radius, elevation, height, edges)
    return b.build(), np.where(np.hypot(x, y) < 0.9, expected, np.nan)


def prism(size: int = 32) -> tuple[Scene, Image]:
    """Sun through a 60 degree prism at least deviation 2 asin(n sin 30) - 60 degrees."""
    n, apex = 1.5, np.radians(60)
    deviation = 2 * np.arcsin(n * np.sin(apex / 2)) - apex
    incidence = (deviation + apex) / 2
    # The apex line is x = 0, z = 1; the faces lean by half the apex angle to each side.
    side, depth, tip = 0.5, 0.5, 1.0
    lean = np.array([np.sin(apex / 2), np.cos(apex / 2)]) * side
    corners = np.array([(0, tip), (-lean[0], tip - lean[1]), (lean[0], tip - lean[1])])
    points = np.array([(x, y, z) for y in (-depth, depth) for x, z in corners])
    faces = [
        (0, 1, 2),
        (3, 5, 4),
        (0, 3, 4),
        (0, 4, 1),
        (0, 2, 5),
        (0, 5, 3),
        (1, 4, 5),
        (1, 5, 2),
    ]
    # Inside the light runs along +x; outside it comes from the left, raised by half of it.
    come = np.array([np.cos(deviation / 2), 0, np.sin(deviation / 2)])
    go = np.array([np.cos(deviation / 2), 0, -np.sin(deviation / 2)])
    share = float((1 - reflectance(np.cos(incidence), n)) ** 2)
    # The right face's ends, projected along the ray to the screen x = 2.
    screen = 2.0
    ends = [z + (screen - x) * go[2] / go[0] for x, z in ((0.0, tip), (lean[0], tip - lean[1]))]
    half = 0.35
    middle = sum(ends) / 2
    b = SceneBuilder("prism")
    b.add_mesh("prism", points, faces, b.add_material("glass", [dielectric(n)]))
    wall = scenes.quad((screen, -3, -3), (screen, -3, 3), (screen, 3, 3), (screen, 3, -3))
    b.add_mesh("screen", *wall, b.add_material("grey", [diffuse(ALBEDO)]))
    b.add_sun_light("sun", scenes.look_at(-come, (0, 0, 0)), 3.0)
    fov = 2 * np.arctan(half / 1.0)
    b.set_camera(
        scenes.camera((screen - 1, 0, middle), (screen, 0, middle), size, size, fov=fov)
    )
    edges = middle + np.linspace(-half, half, size + 1)
    lit = np.clip((np.minimum(edges[1:], max(ends)) - np.maximum(edges[:-1], min(ends))) /
                  np.diff(edges), 0, 1)  # fmt: skip
    expected = ALBEDO / np.pi * 3.0 * share * go[0] * lit
    # Below the patch falls what the base has reflected inside.
    expected = np.where(edges[1:] < min(ends), np.nan, expected)
    return b.build(), np.repeat(expected[:, None], size, axis=1)


def _water(size: int, eye: float) -> tuple[SceneBuilder, float]:
    """A pool 0.5 m deep under a sun 40 degrees off the zenith: irradiance on its ground."""
    n, theta = 1.33, np.radians(40)
    b = _floor(size, 0.5 * eye, eye)
    points, faces = scenes.box((-1.3, -0.6, -0.2), (1.3, 0.6, 0.5))
    b.add_mesh("water", points, faces, b.add_material("water", [dielectric(n)]))
    b.add_sun_light("sun", scenes.look_at((np.sin(theta), 0, np.cos(theta)), (0, 0, 0)), 3.0)
    return b, 3.0 * np.cos(theta) * float(1 - reflectance(np.cos(theta), n))


def water_from_above(size: int = 16) -> tuple[Scene, Image]:
    """E = S cos (1 - F), seen through the surface: L = a E (1 - F) / (pi n^2)."""
    n, eye = 1.33, 1.0
    b, e = _water(size, eye)
    x, y, _ = _grid(size, 0.5 * eye)
    view = np.cos(np.arctan(np.hypot(x, y) / eye))
    return b.build(), ALBEDO / np.pi * e * (1 - reflectance(view, n)) / n**2


def water_from_below(size: int = 16) -> tuple[Scene, Image]:
    """The same ground seen by a diver: no factor at all between E and L."""
    b, e = _water(size, 0.4)
    return b.build(), np.full((size, size), ALBEDO / np.pi * e)


CASES = (
    Case("parallel slab", "E = sum over inner reflections of I (1-F)^2 F^2k dw/dA", slab),
    Case("plane mirror", "virtual lamp, E = I cos / r^2", plane_mirror),
    Case("ball lens", "E = S (1-F1)(1-F2) h dh / (rho drho)", ball_lens),
    Case("thin lens", "f = R / (2 (n - 1)), E by the ray Jacobian at 0.75 f", thin_lens),
    Case(
        "nephroid",
        "E = S sin(e) R cos(phi) / abs(R cos(phi) - 2 s), cusp at R / 2",
        nephroid_cup,
    ),
    Case("prism", "least deviation 2 asin(n sin(A / 2)) - A", prism),
    Case("water from above", "L = a S cos (1-F)(1-F') / (pi n^2)", water_from_above),
    Case("water from below", "L = a S cos (1-F) / pi", water_from_below),
)
