"""Shadow photons against shadow rays: rays and time saved, and what is decided wrongly.

    python benchmarks/shadow_photons.py [--figure] [LAMPS ...]

A floor with fifty boxes and fifty balls under 1, 4, 64 and 2000 point lamps. Only direct
light is rendered: no photons of other kinds. Times are the processor's. The shadow rays alone
are timed too, batch by batch, and so is the look at the map, and what one ray to one lamp tells
with different ways to choose that lamp. Prints the tables of docs/shadow_photons.md; with
--figure draws docs/pictures/shadow_photons.png of one lamp.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from typing import Any

import figures
import numpy as np

from photon_map.core import Scene, SceneBuilder, Settings, render
from photon_map.core.camera_pass.chunk import trace_camera
from photon_map.core.camera_pass.direct import sample_direct
from photon_map.core.camera_pass.pixels import Pixels, Region
from photon_map.core.camera_pass.rays import Rays
from photon_map.core.camera_pass.shadow import free_part
from photon_map.core.film.film import SAMPLE
from photon_map.core.geometry.vector import vector
from photon_map.core.jit import Row, Table, kernel
from photon_map.core.lights.selection import selection_probability
from photon_map.core.photons.shadow import (
    ASK,
    LIT,
    SHADOWED,
    count_photons,
    decide,
    shadow_map,
)
from photon_map.core.prepared import prepare
from photon_map.core.scene.builder import diffuse
from photon_map.tests.scenes import box, camera, plane, sphere

SIZE = 256
PASSES = 8
SETTINGS = Settings(
    passes=PASSES, photons_global=0, photons_caustic=0, gather_rays=1, pixel_filter="BOX",
    filter_width=1.0, threads=1, chunk_size=8192,
)  # fmt: skip


def scene(lamps: int, radius: float, size: int = SIZE) -> Scene:
    """Boxes and fine balls on a floor; lamps in a square grid above, of one power in all."""
    b = SceneBuilder(f"{lamps} lamps")
    white = b.add_material("white", [diffuse(0.7)])
    b.add_mesh("floor", *plane(4.0), white)
    random = np.random.default_rng(3)
    for k in range(50):
        x, y = random.uniform(-3, 3, 2)
        w, h = random.uniform(0.08, 0.25), random.uniform(0.1, 0.8)
        b.add_mesh(f"box {k}", *box((x - w, y - w, 1e-3), (x + w, y + w, h)), white)
        x, y = random.uniform(-3, 3, 2)
        b.add_mesh(f"ball {k}", *sphere((x, y, 0.3), 0.18, 4), white)
    side = int(np.ceil(lamps**0.5))
    for k in range(lamps):
        x, y = (2.5 * (2 * (c + 0.5) / side - 1) for c in divmod(k, side))
        b.add_point_light(f"lamp {k}", (x + 0.1, y - 0.2, 3.0), 30.0 / lamps, radius)
    b.set_camera(camera((0, -6, 5), (0, 0, 0), size, size))
    return b.build()


def whole_render(
    world: Scene, photons: int, passes: int = PASSES
) -> tuple[float, float, int, np.ndarray]:
    """Processor seconds of rendering and of the setup, rays, and the direct layer."""
    begin = middle = time.process_time()
    for last in render(world, replace(SETTINGS, shadow_photons=photons, passes=passes)):
        if last.phase == "setup":
            middle = time.process_time()
    seconds = time.process_time() - middle
    layer = last.film.resolve("direct").mean(axis=2)
    return seconds, middle - begin, last.film.statistics.rays, layer


@kernel
def decide_bare(
    shadows: Row, vertices: Table, asking: Table, entries: Table, verdicts: Table
) -> None:
    """The report's rule: the share of the photons found, however few they are."""
    for k in range(len(verdicts)):
        vertex = vertices[asking[k]]
        direct, shadow = count_photons(shadows, entries[k], vector(vertex.p), vector(vertex.ng))
        verdicts[k] = ASK
        if direct + shadow > 0:
            if shadow < shadows.lit * (direct + shadow):
                verdicts[k] = LIT
            elif shadow > shadows.dark * (direct + shadow):
                verdicts[k] = SHADOWED


