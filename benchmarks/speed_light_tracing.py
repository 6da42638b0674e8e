"""Mitsuba's light tracer, the judge of pixels that see nothing but diffuse surfaces.

Paths that begin at a lamp and are connected to the camera find every caustic there without
any blur; what is seen in glass or mirrors they never find. Most of a picture is no caustic:
with the lamps' light that meets glass or mirror taken away (such surfaces black), a path
tracer knows the rest far better. So the image is

    path(black) + light(scene) - light(black),

whose last two, with the same random numbers, are equal where no caustic is. Suns turn from
image to image by chance within their disk.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import speed_mitsuba
from measure import Image
from speed_mitsuba import color, picture, scene_dict
from speed_parts import Matter, Parts, parts_of, sun_frame

from photon_map.core import Scene
from photon_map.core.scene.tables import LightKind

#: Samples a pixel of one image: light paths, and camera paths of the scene in black.
LIGHT, CAMERA = 64, 32
BLACK = Matter("black", "diffuse", (0.0, 0.0, 0.0))


def version() -> str:
    """Name, version and mode."""
    return speed_mitsuba.version()


def snapshots(
    scene: Scene, engine: str, times: Sequence[float], seed: int, threads: int, ready: Any
) -> Iterator[tuple[float, Image]]:
    """Seconds and image (h, w, 3), row 0 at the top, soon after each of ``times``."""
    speed_mitsuba.choose_variant()
    parts = parts_of(scene)
    with tempfile.TemporaryDirectory() as folder:
        camera_paths = mi.load_dict(scene_dict(blackened(parts), Path(folder)))
        pair = [mi.load_dict(light_dict(p, Path(folder))) for p in (parts, blackened(parts))]
    random = np.random.default_rng(seed)
    aim(pair, parts, random)
    picture(camera_paths, CAMERA, 0)
    for model in pair:
        picture(model, LIGHT, 0)
    ready()
    total = np.zeros((parts.camera.height, parts.camera.width, 3))
    count, begin = 0, time.perf_counter()
    for at in times:
        while count == 0 or time.perf_counter() - begin < at:
            number = 100_003 * (seed + 1) + count
            aim(pair, parts, random)
            total += picture(camera_paths, CAMERA, number)
            total += picture(pair[0], LIGHT, number) - picture(pair[1], LIGHT, number)
            count += 1
        yield time.perf_counter() - begin, total / count


def blackened(parts: Parts) -> Parts:
    """``parts`` with black for glass and mirrors."""
    surfaces = tuple(
        surface
        if surface.matter.kind in ("diffuse", "glow")
        else replace(surface, matter=BLACK)
        for surface in parts.surfaces
    )
    return replace(parts, surfaces=surfaces)


def light_dict(parts: Parts, folder: Path) -> dict[str, Any]:
    """The scene for light paths; suns are parallel light, which ``aim`` turns."""
    suns = [row["kind"] == LightKind.SUN for row in parts.lamps]
    made = scene_dict(
        replace(parts, lamps=tuple(r for r in parts.lamps if not is_sun(r))), folder
    )
    for i in np.flatnonzero(suns):
        made[f"sun{i}"] = {
            "type": "directional",
            "irradiance": color(parts.lamps[i]["emission"]),
        }
    made["integrator"] = {"type": "ptracer", "max_depth": speed_mitsuba.DEPTH, "rr_depth": 20}
    return made


def is_sun(row: Any) -> bool:
    """Whether a row of the light table is a sun."""
    return bool(row["kind"] == LightKind.SUN)


def aim(pair: Sequence[Any], parts: Parts, random: np.random.Generator) -> None:
    """Turn the suns of both models to the same place within their disks."""
    for i in (k for k, row in enumerate(parts.lamps) if is_sun(row)):
        frame = sun_frame(parts.lamps[i], random)
        for model in pair:
            values = mi.traverse(model)
            values[f"sun{i}.to_world"] = mi.Transform4f(frame)
            values.update()
