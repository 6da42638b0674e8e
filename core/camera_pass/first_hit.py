"""What a camera path meets at once: depth, position, colours, names, for layers of data.

Traced beside the light, with the same camera paths, when some such layer is asked for.
Surfaces are seen through transparent ones, each by its share; the layers "end_normal" and
"end_depth" follow mirrors and clear glass to the surface that they show.
"""

from __future__ import annotations

import math

from ..bsdf.dispatch import NARROW, WIDE, lobe_weights, pass_weight
from ..bsdf.hit import meet, shade
from ..bsdf.kinds import colors_by_kind
from ..bsdf.resolve import emitted_at
from ..bsdf.scatter import goes_through
from ..film.first_hits import MOST_MATTES
from ..geometry.interaction import leave
from ..geometry.media import current_medium, ior_around, transmittance
from ..geometry.vector import Vector, dot, read, store, subtract, times, vector
from ..geometry.vector import add as plus
from ..jit import Row, Table, kernel
from ..lights.dispatch import FAR, visibility_of
from ..lights.world import world_radiance
from ..scene.tables import Visibility
from ..textures.sampling import uv_at
from .aovs import keep_aovs, keep_world_aovs
from .paths import (
    MOST_STEPS,
    absorb,
    carries,
    choices,
    go_on,
    is_clipped,
    is_held_out,
    is_visible,
)
from .records import CHAIN, CHAIN_STEP
from .seen import add, see_faces, see_lamps
from .veil import go_straight

_CAMERA_BIT = int(Visibility.CAMERA)
#: A surface is there for the layers of one path when it is at least so opaque.
_OPAQUE = 0.5


@kernel
def _see_background(
    path: Row,
    row: Row,
    materials: Table,
    lights: Row,
    tables: Row,
    transparent: bool,
    aovs: Table,
) -> None:
    """The camera sees past everything."""
    if row.found == 0.0:
        keep_world_aovs(aovs[path.slot], path, tables)
    see_lamps(path, row, materials, lights, False, FAR)
    entry = len(lights.lamps) + 1
    if transparent or visibility_of(lights, entry) & _CAMERA_BIT == 0:
        return
    left = transmittance(materials, current_medium(materials, path), FAR)
    light = times(world_radiance(lights.world, vector(path.direction)), left)
    add(row.environment, path.beta, light, 1.0)


@kernel
def _mist(distance: float, mist: Table) -> float:
    """Share of light that mist leaves at ``distance``."""
    x = (distance - mist[0]) / mist[1]
    return 1.0 - math.pow(min(1.0, max(0.0, x)), mist[2])


@kernel
def _keep_single(row: Row, hit: Row, materials: Table, tables: Row, depth: float) -> None:
    """Data of which a mean would be of no use."""
    row.found = 1.0
    row.distance = max(0.0, depth)
    for c in range(3):
        row.position[c] = hit.p[c] + tables.origin[c]
    row.object_index = tables.object_index[tables.face_object[hit.face]]
    row.material_index = materials[hit.row].index
    store(row.place, (float(hit.face + 1), hit.u, hit.v))


@kernel
def _keep_mattes(row: Row, hit: Row, tables: Row, weight: float) -> None:
    """Names of a surface that shows with ``weight``."""
    j = int(row.matte_count)
    if j >= MOST_MATTES or not weight > 0.0:
        return
    obj = tables.face_object[hit.face]
    row.matte_object[j] = tables.numbers_object[obj]
    row.matte_asset[j] = tables.numbers_asset[obj]
    row.matte_material[j] = tables.numbers_material[hit.row]
    row.matte_weight[j] = weight
    row.matte_count += 1.0


@kernel
def _keep_uv(row: Row, hit: Row, shading: Row, layer: int) -> None:
    """Coordinates of a surface and 1; zeros when its mesh has none."""
    if layer < 0 or layer >= len(shading.uvs):
        return
    largest = 0.0
    for j in range(3):
        corner = shading.uvs[layer, hit.face, j]
        largest = max(largest, max(abs(corner[0]), abs(corner[1])))
    if largest > 0.0:
        s, t = uv_at(shading.uvs, layer, hit.face, hit.u, hit.v)
        store(row.uv, (s, t, 1.0))


@kernel
def _colors(
    path: Row, hit: Row, materials: Table, lobes: Table, shading: Row
) -> tuple[Vector, Vector, Vector]:
    """What the surface that a path is on does to light: (diffuse, glossy, transmitted)."""
    eta = 1.0
    ior = materials[hit.row].ior
    if ior > 0.0:
        around = ior_around(materials, path, hit.row, hit.entering != 0)
        eta = ior / around if hit.entering != 0 else around / ior
    cosine = dot(vector(hit.ns), vector(hit.wo))
    return colors_by_kind(path, lobes, shading.albedo, cosine, eta)


@kernel
def _show(
    row: Row,
    path: Row,
    hit: Row,
    materials: Table,
    lobes: Table,
    shading: Row,
    camera: Row,
    tables: Row,
    opacity: float,
) -> None:
    """A surface that the camera sees, perhaps through others."""
    eye = subtract(vector(hit.p), read(camera.position.reshape(1, 3), 0))
    depth = dot(eye, read(camera.axes, 2))
    beta = path.beta
    weight = opacity * (beta[0] + beta[1] + beta[2]) / 3.0
    if row.found == 0.0 and opacity >= _OPAQUE:
        _keep_single(row, hit, materials, tables, depth)
        _keep_uv(row, hit, shading, tables.shown_uv)
    distance = depth if camera.orthographic else math.sqrt(dot(eye, eye))
    row.mist += weight * _mist(distance, tables.mist)
    _keep_mattes(row, hit, tables, weight)
    diffuse, glossy, transmitted = _colors(path, hit, materials, lobes, shading)
    add(row.diffuse_color, beta, diffuse, 1.0)
    add(row.glossy_color, beta, glossy, 1.0)
    add(row.transmission_color, beta, transmitted, 1.0)


