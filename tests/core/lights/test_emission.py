"""Photons as the lights send them: total flux, and irradiance on a plane (level 0.01)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from photon_map.core.geometry.mesh import centre_of, centred_mesh
from photon_map.core.lights.emission import reaches
from photon_map.core.lights.light_set import light_set
from photon_map.core.photons.emission_histogram import (
    BINS,
    CASTERS,
    histogram_of,
    no_histogram,
)
from photon_map.core.photons.emit import PHOTON_PATH, emit_photons
from photon_map.core.scene.builder import SceneBuilder, diffuse
from photon_map.tests import scenes
from photon_map.tests.core.lights.support import PLAIN
from photon_map.tests.statistics import integral, same_means

PASSES, COUNT = 40, 4096
NONE = no_histogram()
TURN = scenes.look_at((0, 0, 0), (1, 2, 3))[:3, :3]
HEIGHT = 2.0
#: Centre, radius and strength of two casters.
SPHERES = np.array([[0.0, 0.0, 0.0, 0.8, 1.0], [0.3, 0.2, 0.0, 0.3, 0.4]])


def emitted(builder, aimed=False, histogram=NONE):
    """Origins, directions, flux of (pass, photon); rays without power have flux 0."""
    scene = builder.build()
    centre = centre_of(scene)
    mesh = centred_mesh(scene, centre)
    lights = light_set(scene, mesh, centre)
    spheres = SPHERES - [*centre.origin, 0, 0]
    media = np.zeros((len(lights.power), 9), np.int32)
    shape = (PASSES, COUNT, 3)
    origins, directions = np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    flux = np.zeros(shape)
    for i in range(PASSES):
        paths = np.zeros(COUNT, PHOTON_PATH)
        alive = emit_photons(
            mesh, scene.materials, PLAIN, lights, media, spheres, histogram,
            lights.photon_cdf, aimed, 7, 2, i, 0, COUNT, COUNT, origins[i], directions[i],
            paths,
        )  # fmt: skip
        flux[i, :alive] = paths["flux"][:alive]
    return origins + centre.origin, directions.astype(float), flux, lights


def any_histogram(lights):
    """One that knows nothing: cells of very different density, the same for all lights."""
    density = np.random.default_rng(8).lognormal(0.0, 0.7, (1, CASTERS, BINS, BINS))
    return histogram_of(np.zeros(lights, np.int32), density)


def at(place):
    matrix = np.eye(4)
    matrix[:3, 3] = place
    return matrix


def builder(kind):
    b = SceneBuilder(kind)
    b.add_mesh("floor", *scenes.plane(3.0), b.add_material("floor", [diffuse(0.5)]))
    if kind in ("point", "sphere"):
        b.add_point_light("lamp", (0, 0, HEIGHT), 5.0, radius=0.4 * (kind == "sphere"))
    elif kind == "spot":
        b.add_spot_light("lamp", at((0, 0, HEIGHT)), 5.0, 0.6, blend=1.0)
    elif kind == "stretched spot":
        b.add_spot_light(
            "lamp", at((0, 0, HEIGHT)), 5.0, 0.6, blend=1.0, size_x=1.5, size_y=0.8
        )
    elif kind == "soft":
        b.add_point_light("lamp", (0, 0, HEIGHT), 5.0, radius=0.8, soft=1)
    elif kind in ("rectangle", "disk", "spread"):
        spread = 2.0 if kind == "spread" else math.pi
        b.add_area_light(
            "lamp", at((0, 0, HEIGHT)), 4.0, 1.0, 1.0, disk=kind == "disk", spread=spread
        )
    elif kind == "map":
        b.set_world(0.5, np.random.default_rng(4).random((6, 9, 3)) ** 4, rotation=TURN)
    elif kind == "faces":
        panel = scenes.plane(0.5, HEIGHT)
        b.add_mesh("panel", *panel, b.add_material("panel", emission=4.0))
    elif kind == "world":
        b.set_world(2.0)
    else:
        angle = 0.3 if kind == "sun" else 0.0
        b.add_sun_light("lamp", scenes.look_at((1, 0, 2), (0, 0, 0)), 3.0, angle=angle)
    return b


def total_flux(kind, radius):
    """Power that leaves the light [W]; of distant ones through the scene's disc."""
    smooth = integral(
        lambda c: (t := (c - math.cos(0.6)) / (1 - math.cos(0.6))) * t * (3 - 2 * t),
        math.cos(0.6),
        1.0,
    )
    return {
        "point": 4 * math.pi * 5,
        "sphere": 4 * math.pi * 5,
        "spot": 2 * math.pi * 5 * smooth,
        # A linear map S stretches the cone: its solid angle by the mean of det S / |S w|^3.
        "stretched spot": 5 * stretched_cone(1.5, 0.8),
        "soft": 4 * math.pi * 5,
        "spread": math.pi * 4,
        "map": 0.5 * map_integral() * math.pi * radius**2,
        "rectangle": math.pi * 4,
        "disk": math.pi * 4 * math.pi / 4,
        "faces": 2 * math.pi * 4,
        # Across each of its directions: more than the cosine-weighted irradiance.
        "sun": 3 * 2 / (1 + math.cos(0.15)) * math.pi * radius**2,
        "parallel sun": 3 * math.pi * radius**2,
        "world": 4 * math.pi * 2 * math.pi * radius**2,
    }[kind]


