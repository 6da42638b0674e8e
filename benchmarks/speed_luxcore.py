"""LuxCore as a peer: path with photon cache, bidirectional, with and without merging.

Its clock starts with the session: building its tree, photon caches and light paths count.
What was learnt of it stands in ``docs/benchmarks.md``.
"""

from __future__ import annotations

import contextlib
import math
import os
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyluxcore
from measure import Image
from speed_parts import Matter, Parts, lamp_corners, parts_of

from photon_map.core import Scene
from photon_map.core.scene.tables import LightKind

DEPTH = 32
#: Between two looks at the clock [s].
PAUSE = 0.02

DEPTH_OF_PHOTONS = "path.photongi.photon.maxdepth"


def cached_path(
    size: float, photons: int, radius: float, least: float, samples: int
) -> dict[str, Any]:
    """Path tracing that leaves caustics to photons; radii are shares of ``size`` [m].

    New photons come every so many ``samples`` a pixel.
    """
    return {
        "renderengine.type": "PATHCPU",
        "sampler.type": "SOBOL",
        "path.photongi.sampler.type": "RANDOM",
        "path.photongi.photon.maxcount": photons,
        DEPTH_OF_PHOTONS: DEPTH,
        # Left at 0, LuxCore first looks for seconds for a good one.
        "path.photongi.visibility.lookup.radius": 0.01 * size,
        "path.photongi.visibility.maxsamplecount": 1 << 17,
        "path.photongi.indirect.enabled": False,
        "path.photongi.caustic.enabled": True,
        "path.photongi.caustic.maxsize": photons,
        "path.photongi.caustic.lookup.radius": radius * size,
        "path.photongi.caustic.updatespp": samples,
        "path.photongi.caustic.updatespp.radiusreduction": 0.96,
        "path.photongi.caustic.updatespp.minradius": least * size,
    }


def modes(size: float) -> dict[str, dict[str, Any]]:
    """What each mode sets, for a scene of ``size`` metres; the last two are for references."""
    return {
        "luxcore_path": cached_path(size, 200_000, 0.004, 0.0002, 8),
        "luxcore_fine": cached_path(size, 500_000, 0.0016, 0.0016, 2),
        "luxcore_finer": cached_path(size, 500_000, 0.0004, 0.0004, 2),
        "luxcore_bidir": {"renderengine.type": "BIDIRCPU", "sampler.type": "SOBOL"},
        "luxcore_vm": {
            "renderengine.type": "BIDIRVMCPU",
            "sampler.type": "RANDOM",
            "sampler.random.bucketsize": 1,
            "bidirvm.lightpath.count": 16384,
            "bidirvm.startradius.scale": 0.003,
            "bidirvm.alpha": 0.9,
        },
    }


def snapshots(
    scene: Scene, engine: str, times: Sequence[float], seed: int, threads: int, ready: Any
) -> Iterator[tuple[float, Image]]:
    """Seconds and image (h, w, 3), row 0 at the top, soon after each of ``times``."""
    parts = parts_of(scene)
    with tempfile.TemporaryDirectory() as folder, quiet():
        pyluxcore.Init()
        model = pyluxcore.Scene()
        model.Parse(properties(scene_values(parts, Path(folder))))
        settings = common(parts, seed, threads) | modes(parts.size)[engine]
        if DEPTH_OF_PHOTONS in settings:
            # Sessions of all seeds would begin with the same photons: they have seeds of
            # their own. Paths of another length take other numbers from the same stream.
            settings[DEPTH_OF_PHOTONS] += seed % 64
        session = pyluxcore.RenderSession(pyluxcore.RenderConfig(properties(settings), model))
        ready()
        begin = time.perf_counter()
        session.Start()
        waiting = list(times)
        while waiting:
            session.UpdateStats()
            time.sleep(PAUSE)
            seconds = time.perf_counter() - begin
            if seconds >= waiting[0]:
                while waiting and waiting[0] <= seconds:
                    waiting.pop(0)
                image = film_image(session, parts)
                if image.any() or not waiting:
                    yield seconds, image
        session.Stop()


def film_image(session: Any, parts: Parts) -> Image:
    """The image so far (h, w, 3), row 0 at the top.

    What LuxCore hands out stands one row too low: it renders one more and loses the first.
    """
    height, width = parts.camera.height + 1, parts.camera.width
    flat = np.zeros(height * width * 3, np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, flat)
    image: Image = flat.reshape(height, width, 3).astype(np.float64)[::-1][1:]
    return image


def version() -> str:
    """Name and version of the engine."""
    return f"LuxCore {pyluxcore.Version()}"


def common(parts: Parts, seed: int, threads: int) -> dict[str, Any]:
    """Settings of every mode: unclamped, box filter, deep."""
    return {
        "renderengine.seed": seed + 1,
        "native.threads.count": threads,
        "film.width": parts.camera.width,
        "film.height": parts.camera.height + 1,
        "film.filter.type": "NONE",
        "film.outputs.safesave": False,
        "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": "image.exr",
        "film.imagepipelines.0.0.type": "NOP",
        "path.pathdepth.total": DEPTH,
        "path.pathdepth.diffuse": DEPTH,
        "path.pathdepth.glossy": DEPTH,
        "path.pathdepth.specular": DEPTH,
        "light.maxdepth": DEPTH,
        "path.maxdepth": DEPTH,
        # Its bidirectional modes are biased where roulette begins early.
        "path.russianroulette.depth": 20,
        "light.russianroulette.depth": 20,
        "path.clamping.variance.maxvalue": 0.0,
        "path.hybridbackward.enable": False,
    }