def parts(world: Scene, photons: int, rays: int) -> dict[str, Any]:
    """One camera pass by hand: what the rays cost, what the map costs, what it gets wrong.

    Of at most ``rays`` shadow rays, drawn at random. The pictures say it of each pixel, which
    has one ray in a pass.
    """
    settings = replace(SETTINGS, shadow_photons=photons)
    prepared = prepare(world, settings)
    assert world.camera is not None
    region = Region.of(world.camera, settings)
    pixels = Pixels.spread(0, SIZE * SIZE)
    samples = np.zeros(pixels.paths, SAMPLE)
    lit = trace_camera(
        prepared, settings, region, pixels, Rays(prepared, pixels.paths), samples
    )
    count = len(lit.vertices)
    origins, directions = np.zeros((2, count, 3), np.float32)
    lengths = np.zeros(count, np.float32)
    slots, asking, entries = np.zeros((3, count), np.int32)
    radiance = np.zeros((count, 3))
    asked = sample_direct(
        1, 1, prepared.guide, prepared.mesh, prepared.materials, lit.lobes,
        prepared.shading,
        prepared.lights, lit.vertices, count, origins, directions, lengths, slots, radiance,
        asking, entries,
    )  # fmt: skip
    if asked > rays:
        pick = np.sort(np.random.default_rng(1).choice(asked, rays, replace=False))
        origins, directions, lengths = origins[pick], directions[pick], lengths[pick]
        asking, entries, asked = asking[pick], entries[pick], rays
    begin = time.process_time()
    shadows = shadow_map(prepared, settings)
    building = time.process_time() - begin
    verdicts = np.zeros(asked, np.int32)
    looking, tracing = [], []
    for _ in range(2):
        begin = time.process_time()
        decide(shadows, lit.vertices, asking, entries, directions, asked, verdicts)
        looking.append(time.process_time() - begin)
        ways = origins[:asked], directions[:asked].copy(), lengths[:asked].copy()
        begin = time.process_time()
        free, _ = free_part(prepared, prepared.lobe_room(0), *ways)
        tracing.append(time.process_time() - begin)
    bare = np.zeros(asked, np.int32)
    decide_bare(shadows, lit.vertices, asking, entries, bare)
    bare_decided = bare != ASK
    bare_wrong = bare_decided & ((bare == LIT) != (free[:, 0] > 0))
    decided = verdicts != ASK
    wrong = decided & ((verdicts == LIT) != (free[:, 0] > 0))
    pictures = {}
    for name, told in (("interval", verdicts), ("bare", bare)):
        picture = np.full(SIZE * SIZE, figures.NONE, np.int8)
        meaning = np.where(told == LIT, figures.LIT, figures.DARK)
        meaning[told == ASK] = figures.ASKED
        meaning[(told != ASK) & ((told == LIT) != (free[:, 0] > 0))] = figures.WRONG
        picture[lit.vertices["slot"][asking[:asked]]] = meaning
        pictures[name] = picture.reshape(SIZE, SIZE)
    return {
        "pictures": pictures, "rays": asked,
        "saved": decided.mean(), "wrong": wrong.sum() / asked,
        "look_us": 1e6 * min(looking) / asked, "ray_us": 1e6 * min(tracing) / asked,
        "bare_saved": bare_decided.mean(), "bare_wrong": bare_wrong.sum() / asked,
        "building": building, "radius": shadows.radius, "stored": len(shadows.photons.keys),
    }  # fmt: skip


@kernel
def fill_choices(
    shadows: Row, lights: Row, p: Table, ng: Table, engine: Table, share: Table
) -> None:
    """Of each lamp: the engine's probability at ``p``, its share of shadow photons there."""
    for k in range(len(engine)):
        engine[k] = selection_probability(lights, vector(p), k)
        direct, shadow = count_photons(shadows, k, vector(p), vector(ng))
        share[k] = shadow / (direct + shadow) if direct + shadow else 0.0