def stretched_cone(a, b):
    """Integral of the falloff over the directions of a cone stretched by ``a`` and ``b``."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    c = math.cos(0.6) + (1 - math.cos(0.6)) * (nodes + 1) / 2
    phi = (np.arange(128) + 0.5) / 128 * 2 * np.pi
    t = (c - math.cos(0.6)) / (1 - math.cos(0.6))
    share = weights * t * t * (3 - 2 * t) * (1 - math.cos(0.6)) / 2
    s = np.sqrt(1 - c * c)[:, None]
    length = np.sqrt((a * s * np.cos(phi)) ** 2 + (b * s * np.sin(phi)) ** 2 + c[:, None] ** 2)
    return float((share[:, None] * a * b / length**3).sum() * 2 * np.pi / 128)


def map_integral():
    """Integral of the map's first channel over all directions, from its definition."""
    texels = np.random.default_rng(4).random((6, 9, 3))[..., 0] ** 4
    n = 1200
    y = (np.arange(n) + 0.5) / n
    across = (np.arange(n) + 0.5) / n * 9 - 0.5
    above = y * 6 - 0.5
    i, j = np.floor(above).astype(int), np.floor(across).astype(int)
    t, s = (above - i)[:, None], across - j
    low = texels[i % 6][:, j % 9] * (1 - s) + texels[i % 6][:, (j + 1) % 9] * s
    high = texels[(i + 1) % 6][:, j % 9] * (1 - s) + texels[(i + 1) % 6][:, (j + 1) % 9] * s
    weight = np.cos((y - 0.5) * np.pi)[:, None]
    return float(((low * (1 - t) + high * t) * weight).sum() * (np.pi / n) * (2 * np.pi / n))


KINDS = [
    "stretched spot",
    "soft",
    "spread",
    "map",
    "point",
    "sphere",
    "spot",
    "rectangle",
    "disk",
    "faces",
    "sun",
    "parallel sun",
    "world",
]


@pytest.mark.parametrize("kind", KINDS)
def test_photons_carry_the_power_of_the_light(kind):
    _, _, flux, lights = emitted(builder(kind))
    per_pass = flux[:, :, 0].sum(axis=1)
    expected = total_flux(kind, lights.radius)
    variance = per_pass.var(ddof=1) / PASSES
    same_means(per_pass.mean(), variance, expected, floor=1e-6 * expected)


def plate_factor(x, y):
    def corner(a, b):
        p, q = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
        return (a / p * np.arctan(b / p) + b / q * np.arctan(a / q)) / (2 * np.pi)

    u0, u1, v0, v1 = ((s - o) / HEIGHT for o in (x, y) for s in (-0.5, 0.5))
    return corner(u1, v1) - corner(u0, v1) - corner(u1, v0) + corner(u0, v0)


