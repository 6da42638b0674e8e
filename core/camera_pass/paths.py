"""Chains of narrow scattering: from the lens, or from a gather point, to a wide scatterer."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..bsdf.dispatch import NARROW, WIDE, albedo_nonspecular, lobe_weights, part_bit
from ..bsdf.hit import meet, shade
from ..bsdf.scatter import goes_through, has_rough_narrow, scatter
from ..geometry.interaction import leave
from ..geometry.media import copy_media, cross_surface, current_medium, transmittance
from ..geometry.vector import Vector, dot, read, scale, store, subtract, vector
from ..jit import Row, Table, kernel
from ..sampling.rng import camera_2d, mix, uniform
from ..scene.tables import Visibility
from .records import (
    CHAIN,
    CHAIN_STEP,
    REFLECTED,
    STEP_AROUND,
    STEP_EVENT,
    STEP_LOBE,
    STEP_PASS,
)
from .seen import add, see_faces, see_lamps, see_world
from .veil import choose_passing, go_straight

_CAMERA_BIT = int(Visibility.CAMERA)
_HOLDOUT = int(Visibility.HOLDOUT)
#: Surfaces that a path may meet, those it goes straight through included.
MOST_STEPS = 4096
#: A number that is never below the share that glass reflects, total reflection apart.
_REFRACTING = 1.0 - 1e-15


@kernel
def absorb(materials: Table, path: Row, way: float) -> None:
    """Beer-Lambert absorption on the ``way`` that the path has gone."""
    left = transmittance(materials, current_medium(materials, path), way)
    for c in range(3):
        path.beta[c] *= left[c]


@kernel
def is_clipped(path: Row, hit: Row) -> bool:
    """Whether a camera ray's hit lies farther than it may see."""
    return path.event == _CAMERA_BIT and path.since + hit.way > path.reach


@kernel
def is_visible(path: Row, hit: Row, mesh: Row) -> bool:
    """Whether rays of the path's kind see the object that is hit."""
    return mesh.visible[hit.face] & path.event != 0


@kernel
def is_held_out(path: Row, hit: Row, mesh: Row) -> bool:
    """Whether a hit cuts a hole into the picture.

    The camera then sees neither it nor what it hides; mirrors, shadows and photons do.
    """
    return path.event == _CAMERA_BIT and mesh.visible[hit.face] & _HOLDOUT != 0


@kernel
def _first_hit(sample: Row, camera: Row, hit: Row, path: Row, mesh: Row) -> bool:
    """Depth and normal of what the pixel shows; False where it shows a hole."""
    if is_held_out(path, hit, mesh):
        return False
    sample.hit = 1.0
    sample.alpha = 1.0
    eye = subtract(vector(hit.p), read(camera.position.reshape(1, 3), 0))
    # A camera on a face meets it at 0, give or take a rounding error.
    sample.depth = max(0.0, dot(eye, read(camera.axes, 2)))
    store(sample.normal, vector(hit.ns))
    return True


@kernel
def _light_here(vertex: Row, path: Row, hit: Row, part: int, share: float) -> None:
    """The path is lit here, by the lobes of ``part``, chosen with probability 1 / share."""
    vertex.key = path.key
    vertex.pixel_key = path.pixel_key
    vertex.number = path.number
    if part == NARROW:
        # Vertices of one path shall not share their numbers; over the passes each of them
        # keeps its stratification.
        vertex.pixel_key = mix(path.pixel_key + np.uint64(path.steps))
    vertex.slot = path.slot
    vertex.depth = path.depth
    vertex.part = part
    vertex.row = hit.row
    vertex.lobe_start = path.lobe_start
    vertex.lobe_count = path.lobe_count
    vertex.entering = hit.entering
    vertex.portion = path.portion
    vertex.offset = hit.offset
    vertex.length = path.length
    vertex.way = path.length - path.begun
    store(vertex.p, vector(hit.p))
    store(vertex.ng, vector(hit.ng))
    store(vertex.ns, vector(hit.ns))
    store(vertex.wo, vector(hit.wo))
    store(vertex.beta, scale(vector(path.beta), share))
    copy_media(vertex, path)


@kernel
def choices(path: Row, gather: bool, base: int) -> tuple[float, float]:
    """Numbers for stopping and for the event: stratified over passes on camera chains.

    A branch of a split path does what it is there for.
    """
    if gather:
        return uniform(path.key, base), uniform(path.key, base + STEP_EVENT)
    u_stop, u_event = camera_2d(path.number, path.pixel_key, base)
    if path.forced != 0:
        u_event = 0.0 if path.forced == REFLECTED else _REFRACTING
        path.forced = 0
    return u_stop, u_event


