"""Mitsuba 3's path tracer as a peer, in its LLVM mode where LLVM is found.

Images of some samples each are averaged; the kernel is compiled before the clock starts.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from measure import Image
from speed_parts import Matter, Parts, lamp_corners, parts_of, sun_disk

from photon_map.core import Scene
from photon_map.core.scene.tables import LightKind

DEPTH = 33
#: Seconds that one image of the average takes, about.
CHUNK = 0.3
MOST_SAMPLES = 64


def choose_variant() -> None:
    """LLVM where it works, else the slow plain mode."""
    try:
        mi.set_variant("llvm_ad_rgb")
        dr.eval(mi.Float(1.0) + 1.0)
    except Exception:
        mi.set_variant("scalar_rgb")


def version() -> str:
    """Name, version and mode."""
    return f"Mitsuba {mi.__version__} {mi.variant()}"


def snapshots(
    scene: Scene, engine: str, times: Sequence[float], seed: int, threads: int, ready: Any
) -> Iterator[tuple[float, Image]]:
    """Seconds and image (h, w, 3), row 0 at the top, soon after each of ``times``."""
    choose_variant()
    if mi.variant().startswith("llvm"):
        dr.set_thread_count(threads)
    else:
        mi.set_thread_count(threads) if hasattr(mi, "set_thread_count") else None
    parts = parts_of(scene)
    with tempfile.TemporaryDirectory() as folder:
        model = mi.load_dict(scene_dict(parts, Path(folder)))
    samples = 1
    while samples < MOST_SAMPLES:
        picture(model, samples, 0)
        begin = time.perf_counter()
        picture(model, samples, 1)
        spent = time.perf_counter() - begin
        if spent > CHUNK / 2:
            break
        samples *= 2
    picture(model, samples, 0)
    ready()
    total = np.zeros((parts.camera.height, parts.camera.width, 3))
    count, begin = 0, time.perf_counter()
    for at in times:
        while count == 0 or time.perf_counter() - begin < at:
            total += picture(model, samples, 100_003 * (seed + 1) + count)
            count += 1
        yield time.perf_counter() - begin, total / count


def picture(model: Any, samples: int, seed: int) -> Image:
    """One image (h, w, 3) of ``samples`` a pixel."""
    return np.array(mi.render(model, spp=samples, seed=seed), dtype=np.float64)


def scene_dict(parts: Parts, folder: Path) -> dict[str, Any]:
    """The scene; meshes go as PLY files into ``folder``."""
    made: dict[str, Any] = {"type": "scene", "camera": camera_dict(parts)}
    made["integrator"] = {"type": "path", "max_depth": DEPTH, "rr_depth": 20}
    middle = np.zeros(3)
    for i, surface in enumerate(parts.surfaces):
        path = folder / f"{i}.ply"
        surface.write_ply(path)
        middle = surface.vertices.mean(axis=0)
        row = {"type": "ply", "filename": str(path), "face_normals": surface.normals is None}
        made[f"surface{i}"] = row | matter_dict(surface.matter)
    for i, row in enumerate(parts.lamps):
        made[f"lamp{i}"] = lamp_dict(row, parts, middle)
    if parts.world_map is not None:
        made["sky"] = sky_dict(parts)
    elif parts.world.any():
        made["sky"] = {"type": "constant", "radiance": color(parts.world)}
    return made


def color(values: Any) -> dict[str, Any]:
    """Linear RGB."""
    return {"type": "rgb", "value": [float(c) for c in values]}


def camera_dict(parts: Parts) -> dict[str, Any]:
    """A camera of the same view and lens; Mitsuba's looks along +z with x to the left."""
    camera = parts.camera
    made = {
        "type": "thinlens" if camera.lens_radius > 0 else "perspective",
        "fov": 2 * math.degrees(math.atan(camera.sensor_width / (2 * camera.lens))),
        "fov_axis": "x",
        "near_clip": 1e-3,
        "far_clip": 1e6,
        "to_world": mi.ScalarTransform4f(camera.matrix @ np.diag([-1.0, 1.0, -1.0, 1.0])),
        "sampler": {"type": "independent"},
        "film": {
            "type": "hdrfilm",
            "width": camera.width,
            "height": camera.height,
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "box"},
        },
    }
    if camera.lens_radius > 0:
        made |= {
            "aperture_radius": camera.lens_radius,
            "focus_distance": camera.focus_distance,
        }
    return made


def matter_dict(matter: Matter) -> dict[str, Any]:
    """The material of a shape."""
    black = {"type": "diffuse", "reflectance": color((0, 0, 0))}
    if matter.kind == "glow":
        light = {"type": "area", "radiance": color(matter.color)}
        return {"bsdf": black, "emitter": light}
    if matter.kind == "diffuse":
        inner: dict[str, Any] = {"type": "diffuse", "reflectance": color(matter.color)}
        return {"bsdf": {"type": "twosided", "nested": inner}}
    if matter.kind == "mirror":
        inner = {
            "type": "conductor",
            "material": "none",
            "specular_reflectance": color(matter.color),
        }
        return {"bsdf": {"type": "twosided", "nested": inner}}
    glass = {"int_ior": matter.ior, "ext_ior": 1.0}
    tint = {
        "specular_reflectance": color(matter.color),
        "specular_transmittance": color(matter.color),
    }
    if matter.kind == "glass":
        return {"bsdf": {"type": "dielectric", **glass, **tint}}
    rough = {"type": "roughdielectric", "distribution": "ggx", "alpha": matter.roughness}
    return {"bsdf": rough | glass | tint}


def lamp_dict(row: Any, parts: Parts, middle: Any) -> dict[str, Any]:
    """A lamp; suns are far disks."""
    if row["kind"] == LightKind.POINT:
        place = [float(x) for x in row["position"]]
        return {"type": "point", "position": place, "intensity": color(row["emission"])}
    black = {"type": "diffuse", "reflectance": color((0, 0, 0))}
    frame = np.eye(4)
    if row["kind"] == LightKind.RECTANGLE:
        corners, kind = lamp_corners(row), "rectangle"
        frame[:3, 3] = row["position"]
        frame[:3, 0] = (corners[3] - corners[0]) / 2
        frame[:3, 1] = -(corners[1] - corners[0]) / 2
        frame[:3, 2] = -row["axis_z"]
        radiance = row["emission"]
    elif row["kind"] == LightKind.SUN and row["angle"] > 0:
        centre, radius, radiance = sun_disk(row, parts, middle)
        kind = "disk"
        frame[:3, 3] = centre
        frame[:3, 0], frame[:3, 1] = row["axis_x"] * radius, -row["axis_y"] * radius
        frame[:3, 2] = -row["axis_z"]
    else:
        raise ValueError("this lamp has no counterpart in Mitsuba")
    return {
        "type": kind,
        "to_world": mi.ScalarTransform4f(frame),
        "bsdf": black,
        "emitter": {"type": "area", "radiance": color(radiance)},
    }


def sky_dict(parts: Parts) -> dict[str, Any]:
    """The surroundings; Mitsuba's pictures have y upwards."""
    assert parts.world_map is not None
    texels = (parts.world_map * parts.world)[::-1].astype(np.float32)
    turn = np.array([[0.0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(texels)),
        "to_world": mi.ScalarTransform4f(turn),
    }