def spread_irradiance(x, y):
    """Slats of a half spread of 1 rad before the unit square, point by point."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    total = 0 * x * y
    for a, wa in zip(nodes / 2, weights / 2, strict=True):
        for b, wb in zip(nodes / 2, weights / 2, strict=True):
            side2 = (x - a) ** 2 + (y - b) ** 2
            share = (1 - np.sqrt(side2) / HEIGHT / math.tan(1)) / (1 - 1 / math.tan(1))
            total = total + wa * wb * share * HEIGHT**2 / (side2 + HEIGHT**2) ** 2
    return 4.0 * total


def irradiance(kind, x, y):
    square = x * x + y * y + HEIGHT**2
    if kind == "soft":
        return 5.0 * HEIGHT / (np.sqrt(square) * (square + 0.8**2))
    if kind == "spread":
        return spread_irradiance(x, y)
    if kind == "stretched spot":
        c = HEIGHT / np.sqrt((x / 1.5) ** 2 + (y / 0.8) ** 2 + HEIGHT**2)
        t = np.clip((c - math.cos(0.6)) / (1 - math.cos(0.6)), 0, 1)
        return 5.0 * HEIGHT / square**1.5 * t * t * (3 - 2 * t)
    if kind in ("point", "sphere"):
        return 5.0 * HEIGHT / square**1.5
    if kind == "spot":
        t = np.clip((HEIGHT / np.sqrt(square) - math.cos(0.6)) / (1 - math.cos(0.6)), 0, 1)
        return 5.0 * HEIGHT / square**1.5 * t * t * (3 - 2 * t)
    if kind in ("rectangle", "faces"):
        return 4.0 * math.pi * plate_factor(x, y)
    if kind == "world":
        return 2.0 * math.pi + 0 * x * y
    return 3.0 * 2 / math.sqrt(5) + 0 * x * y


@pytest.mark.parametrize("aimed", [False, True, "by a histogram"])
@pytest.mark.parametrize("kind", [k for k in KINDS if k not in ("disk", "map")])
def test_photons_bring_the_irradiance_of_the_closed_form(kind, aimed):
    histogram = any_histogram(3) if aimed == "by a histogram" else NONE
    origins, directions, flux, lights = emitted(builder(kind), bool(aimed), histogram)
    down = directions[:, :, 2] < 0
    drop = np.where(down, directions[:, :, 2], -1.0)
    landing = origins - directions * (origins[:, :, 2] / drop)[:, :, None]
    if kind == "soft":
        beside = ((origins - (0, 0, HEIGHT)) ** 2).sum(axis=2)
        apart = ((landing - (0, 0, HEIGHT)) ** 2).sum(axis=2)
        seen = beside * (apart + 0.64) <= 0.64 * apart
        assert [
            reaches(lights, 0, tuple(o), tuple(p))
            for o, p in zip(origins[0, :99], landing[0, :99], strict=True)
        ] == list(seen[0, :99])
        down &= seen
    # A patch that lies inside of the first sphere: aimed photons cover all of it.
    bins, half = 6, 0.5
    arrived = np.array(
        [
            np.histogram2d(
                p[k, 0], p[k, 1], bins, ((-half, half), (-half, half)), weights=f[k, 0]
            )[0]
            for p, f, k in zip(landing, flux, down, strict=True)
        ]
    )
    edges = np.linspace(-half, half, bins + 1)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    place = (edges[1:] + edges[:-1])[:, None] / 2 + nodes * half / bins
    x, y = place[:, None, :, None], place[None, :, None, :]
    mean = np.einsum("xyij,i,j->xy", irradiance(kind, x, y) + 0 * x * y, weights, weights) / 4
    area = (2 * half / bins) ** 2
    variance = arrived.var(axis=0, ddof=1) / PASSES
    # Few passes: their variance is uncertain, so the level is that of a t-test's margin.
    same_means(arrived.mean(axis=0) / area, variance / area**2, mean, level=1e-3)
