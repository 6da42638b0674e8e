"""POV-Ray's photons as a peer, where the command `povray` is found: point lamps and glass.

It has no progressive mode: every image is a render of its own with more photons and finer
pixels, and its seconds are those of that render alone, parsing included (milliseconds).
Light that is scattered twice by diffuse surfaces is left out, as its photons do.
"""

from __future__ import annotations

import math
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from measure import Image, read_exr
from speed_parts import Matter, Parts, Surface, parts_of

from photon_map.core import Scene
from photon_map.core.scene.tables import LightKind

#: Lamps fall off as 2 / (1 + (d / FADE)^2).
FADE = 0.01
#: Photons of the first image; pixels are divided into 3 x 3.
PHOTONS, DIVISIONS = 20_000, 3


def version() -> str:
    """Name and version."""
    done = subprocess.run(["povray", "--version"], capture_output=True, text=True)
    found = re.search(r"POV-Ray (\d[\w.]*)", done.stdout + done.stderr)
    return f"POV-Ray {found[1] if found else '?'}"


def snapshots(
    scene: Scene, engine: str, times: Sequence[float], seed: int, threads: int, ready: Any
) -> Iterator[tuple[float, Image]]:
    """Seconds and image (h, w, 3), row 0 at the top, of renders of growing quality."""
    if shutil.which("povray") is None:
        raise SystemExit("the command povray was not found")
    parts = parts_of(scene)
    ready()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        seconds, quality = 0.0, 0
        while seconds < times[-1] and quality < 12:
            photons = round(PHOTONS * 2.0**quality)
            divisions = min(9, DIVISIONS + quality // 2)
            seconds, image = picture(parts, place, photons, divisions, threads)
            yield seconds, image
            quality += 1


def picture(
    parts: Parts, folder: Path, photons: int, divisions: int, threads: int
) -> tuple[float, Image]:
    """One render: its seconds and the image."""
    camera = parts.camera
    (folder / "scene.pov").write_text("\n".join(scene_lines(parts, photons)))
    command = ["povray", "+Iscene.pov", "+Oimage.exr", "+FE", "-D", "-GA", "+AM1", "+A0.0"]
    command += [f"+R{divisions}", f"+W{camera.width}", f"+H{camera.height}", f"+WT{threads}"]
    begin = time.perf_counter()
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    seconds = time.perf_counter() - begin
    if done.returncode:
        raise SystemExit(done.stderr[-2000:])
    return seconds, read_exr(folder / "image.exr")


def scene_lines(parts: Parts, photons: int) -> Iterator[str]:
    """The scene in POV-Ray's language."""
    yield "#version 3.7;"
    yield "global_settings { assumed_gamma 1.0 max_trace_level 32"
    yield f"  photons {{ count {photons} autostop 0 max_trace_level 32 }} }}"
    yield "background { color rgb 0 }"
    matrix, camera = parts.camera.matrix, parts.camera
    width = camera.sensor_width / camera.lens
    yield f"camera {{ perspective location {vector(matrix[:3, 3])}"
    yield f"  right {vector(matrix[:3, 0] * width)} up {vector(matrix[:3, 1] * width)}"
    yield f"  direction {vector(-matrix[:3, 2])} }}"
    for row in parts.lamps:
        if row["kind"] != LightKind.POINT:
            raise SystemExit("only point lamps are handed to POV-Ray")
        color = row["emission"] / (2 * math.pi * FADE**2)
        yield f"light_source {{ {vector(row['position'])} color rgb {vector(color)}"
        yield f"  fade_distance {FADE} fade_power 2"
        yield "  photons { refraction on reflection on } }"
    for surface in parts.surfaces:
        yield from surface_lines(surface)


def surface_lines(surface: Surface) -> Iterator[str]:
    """A mesh with its material."""
    yield "mesh2 {"
    points = ",".join(vector(p) for p in surface.vertices)
    yield f"vertex_vectors {{ {len(surface.vertices)}, {points} }}"
    faces = ",".join(f"<{a},{b},{c}>" for a, b, c in surface.faces)
    yield f"face_indices {{ {len(surface.faces)}, {faces} }}"
    yield from matter_lines(surface.matter)
    yield "}"


def matter_lines(matter: Matter) -> Iterator[str]:
    """The material of a mesh; photons are aimed at glass and kept by the rest."""
    if matter.kind == "diffuse":
        yield f"pigment {{ color rgb {vector(np.array(matter.color))} }}"
        yield "finish { ambient 0 diffuse 1 } photons { collect on }"
    elif matter.kind == "glass":
        yield "inside_vector <0, 0, 1> pigment { color rgbt <1, 1, 1, 1> }"
        yield "finish { ambient 0 diffuse 0 specular 0 reflection { 0 1 fresnel on }"
        yield f"  conserve_energy }} interior {{ ior {matter.ior} }}"
        yield "photons { target refraction on reflection on collect off }"
    else:
        raise SystemExit(f"{matter.kind} is not handed to POV-Ray")


def vector(values: Any) -> str:
    """As POV-Ray writes it."""
    return "<" + ",".join(f"{float(v):.9g}" for v in values) + ">"
