"""Roughness from 0 to 1 through the whole engine: a caster and a receiver of each material.

Between a mirror and a diffuse surface the engine hands light over from caustic photons and
chains to the global map and final gathering (``narrow_share``). Where this were done wrongly
or abruptly, the mean would jump with the roughness, or the noise would have an island. Both
are measured here; the tests beside this file and ``make accuracy`` judge and plot them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photon_map.core import Settings, render
from photon_map.core.reference.path_tracer import trace
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse
from photon_map.core.scene.closures import glossy, principled, rough_glass
from photon_map.core.scene.scene import Scene
from photon_map.tests import scenes

ROUGHNESS = (0.0, 0.02, 0.05, 0.08, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.7, 1.0)
SIZE = 16


def metal(roughness: float) -> Any:
    """A rough mirror of single scattering."""
    return glossy((0.9, 0.8, 0.7), roughness, multiscatter=False)


def glass(roughness: float) -> Any:
    """Rough glass of single scattering."""
    return rough_glass(1.5, roughness, (0.95, 1.0, 0.9), multiscatter=False)


def coated(roughness: float) -> Any:
    """Principled: a strong specular layer of this roughness over a dark diffuse body."""
    return principled(color=(0.3, 0.2, 0.1), roughness=roughness, ior=2.0)


@dataclass(frozen=True)
class Sweep:
    """A scene with one material of changing roughness; ``reference``: it can render it."""

    name: str
    says: str
    build: Callable[[float], Scene]
    reference: bool = True


def emitter(b: SceneBuilder, radiance: float, eye: Any, target: Any, side: float) -> None:
    """A glowing square at ``eye`` that faces ``target``, its back covered.

    A face and no lamp: the reference finds those by light sampling and by scattering.
    """
    matrix = scenes.look_at(eye, target, up=(0.3, 0.5, 0.2))
    glow = b.add_material("glow", [diffuse(0.0)], emission=radiance)
    black = b.add_material("black", [diffuse(0.0)])
    corners = np.array([(-1, -1, 0, 1), (1, -1, 0, 1), (1, 1, 0, 1), (-1, 1, 0, 1)], float)
    for name, row, size, back in (("lamp", glow, 0.5, 0.0), ("cover", black, 0.6, 5e-4)):
        placed = corners * (size * side, size * side, 1, 1) + (0, 0, back, 0)
        b.add_mesh(name, *scenes.quad(*(placed @ matrix.T)[:, :3]), row)


def reflecting_caster(closure: Any) -> Scene:
    """A wall reflects a lamp's light onto a floor that the lamp does not reach by itself."""
    b = SceneBuilder("reflecting caster")
    b.add_mesh("floor", *scenes.plane(6.0), b.add_material("floor", [diffuse(0.7)]))
    row = b.add_material("tested", [], closures=[closure])
    wall = scenes.quad((1.2, 0.7, 0.2), (1.2, -0.7, 0.2), (1.0, -0.7, 1.6), (1.0, 0.7, 1.6))
    b.add_mesh("wall", *wall, row)
    emitter(b, 10.0, (-0.4, 0, 1.3), (1.1, 0, 1.5), 0.8)
    eye, target = (-1.6, -1.2, 2.4), (-1.5, 0.0, 0.0)
    b.set_camera(scenes.camera(eye, target, SIZE, SIZE, fov=np.radians(45)))
    return b.build()


def refracting_caster(closure: Any) -> Scene:
    """A slab under a lamp: what is seen of the floor is lit through it alone."""
    b = SceneBuilder("refracting caster")
    b.add_mesh("floor", *scenes.plane(6.0), b.add_material("floor", [diffuse(0.7)]))
    row = b.add_material("tested", [], closures=[closure])
    b.add_mesh("slab", *scenes.box((-1.2, -1.2, 0.9), (1.2, 1.2, 1.2)), row)
    emitter(b, 10.0, (0, 0, 2.0), (0, 0, 0), 0.8)
    eye, target = (0.0, -1.6, 0.6), (0.0, 0.0, 0.0)
    b.set_camera(scenes.camera(eye, target, SIZE, SIZE, fov=np.radians(45)))
    return b.build()


