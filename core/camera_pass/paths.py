"""Specular chains: from the lens, or from a gather point, to the next wide scatterer."""

from __future__ import annotations

from typing import Any

from ..bsdf.dispatch import albedo_nonspecular
from ..bsdf.dispatch import whole_weights as lobe_weights
from ..bsdf.specular import scatter_specular
from ..camera.lens import camera_ray
from ..geometry.interaction import OFFSET, interact, leave
from ..geometry.media import copy_media, cross_surface
from ..geometry.vector import Vector, dot, read, scale, store, subtract, vector
from ..jit import Row, Table, kernel
from ..lights.dispatch import FAR, pdf_emitter_hit, see_lamp, visibility_of
from ..lights.mesh import face_normal
from ..lights.selection import selection_probability
from ..lights.world import pdf_world, world_radiance
from ..sampling.rng import CAMERA, camera_2d, stream, uniform
from ..scene.tables import Visibility
from .records import CHAIN, CHAIN_STEP, FILTER, LENS

_CAMERA_BIT = int(Visibility.CAMERA)
_DIFFUSE_BIT = int(Visibility.DIFFUSE)
_GLOSSY_BIT = int(Visibility.GLOSSY)
_TRANSMISSION_BIT = int(Visibility.TRANSMISSION)


@kernel
def start_paths(
    camera: Row,
    camera_media: Table,
    x0: int,
    y0: int,
    width: int,
    image_width: int,
    seed: int,
    i: int,
    start: int,
    stride: int,
    count: int,
    origins: Table,
    directions: Table,
    paths: Table,
) -> None:
    """Camera rays of pixels ``start``, ``start + stride`` ... of a region in pass ``i``.

    The region begins at pixel (x0, y0) and is ``width`` wide. A pixel's random numbers
    hang on its place in the whole image, so a border render shows the same picture.
    """
    for k in range(count):
        pixel = start + k * stride
        x = x0 + pixel % width
        y = y0 + pixel // width
        key = stream(seed, CAMERA, i, y * image_width + x)
        pixel_key = stream(seed, CAMERA, -1, y * image_width + x)
        u_x, u_y = camera_2d(i, pixel_key, FILTER)
        u_lens, v_lens = camera_2d(i, pixel_key, LENS)
        o, d, before, reach = camera_ray(camera, x, y, u_x, u_y, u_lens, v_lens)
        path = paths[k]
        path.key = key
        path.pixel_key = pixel_key
        path.slot = k
        path.depth = 0
        path.event = _CAMERA_BIT
        path.length = before
        path.reach = reach
        path.pdf_w = 0.0
        store(path.beta, (1.0, 1.0, 1.0))
        store(path.direction, d)
        path.media_count = camera_media[0]
        for j in range(camera_media[0]):
            path.media[j] = camera_media[1 + j]
        store(origins[k], o)
        store(directions[k], d)


@kernel
def add(target: Row, beta: Table, radiance: Vector, weight: float) -> None:
    """Add ``beta * radiance * weight`` to a layer's pixel."""
    target[0] += beta[0] * radiance[0] * weight
    target[1] += beta[1] * radiance[1] * weight
    target[2] += beta[2] * radiance[2] * weight


@kernel
def power_heuristic(pdf: float, other: float) -> float:
    """Weight of a sample with density ``pdf`` beside another technique (Veach 1997, 9.2)."""
    a = pdf * pdf
    b = other * other
    return a / (a + b) if a + b > 0.0 else 0.0


@kernel
def _see_light(
    path: Row, sample: Row, lights: Row, entry: int, radiance: Vector, pdf_light: float
) -> None:
    """A light is hit: emission for a camera chain, one half of direct light for a gather.

    A gather path sees light only before its first specular surface: behind one it would
    be a caustic, and those come from the photons.
    """
    if path.pdf_w == 0.0:
        add(sample.emission, path.beta, radiance, 1.0)
    elif path.event == _DIFFUSE_BIT:
        prob = selection_probability(lights, vector(path.origin), entry)
        add(sample.direct, path.beta, radiance, power_heuristic(path.pdf_w, prob * pdf_light))


@kernel
def _see_lamps(path: Row, sample: Row, lights: Row, o: Vector, d: Vector, reach: float) -> None:
    """Lamps whose shape the ray passes before ``reach``; they do not stop it."""
    for j in range(len(lights.shaped)):
        entry = lights.shaped[j]
        lamp = lights.lamps[entry]
        if (lamp.visibility & path.event) == 0:
            continue
        if lamp.shadow == 0 and path.pdf_w > 0.0:
            continue
        t, radiance, pdf_w = see_lamp(lamp, o, d)
        if path.event == _CAMERA_BIT and path.reach < t and t < FAR:
            continue
        # A lamp may lie in the plane of the face that the ray hits.
        if 0.0 < t and t <= reach * (1.0 + 4.0 * OFFSET):
            _see_light(path, sample, lights, entry, radiance, pdf_w)


@kernel
def _is_clipped(path: Row, mesh: Row, face: int, o: Vector, d: Vector) -> bool:
    """Whether the face lies farther than a camera ray may see."""
    if path.event != _CAMERA_BIT or not path.reach < FAR:
        return False
    n = face_normal(mesh, face)
    corner = read(mesh.vertices, mesh.faces[face, 0])
    return dot(subtract(corner, o), n) / dot(d, n) > path.reach


@kernel
def _see_world(path: Row, sample: Row, lights: Row, transparent: bool) -> None:
    """A ray that leaves the scene."""
    if transparent and path.event == _CAMERA_BIT:
        return
    entry = len(lights.lamps) + 1
    if visibility_of(lights, entry) & path.event:
        d = vector(path.direction)
        pdf_w = 0.0 if path.pdf_w == 0.0 else pdf_world(lights.world, vector(path.normal), d)
        _see_light(path, sample, lights, entry, world_radiance(lights.world, d), pdf_w)
    sample.alpha = 1.0


