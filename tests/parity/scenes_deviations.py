"""Scenes in which Cycles is not right, each with a closed form of its image's mean.

They are listed apart in the document: ours has to meet the closed form within the suite's
0.5 %, and Cycles' distance from it is shown beside.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.parity.case import case

GLASS, WATER = 1.5, 1.33


def reflectance(one: float, other: float) -> float:
    """Fresnel's at normal incidence between two indices."""
    return ((one - other) / (one + other)) ** 2


def overhead(stage: Any, height: float, target: float) -> None:
    """An orthographic camera on the z axis that sees 0.4 m of what lies in its way."""
    stage.camera((0.0, 0.0, height), (0.0, 0.0, target), type="ORTHO", ortho_scale=0.4)


def slab(stage: Any, material: Any, low: float, high: float, wide: float = 20.0) -> None:
    """A closed block ``wide`` metres wide from z = ``low`` to ``high``."""
    stage.cube(material, 1.0, (0.0, 0.0, (low + high) / 2)).scale = (wide, wide, high - low)


def stack() -> float:
    """Light of radiance 1 through air, glass, water, air, with all reflections between."""
    a, b, c = reflectance(1.0, GLASS), reflectance(GLASS, WATER), reflectance(WATER, 1.0)
    above = (1 - a) * (1 - b) / (1 - a * b)
    back = b + (1 - b) ** 2 * a / (1 - a * b)
    return above * (1 - c) / (1 - back * c)


@case(
    "glass on water, the bodies overlap by 0.1 m",
    passes=256, samples=512, truth=stack,
    deviation="Cycles takes every surface as one to air, whatever it lies in",
)  # fmt: skip
def overlapping_bodies(stage: Any) -> None:
    overhead(stage, 4.0, 0.0)
    stage.square(stage.glow(1.0, 1.0, 1.0, 1.0), 20.0, (0.0, 0.0, -1.0))
    for ior, low, high in ((GLASS, 1.0, 2.0), (WATER, 0.1, 1.1)):
        body = stage.material("BsdfGlass", Color=(1.0, 1.0, 1.0), Roughness=0.0, IOR=ior)
        slab(stage, body, low, high)


def under_water() -> float:
    """Radiance inside of a slab under a sky of radiance 1: n^2 times as high."""
    return WATER**2 / (1.0 + reflectance(1.0, WATER))


@case(
    "camera inside of water that looks up",
    passes=256, samples=512, truth=under_water,
    deviation="Cycles leaves out that radiance is n^2 times as high inside of a medium",
)  # fmt: skip
def camera_under_water(stage: Any) -> None:
    overhead(stage, -0.5, 5.0)
    stage.square(stage.glow(1.0, 1.0, 1.0, 1.0), 20.0, (0.0, 0.0, 1.0), (180.0, 0.0, 0.0))
    body = stage.material("BsdfGlass", Color=(1.0, 1.0, 1.0), Roughness=0.0, IOR=WATER)
    slab(stage, body, -1.0, 0.0)


def under_glass() -> float:
    """Radiance of albedo 0.5 under a sun of 1 W/m^2 through a pane, all its reflections.

    The floor is small and the pane far: what it sends back is below 0.03 %.
    """
    r = reflectance(1.0, GLASS)
    through = (1 - r) / (1 + r)
    return through * 0.5 / float(np.pi)


@case(
    "sun of angle 0 through a glass pane high above the floor",
    passes=64, samples=64, truth=under_glass,
    deviation="Cycles finds no way from a lamp without size through glass: its floor is dark",
)  # fmt: skip
def sun_through_pane(stage: Any) -> None:
    overhead(stage, 2.0, 0.0)
    stage.square(stage.diffuse(0.5, 0.5, 0.5), 1.0)
    body = stage.material("BsdfGlass", Color=(1.0, 1.0, 1.0), Roughness=0.0, IOR=GLASS)
    slab(stage, body, 6.0, 6.2, 2.0)
    stage.lamp("SUN", (0.0, 0.0, 9.0), energy=1.0, angle=0.0)


def white() -> float:
    """Whatever neither swallows light nor adds any is not to be told from its surroundings."""
    return 1.0


@case(
    "clear rough glass with multiple scattering in a white furnace",
    passes=64, samples=256, truth=white,
    deviation="Cycles' tables give back less than single scattering loses",
)  # fmt: skip
def multiscatter_furnace(stage: Any) -> None:
    stage.camera((0.0, -4.5, 1.0), (0.0, 0.0, 0.0))
    stage.world((1.0, 1.0, 1.0))
    glass = {"Color": (1.0, 1.0, 1.0), "Roughness": 0.6, "IOR": 1.5}
    stage.ball(stage.material("BsdfGlass", distribution="MULTI_GGX", **glass))