@kernel
def _end(
    row: Row, path: Row, hit: Row, materials: Table, lobes: Table, shading: Row, camera: Row
) -> None:
    """The surface that the camera path shows: its normal right, up and forward."""
    if row.ended > 0.0:
        return
    row.ended = 1.0
    row.end_depth = path.length
    for j in range(3):
        row.end_normal[j] = dot(vector(hit.ns), read(camera.axes, j))
    diffuse, glossy, transmitted = _colors(path, hit, materials, lobes, shading)
    albedo = plus(plus(diffuse, glossy), transmitted)
    material = materials[hit.row]
    if max(material.emission[0], material.emission[1], material.emission[2]) > 0.0:
        albedo = plus(albedo, emitted_at(material, shading, hit.face, hit.u, hit.v))
    add(row.end_albedo, path.beta, albedo, 1.0)


@kernel
def _continue_chain(
    materials: Table,
    lobes: Table,
    path: Row,
    row: Row,
    hit: Row,
    shading: Row,
    camera: Row,
    most_depth: int,
    min_throughput: float,
) -> bool:
    """Draw the next event as the light's paths do; False where the path ends."""
    wide, narrow = lobe_weights(path, lobes)
    path.depth += 1
    base = CHAIN + CHAIN_STEP * path.steps
    u_stop, u_event = choices(path, False, base)
    part = WIDE if u_stop * (wide + narrow) >= narrow else NARROW
    if part == WIDE or path.depth >= most_depth or path.steps >= MOST_STEPS:
        _end(row, path, hit, materials, lobes, shading, camera)
        return False
    wi = go_on(materials, lobes, path, hit, u_event, base, (wide + narrow) / narrow, False)
    store(path.origin, leave(vector(hit.p), vector(hit.ng), wi, hit.offset))
    return carries(path, min_throughput)


@kernel
def _advance(materials: Table, path: Row, hit: Row) -> None:
    """The way to a hit, and what is absorbed on it."""
    path.length += hit.way
    path.since += hit.way
    absorb(materials, path, hit.way)


@kernel
def _passing(materials: Table, path: Row, hit: Row, lobes: Table) -> Vector:
    """What the surface that a path is on lets pass straight."""
    return pass_weight(path, lobes) if materials[hit.row].passes else (0.0, 0.0, 0.0)


@kernel
def _goes_straight(path: Row, passing: Vector, opacity: float) -> bool:
    """Whether the path is followed through a transparent surface; dims it."""
    if path.event != _CAMERA_BIT:
        return opacity < _OPAQUE
    if max(passing) <= 0.0:
        return False
    for c in range(3):
        path.beta[c] *= passing[c]
    return True


@kernel
def step_first_hits(
    mesh: Row,
    materials: Table,
    lobes: Table,
    shading: Row,
    lights: Row,
    camera: Row,
    tables: Row,
    transparent: bool,
    deep: bool,
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
    rows: Table,
    aovs: Table,
) -> int:
    """One surface for each path, into ``rows`` (n,) ``FIRST_HIT``; how many go on.

    ``aovs`` (n, A, 4); ``deep``: mirrors and glass are followed. Others as in ``step_paths``.
    """
    alive, hit = 0, hits[0]
    for k in range(count):
        path = paths[k]
        row = rows[path.slot]
        face = hit_face[k]
        if face >= 0:
            meet(hit, mesh, face, hit_u[k], hit_v[k], origins, k, path)
        first = path.event == _CAMERA_BIT
        if face < 0 or is_clipped(path, hit):
            if first:
                _see_background(path, row, materials, lights, tables, transparent, aovs)
            continue
        path.steps += 1
        if first:
            see_lamps(path, row, materials, lights, False, path.since + hit.way)
        _advance(materials, path, hit)
        straight = goes_through(materials, path, hit, is_visible(path, hit, mesh))
        held = not straight and is_held_out(path, hit, mesh)
        if not straight:
            if first and not held:
                see_faces(path, row, lights, False, mesh, materials, shading, hit)
            shade(hit, path, mesh, materials, lobes, shading, spare)
            passing = _passing(materials, path, hit, lobes)
            opacity = 1.0 - (passing[0] + passing[1] + passing[2]) / 3.0
            if first and row.found == 0.0:
                keep_aovs(aovs[path.slot], path, hit, shading, tables)
            if first and not held:
                _show(row, path, hit, materials, lobes, shading, camera, tables, opacity)
                if deep and max(passing) > 0.0 and opacity >= _OPAQUE:
                    _end(row, path, hit, materials, lobes, shading, camera)
            straight = _goes_straight(path, passing, opacity)
        if straight:
            if path.steps < MOST_STEPS and carries(path, min_throughput):
                go_straight(paths, k, hit, origins, directions, alive)
                alive += 1
            continue
        if (
            held
            or not deep
            or not _continue_chain(
                materials, lobes, path, row, hit, shading, camera, most_depth, min_throughput
            )
        ):
            continue
        store(origins[alive], vector(path.origin))
        store(directions[alive], vector(path.direction))
        if alive != k:
            paths[alive] = paths[k]
        alive += 1
    return alive