@kernel
def _first_hit(sample: Row, camera: Row, p: Vector, ns: Vector) -> None:
    """Depth and normal of what the pixel shows."""
    sample.hit = 1.0
    sample.alpha = 1.0
    eye = subtract(p, read(camera.position.reshape(1, 3), 0))
    # A camera on a face meets it at 0, give or take a rounding error.
    sample.depth = max(0.0, dot(eye, read(camera.axes, 2)))
    store(sample.normal, ns)


@kernel
def _stop(vertex: Row, path: Row, row: int, offset: float, share: float) -> None:
    """A path ends at a wide scatterer, chosen with probability 1 / ``share``."""
    vertex.key = path.key
    vertex.pixel_key = path.pixel_key
    vertex.slot = path.slot
    vertex.depth = path.depth
    vertex.row = row
    vertex.offset = offset
    vertex.length = path.length
    store(vertex.beta, scale(vector(path.beta), share))
    copy_media(vertex, path)


@kernel
def _choices(path: Row, gather: bool, i: int, base: int) -> tuple[float, float]:
    """Numbers for stopping and for the event: stratified over passes on camera chains."""
    if gather:
        return uniform(path.key, base), uniform(path.key, base + 2)
    return camera_2d(i, path.pixel_key, base)


@kernel
def _go_on(
    materials: Table,
    lobes: Table,
    path: Row,
    row: int,
    ng: Vector,
    ns: Vector,
    entering: bool,
    wo: Vector,
    u_lobe: float,
    u_event: float,
    share: float,
) -> Vector:
    """A specular event, chosen with probability 1 / ``share``: the new direction."""
    wi, weight, transmitted, eta = scatter_specular(
        materials, lobes, path, row, ng, ns, entering, wo, u_lobe, u_event
    )
    factor = share
    path.event = _GLOSSY_BIT
    if transmitted:
        # Radiance, unlike flux, is squeezed with the solid angle (Veach 1997, 5.2).
        factor /= eta * eta
        path.event = _TRANSMISSION_BIT
        cross_surface(path, row, entering)
    for c in range(3):
        path.beta[c] *= weight[c] * factor
    return wi


@kernel
def _see_faces(
    path: Row,
    sample: Row,
    lights: Row,
    mesh: Row,
    materials: Table,
    face: int,
    d: Vector,
    way: float,
) -> None:
    """A face that may emit is hit after ``way``."""
    emission = vector(materials[mesh.material[face]].emission)
    if emission[0] + emission[1] + emission[2] > 0.0:
        pdf_w = pdf_emitter_hit(lights, mesh, materials, face, d, way)
        _see_light(path, sample, lights, len(lights.lamps), emission, pdf_w)


@kernel
def step_paths(
    mesh: Row,
    materials: Table,
    lobes: Table,
    lights: Row,
    camera: Row,
    i: int,
    gather: bool,
    transparent: bool,
    most_depth: int,
    min_throughput: float,
    hit_face: Table,
    hit_u: Table,
    hit_v: Table,
    count: int,
    origins: Table,
    directions: Table,
    paths: Table,
    vertices: Table,
    samples: Table,
) -> Any:
    """One surface for each path: see lights, stop or scatter, compact.

    Returns (paths still on a chain, vertices written). ``gather`` tells that the paths
    are final-gather paths.
    """
    alive = 0
    stopped = 0
    for k in range(count):
        path = paths[k]
        sample = samples[path.slot]
        d = vector(path.direction)
        o = read(origins, k)
        if hit_face[k] < 0 or _is_clipped(path, mesh, hit_face[k], o, d):
            _see_lamps(path, sample, lights, o, d, FAR)
            _see_world(path, sample, lights, transparent)
            continue
        wo = scale(d, -1.0)
        face = hit_face[k]
        p, ng, ns, entering, offset = interact(mesh, face, hit_u[k], hit_v[k], wo)
        way = dot(subtract(p, o), d)
        _see_lamps(path, sample, lights, o, d, way)
        row = mesh.material[face]
        _see_faces(path, sample, lights, mesh, materials, face, d, way)
        path.length += way
        path.reach -= way
        if path.event == _CAMERA_BIT:
            _first_hit(sample, camera, p, ns)
        rough, smooth = lobe_weights(materials[row], lobes)
        if rough + smooth <= 0.0:
            continue
        base = CHAIN + CHAIN_STEP * path.depth
        path.depth += 1
        u_stop, u_event = _choices(path, gather, i, base)
        if u_stop * (rough + smooth) >= smooth:
            vertex = vertices[stopped]
            stopped += 1
            store(vertex.p, p)
            store(vertex.ng, ng)
            store(vertex.ns, ns)
            store(vertex.wo, wo)
            _stop(vertex, path, row, offset, (rough + smooth) / rough)
            if not gather:
                add(sample.albedo, vertex.beta, albedo_nonspecular(materials[row], lobes), 1.0)
            continue
        if path.depth >= most_depth:
            continue
        wi = _go_on(
            materials, lobes, path, row, ng, ns, entering, wo,
            uniform(path.key, base + 1), u_event, (rough + smooth) / smooth,
        )  # fmt: skip
        if not max(path.beta[0], path.beta[1], path.beta[2]) > min_throughput:
            continue
        store(path.direction, wi)
        if alive != k:
            paths[alive] = paths[k]
        store(origins[alive], leave(p, ng, wi, offset))
        store(directions[alive], wi)
        alive += 1
    return alive, stopped
