"""A panel that glows by a picture: light sampling, hits and photons agree with closed forms."""

from __future__ import annotations

import numpy as np

from photon_map.core import Settings, render
from photon_map.core.photon_pass import Batch, trace_batch
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import SceneBuilder, diffuse
from photon_map.core.scene.closures import closure
from photon_map.core.scene.tables import ClosureKind, ImageKind
from photon_map.tests import scenes
from photon_map.tests.statistics import same_means

LEFT, RIGHT = np.array([8.0, 1.0, 0.0]), np.array([0.0, 1.0, 3.0])
HEIGHT = 2.0
OPTIONS = {"passes": 64, "pixel_filter": "BOX", "filter_width": 1.0}


def panel():
    """A unit square at ``HEIGHT``, its left half ``LEFT``, its right half ``RIGHT``."""
    b = SceneBuilder("glowing picture")
    b.add_mesh("floor", *scenes.plane(0.7), b.add_material("floor", [diffuse(0.5)]))
    pixels = np.ones((1, 2, 4))
    pixels[0, :, :3] = LEFT, RIGHT
    texture = b.pictures.add_texture(
        b.pictures.add_image(pixels, ImageKind.FLOATS), closest=True
    )
    shader = closure(ClosureKind.EMISSION, emission=(1.0, texture))
    glow = b.add_material("glow", emission=(LEFT + RIGHT) / 2, closures=[shader])
    points, faces = scenes.plane(0.5, HEIGHT)
    b.add_mesh("panel", points, faces, glow, uvs=points[faces][:, :, :2] + 0.5)
    b.set_camera(scenes.camera((0, 0, 1.5), (0, 0, 0), 6, 6, up=(0, 1, 0), fov=0.6))
    return b.build()


def half_irradiance(x, y, low, high):
    """Of unit radiance from the part low < x < high of the panel."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    total = 0 * x * y
    for a, wa in zip(nodes, weights, strict=True):
        for b, wb in zip(nodes / 2, weights / 2, strict=True):
            u = (low + high) / 2 + (high - low) / 2 * a
            square = (x - u) ** 2 + (y - b) ** 2 + HEIGHT**2
            total = total + wa * wb * (high - low) / 2 * HEIGHT**2 / square**2
    return total


def test_direct_light_of_a_glowing_picture():
    scene = panel()
    films = [list(render(scene, Settings(seed=k, **OPTIONS)))[-1].film for k in range(6)]
    runs = np.array([film.resolve("direct") for film in films], float)
    parts = [
        scenes.floor_mean(scene, lambda x, y, ab=ab: half_irradiance(x, y, *ab), 4)
        for ab in ((-0.5, 0.0), (0.0, 0.5))
    ]
    expected = 0.5 / np.pi * (parts[0][..., None] * LEFT + parts[1][..., None] * RIGHT)
    same_means(runs.mean(axis=0), runs.var(axis=0, ddof=1) / 6, expected, freedom=5)


def test_photons_of_a_glowing_picture_carry_its_colours():
    settings = Settings(photon_depth=1)
    prepared = prepare(panel(), settings)
    flux, place = [], []
    for i in range(20):
        walk = trace_batch(prepared, settings, i, Batch(False, 0, 4096, 4096))
        flux.append(walk.photons["flux"].sum(axis=0, dtype=np.float64))
        place.append(walk.photons["position"][:, 0].astype(float) @ walk.photons["flux"])
    nodes, weights = np.polynomial.legendre.leggauss(8)
    x, y = np.meshgrid(0.7 * nodes, 0.7 * nodes)
    area = 0.49 * np.outer(weights, weights)
    parts = [half_irradiance(x, y, *ab) for ab in ((-0.5, 0.0), (0.0, 0.5))]
    for found, weight in ((np.array(flux), 1.0), (np.array(place), x)):
        expected = sum(
            (part * area * weight).sum() * colour
            for part, colour in zip(parts, (LEFT, RIGHT), strict=True)
        )
        same_means(found.mean(axis=0), found.var(axis=0, ddof=1) / 20, expected, freedom=19)