@kernel
def go_on(
    materials: Table,
    lobes: Table,
    path: Row,
    hit: Row,
    u: float,
    base: int,
    share: float,
    gather: bool,
) -> Vector:
    """A narrow event, chosen with probability 1 / ``share``: the new direction."""
    wi, weight, pdf_w, transmitted, eta = scatter(
        materials, lobes, path, hit, NARROW, uniform(path.key, base + STEP_LOBE), u,
        uniform(path.key, base + STEP_AROUND),
    )  # fmt: skip
    factor = share
    path.event = part_bit(path, lobes, NARROW, transmitted)
    # Light behind a gather path's narrow event is a caustic, however rough the event.
    path.pdf_w = 0.0 if gather else pdf_w
    path.since = 0.0
    if transmitted:
        # Radiance, unlike flux, is squeezed with the solid angle (Veach 1997, 5.2).
        factor /= eta * eta
        if materials[hit.row].ior > 0.0:
            cross_surface(path, hit.row, hit.entering != 0)
    for c in range(3):
        path.beta[c] *= weight[c] * factor
    store(path.direction, wi)
    store(path.normal, vector(hit.ns))
    return wi


@kernel
def _arrive(
    path: Row,
    sample: Row,
    hit: Row,
    mesh: Row,
    materials: Table,
    lobes: Table,
    shading: Row,
    lights: Row,
    gather: bool,
    spare: int,
    u_pass: float,
) -> bool:
    """Light on the way to a hit and of its face, lobes there: whether the path goes through."""
    see_lamps(path, sample, materials, lights, gather, path.since + hit.way)
    path.length += hit.way
    path.since += hit.way
    absorb(materials, path, hit.way)
    if goes_through(materials, path, hit, is_visible(path, hit, mesh)):
        return True
    if not is_held_out(path, hit, mesh):
        see_faces(path, sample, lights, gather, mesh, materials, shading, hit)
    shade(hit, path, mesh, materials, lobes, shading, spare)
    if not materials[hit.row].passes:
        return False
    through, factor = choose_passing(path, lobes, u_pass)
    for c in range(3):
        path.beta[c] *= factor[c]
    return bool(through)


@kernel
def step_paths(
    mesh: Row,
    materials: Table,
    lobes: Table,
    shading: Row,
    lights: Row,
    camera: Row,
    gather: bool,
    transparent: bool,
    most_depth: int,
    min_throughput: float,
    spare: int,
    hit_face: Table,
    hit_u: Table,
    hit_v: Table,
    hits: Table,
    count: int,
    origins: Table,
    directions: Table,
    paths: Table,
    vertices: Table,
    samples: Table,
) -> Any:
    """One surface for each path: see lights, stop or scatter, compact.

    Returns (paths still on a chain, vertices written, rows of ``lobes`` in use: those from
    ``spare`` on belong to the vertices). ``gather`` tells that these are gather paths;
    ``hits`` (1,) ``HIT`` is room to work in.
    """
    alive = 0
    lit = 0
    hit = hits[0]
    for k in range(count):
        path = paths[k]
        sample = samples[path.slot]
        face = hit_face[k]
        if face >= 0:
            meet(hit, mesh, face, hit_u[k], hit_v[k], origins, k, path)
        if face < 0 or is_clipped(path, hit):
            see_world(path, sample, materials, lights, gather, transparent)
            continue
        path.steps += 1
        base = CHAIN + CHAIN_STEP * path.steps
        if _arrive(
            path, sample, hit, mesh, materials, lobes, shading, lights, gather, spare,
            uniform(path.key, base + STEP_PASS),
        ):  # fmt: skip
            if path.steps < MOST_STEPS and carries(path, min_throughput):
                go_straight(paths, k, hit, origins, directions, alive)
                alive += 1
            continue
        if path.event == _CAMERA_BIT and not _first_hit(sample, camera, hit, path, mesh):
            continue
        wide, narrow = lobe_weights(path, lobes)
        if wide + narrow <= 0.0:
            continue
        path.depth += 1
        u_stop, u_event = choices(path, gather, base) if narrow > 0.0 else (0.0, 0.0)
        part, own = (WIDE, wide) if u_stop * (wide + narrow) >= narrow else (NARROW, narrow)
        share = (wide + narrow) / own
        if part == WIDE or (not gather and has_rough_narrow(path, lobes)):
            _light_here(vertices[lit], path, hit, part, share)
            lit += 1
            if hit.own:
                spare = path.lobe_start + path.lobe_count
            if part == WIDE and not gather:
                add(sample.albedo, path.beta, albedo_nonspecular(path, lobes), share)
        if part == WIDE or path.depth >= most_depth or path.steps >= MOST_STEPS:
            continue
        wi = go_on(materials, lobes, path, hit, u_event, base, share, gather)
        if not carries(path, min_throughput):
            continue
        store(path.origin, leave(vector(hit.p), vector(hit.ng), wi, hit.offset))
        store(origins[alive], vector(path.origin))
        store(directions[alive], wi)
        if alive != k:
            paths[alive] = paths[k]
        alive += 1
    return alive, lit, spare


@kernel
def carries(path: Row, least: float) -> bool:
    """Whether a path still carries enough; false for NaN."""
    return max(path.beta[0], path.beta[1], path.beta[2]) > least