def properties(values: dict[str, Any]) -> Any:
    """LuxCore's own kind of dictionary."""
    made = pyluxcore.Properties()
    for key, value in values.items():
        listed = value if isinstance(value, list) else [value]
        made.Set(pyluxcore.Property(key, listed))
    return made


def scene_values(parts: Parts, folder: Path) -> dict[str, Any]:
    """The scene; meshes go as PLY files into ``folder``."""
    values = camera_values(parts)
    for i, surface in enumerate(parts.surfaces):
        path = folder / f"{i}.ply"
        surface.write_ply(path)
        values |= {f"scene.shapes.s{i}.type": "mesh", f"scene.shapes.s{i}.ply": str(path)}
        values |= material_values(f"m{i}", surface.matter)
        values |= {
            f"scene.objects.o{i}.shape": f"s{i}",
            f"scene.objects.o{i}.material": f"m{i}",
        }
    for i, row in enumerate(parts.lamps):
        values |= lamp_values(i, row, folder)
    if parts.world_map is not None:
        values |= sky_values(parts, folder)
    elif parts.world.any():
        values["scene.lights.sky.type"] = "constantinfinite"
        values["scene.lights.sky.color"] = [float(c) for c in parts.world]
    return values


def camera_values(parts: Parts) -> dict[str, Any]:
    """A camera of the same view and lens."""
    camera = parts.camera
    eye, forward, up = camera.matrix[:3, 3], -camera.matrix[:3, 2], camera.matrix[:3, 1]
    fov = 2 * math.degrees(math.atan(camera.sensor_width / (2 * camera.lens)))
    return {
        "scene.camera.type": "perspective",
        "scene.camera.lookat.orig": [float(x) for x in eye],
        "scene.camera.lookat.target": [float(x) for x in eye + forward],
        "scene.camera.up": [float(x) for x in up],
        "scene.camera.fieldofview": fov,
        "scene.camera.screenwindow": [-1.0, 1.0, -1.0 - 2.0 / camera.height, 1.0],
        "scene.camera.autovolume.enable": False,
        "scene.camera.lensradius": camera.lens_radius,
        "scene.camera.focaldistance": camera.focus_distance,
        "scene.camera.autofocus.enable": False,
    }


def material_values(name: str, matter: Matter) -> dict[str, Any]:
    """A material by its properties."""
    key, color = f"scene.materials.{name}", [float(c) for c in matter.color]
    if matter.kind == "diffuse":
        return {f"{key}.type": "matte", f"{key}.kd": color}
    if matter.kind == "mirror":
        return {f"{key}.type": "mirror", f"{key}.kr": color}
    if matter.kind == "glass":
        return {
            f"{key}.type": "glass",
            f"{key}.kr": color,
            f"{key}.kt": color,
            f"{key}.interiorior": matter.ior,
            f"{key}.exteriorior": 1.0,
        }
    if matter.kind == "glow":
        return {f"{key}.type": "matte", f"{key}.kd": [0.0] * 3, f"{key}.emission": color}
    raise ValueError(f"LuxCore's {matter.kind} is another one than ours")


def lamp_values(i: int, row: Any, folder: Path) -> dict[str, Any]:
    """A lamp: rectangles are meshes that glow, suns distant lights."""
    emission = [float(c) for c in row["emission"]]
    if row["kind"] == LightKind.RECTANGLE:
        shape, key = f"scene.shapes.l{i}", f"scene.objects.l{i}"
        corners = [float(x) for x in lamp_corners(row).ravel()]
        made = {
            f"{shape}.type": "inlinedmesh",
            f"{shape}.vertices": corners,
            f"{shape}.faces": [0, 1, 2, 0, 2, 3],
        }
        made |= material_values(f"l{i}", Matter("", "glow", tuple(emission)))
        return made | {f"{key}.shape": f"l{i}", f"{key}.material": f"l{i}"}
    key = f"scene.lights.l{i}"
    if row["kind"] == LightKind.POINT:
        return {
            f"{key}.type": "point",
            f"{key}.position": [float(x) for x in row["position"]],
            # Its colour is the power, over 4 pi.
            f"{key}.color": [4 * math.pi * c for c in emission],
        }
    if row["kind"] == LightKind.SUN:
        half = float(row["angle"]) / 2.0
        return {
            f"{key}.type": "distant",
            f"{key}.direction": [float(-x) for x in row["axis_z"]],
            f"{key}.theta": math.degrees(half),
            # Its colour is the radiance of the disk.
            f"{key}.color": [c / (math.pi * math.sin(half) ** 2) for c in emission],
        }
    raise ValueError("LuxCore gets no round lamps here")


def sky_values(parts: Parts, folder: Path) -> dict[str, Any]:
    """The surroundings as a picture file."""
    assert parts.world_map is not None
    path = folder / "sky.pfm"
    # Its columns run the other way round, and begin half a turn on.
    mirrored = np.roll(parts.world_map[:, ::-1], parts.world_map.shape[1] // 2, axis=1)
    texels = np.ascontiguousarray(mirrored * parts.world, "<f4")
    with open(path, "wb") as file:
        file.write(f"PF\n{texels.shape[1]} {texels.shape[0]}\n-1.0\n".encode())
        file.write(texels.tobytes())
    return {
        "scene.lights.sky.type": "infinite",
        "scene.lights.sky.file": str(path),
        "scene.lights.sky.gamma": 1.0,
        "scene.lights.sky.colorspace": "nop",
    }


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Nothing of LuxCore's many lines."""
    kept, kept_error = os.dup(1), os.dup(2)
    with open(os.devnull, "wb") as sink:
        os.dup2(sink.fileno(), 1)
        os.dup2(sink.fileno(), 2)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.dup2(kept_error, 2)
        for number in (kept, kept_error):
            os.close(number)