def choices(world: Scene, photons: int, places: int) -> dict[str, float]:
    """Relative standard deviation of light / probability, at the median place.

    Worked out from all lamps at places on the floor, with one shadow ray to each.
    """
    settings = replace(SETTINGS, shadow_photons=photons)
    prepared = prepare(world, settings)
    shadows = shadow_map(prepared, settings)
    lights = prepared.lights
    lamps = len(world.lights)
    strength = lights.strength[:lamps]
    random = np.random.default_rng(5)
    names = "by power", "by the engine", "by the engine and shadow photons"
    found: list[list[float]] = []
    for _ in range(places):
        world_place = np.array([*random.uniform(-3, 3, 2), 9.0])
        down = np.array([[0, 0, -1]], np.float32)
        hits = prepared.intersector.nearest(
            (world_place - prepared.centre.origin)[None].astype(np.float32), down
        )
        corners = prepared.mesh.vertices[prepared.mesh.faces[hits.face[0]]].astype(np.float64)
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normal /= np.linalg.norm(normal)
        p = corners[0] + hits.u[0] * (corners[1] - corners[0])
        p += hits.v[0] * (corners[2] - corners[0])
        to = lights.place[:lamps] - p
        length = np.linalg.norm(to, axis=1)
        cosine = np.maximum((to / length[:, None]) @ normal, 0.0)
        free = prepared.intersector.is_free(
            np.repeat((p + 1e-4 * normal)[None], lamps, axis=0).astype(np.float32),
            to.astype(np.float32), np.full(lamps, 0.999, np.float32),
        )  # fmt: skip
        light = strength * cosine / length**2 * free
        if light.sum() <= 0.0:
            continue
        engine, share = np.zeros((2, lamps))
        fill_choices(shadows, lights, p, normal, engine, share)
        guided = engine * np.maximum(1.0 - share, 0.1)
        row = []
        for prob in (strength / strength.sum(), engine, guided / guided.sum()):
            use = light > 0
            second = (light[use] ** 2 / prob[use]).sum()
            row.append(max(second / light.sum() ** 2 - 1.0, 0.0) ** 0.5)
        found.append(row)
    return dict(zip(names, np.median(found, axis=0), strict=True))


def compare_renders(lamps: int) -> None:
    """Whole renders with rays alone and with shadow photons: time, and pixels that differ."""
    # A look takes up to a millisecond of many lamps: fewer pixels and passes.
    size, passes = (SIZE, PASSES) if lamps <= 4 else (128, 2)
    world = scene(lamps, 0.0, size)
    seconds, _, rays, truth = whole_render(world, 0, passes)
    guessed, setup, fewer, layer = whole_render(world, 400_000, passes)
    error = np.sqrt(((layer - truth) ** 2).mean()) / truth.mean()
    print(
        f"  render {size}x{size}, {passes} passes: {seconds:.2f} s, {rays} rays -> "
        f"{guessed:.2f} s, {fewer} rays, setup {setup:.1f} s, {(layer != truth).sum()} pixels "
        f"differ, {100 * error:.3f} % rms",
        flush=True,
    )


def main() -> None:
    """Print the parts of every case, and whole renders."""
    parser = argparse.ArgumentParser(description="Shadow photons against shadow rays.")
    parser.add_argument("lamps", nargs="*", type=int, default=[1, 4, 64, 2000])
    parser.add_argument("--figure", action="store_true", help="draw the docs' figure")
    given = parser.parse_args()
    whole_render(scene(1, 0.0), 1000)
    maps = {}
    for lamps, radius in ((1, 0.0), (1, 0.1), (4, 0.0), (64, 0.0), (2000, 0.0)):
        if lamps not in given.lamps:
            continue
        world = scene(lamps, radius)
        for photons in (50_000, 400_000):
            found = parts(world, photons, {1: 65_536, 4: 65_536, 64: 2048}.get(lamps, 128))
            if lamps == 1 and radius == 0.0:
                thousands = photons // 1000
                maps[f"{thousands} 000 paths, bare rule"] = found["pictures"]["bare"]
                maps[f"{thousands} 000 paths, interval"] = found["pictures"]["interval"]
            print(
                f"{lamps} lamps of radius {radius}, {photons} paths: {found['stored']} stored, "
                f"disc {found['radius']:.3f} m, {found['rays']} rays, "
                f"{100 * found['saved']:.1f} % saved, "
                f"{100 * found['wrong']:.3f} % wrong; bare rule "
                f"{100 * found['bare_saved']:.1f} % saved, "
                f"{100 * found['bare_wrong']:.3f} % wrong; a look "
                f"{found['look_us']:.2f} us, a ray {found['ray_us']:.3f} us, built in "
                f"{found['building']:.2f} s",
                flush=True,
            )
        if radius == 0.0:
            # Of 2000 lamps a look takes a millisecond: few photons, few places.
            spread = choices(world, *((400_000, 512) if lamps <= 64 else (50_000, 32)))
            words = ", ".join(f"{name} {value:.3f}" for name, value in spread.items())
            print(f"  relative deviation of one ray to one lamp: {words}", flush=True)
            compare_renders(lamps)
    if given.figure and maps:
        figures.draw_verdicts(maps)


if __name__ == "__main__":
    main()