def receiver(closure: Any, thick: bool) -> Scene:
    """A plate before a glowing wall, with the caustic of a glass ball on it and behind it."""
    b = SceneBuilder("receiver")
    white = b.add_material("white", [diffuse(0.7)])
    row = b.add_material("tested", [], closures=[closure])
    b.add_mesh("ground", *scenes.plane(4.0, -0.25), white)
    back = scenes.quad((-3, 1.6, -0.25), (3, 1.6, -0.25), (3, 1.6, 2.5), (-3, 1.6, 2.5))
    b.add_mesh("back", *back, white)
    if thick:
        b.add_mesh("plate", *scenes.box((-1, -1, -0.1), (1, 1, 0.0)), row)
    else:
        b.add_mesh("plate", *scenes.plane(1.0), row)
    emitter(b, 3.0, (0.7, 1.5, 0.5), (0.7, 0, 0.5), 0.8)
    centre = (-0.4, 0.3, 0.55)
    ball = scenes.sphere(centre, 0.25, 3)
    normals = scenes.sphere_normals(ball, centre)
    b.add_mesh("ball", *ball, b.add_material("ball", [dielectric(1.5)]), normals)
    emitter(b, 20.0, (-0.6, -0.9, 1.8), centre, 0.8)
    eye, target = (0.0, -2.4, 1.2), (0.0, 0.1, 0.0)
    b.set_camera(scenes.camera(eye, target, SIZE, SIZE, fov=np.radians(38)))
    return b.build()


SWEEPS = {
    sweep.name: sweep
    for sweep in (
        Sweep("metal caster", "a metal wall lights a floor",
              lambda r: reflecting_caster(metal(r))),
        Sweep("glass caster", "a floor is lit through a slab of rough glass",
              lambda r: refracting_caster(glass(r))),
        Sweep("principled caster", "a wall of Principled lights a floor",
              lambda r: reflecting_caster(coated(r)), reference=False),
        Sweep("metal receiver", "a metal plate shows a bright wall and caustics",
              lambda r: receiver(metal(r), False)),
        Sweep("glass receiver", "a plate of rough glass shows a bright wall and caustics",
              lambda r: receiver(glass(r), True)),
        Sweep("principled receiver", "a plate of Principled shows a bright wall and caustics",
              lambda r: receiver(coated(r), False), reference=False),
    )
}  # fmt: skip


@dataclass(frozen=True)
class Point:
    """What was measured at one roughness.

    ``mean`` of the image and its standard ``error``, over seeds; ``noise``: relative MSE of
    one render, its bias by blur not counted; ``truth`` and ``truth_error``: the reference's
    mean, NaN where it has none; ``image`` (h, w, 3): the mean over seeds.
    """

    roughness: float
    mean: float
    error: float
    noise: float
    truth: float
    truth_error: float
    image: NDArray[np.float64]


def measure(
    sweep: Sweep, roughness: float, passes: int = 8, seeds: int = 8, samples: int = 0,
    first_seed: int = 0, **options: Any,
) -> Point:  # fmt: skip
    """Render one roughness ``seeds`` times, and by the reference with ``samples`` if any."""
    scene = sweep.build(roughness)
    images = np.stack(
        [picture(scene, passes, first_seed + seed, **options) for seed in range(seeds)]
    )
    means = images.mean(axis=(1, 2, 3))
    middle = images.mean(axis=0)
    noise = images.var(axis=0, ddof=1).mean() / middle.mean() ** 2
    truth, truth_error = np.nan, np.nan
    if samples and sweep.reference:
        found = trace(scene, samples, seed=1)
        truth = float(found["combined"].mean())
        truth_error = float(np.sqrt(found.variance["combined"].mean(axis=2).sum()))
        truth_error /= found["combined"][..., 0].size
    return Point(
        roughness, float(means.mean()), float(means.std(ddof=1) / np.sqrt(seeds)),
        float(noise), truth, truth_error, middle,
    )  # fmt: skip


def picture(scene: Scene, passes: int, seed: int, **options: Any) -> NDArray[np.float64]:
    """The combined layer (h, w, 3) of one render."""
    chosen: dict[str, Any] = {"pixel_filter": "BOX", "filter_width": 1.0, **options}
    *_, update = render(scene, Settings(passes=passes, seed=seed, **chosen))
    assert update.film.statistics.non_finite == 0
    return np.array(update.film.resolve("combined")[..., :3], np.float64)
