"""Light that a path meets: lamps it passes, faces that glow, the world behind everything."""

from __future__ import annotations

from ..bsdf.resolve import emitted_at
from ..geometry.interaction import OFFSET
from ..geometry.media import current_medium, transmittance
from ..geometry.vector import Vector, vector
from ..jit import Row, Table, kernel
from ..lights.dispatch import FAR, pdf_emitter_hit, see_lamp, visibility_of
from ..lights.selection import selection_probability
from ..lights.tree import next_lamp
from ..lights.world import pdf_world, world_radiance
from ..scene.tables import Visibility

_CAMERA_BIT = int(Visibility.CAMERA)


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
    path: Row,
    sample: Row,
    lights: Row,
    gather: bool,
    entry: int,
    radiance: Vector,
    pdf_light: float,
) -> None:
    """A light is met: emission behind smooth surfaces, else one half of direct light.

    Where light sampling was possible at the last event (``pdf_w`` above 0) the two share.
    A final-gather path sees light only before its first event: behind one it would be a
    caustic, and those come from the photons.
    """
    if path.pdf_w > 0.0:
        prob = selection_probability(lights, vector(path.origin), entry)
        add(sample.direct, path.beta, radiance, power_heuristic(path.pdf_w, prob * pdf_light))
    elif not gather:
        add(sample.emission, path.beta, radiance, 1.0)


@kernel
def _see_lamp(
    path: Row,
    sample: Row,
    materials: Table,
    lights: Row,
    gather: bool,
    entry: int,
    reach: float,
) -> None:
    """A lamp whose shape the path may pass within ``reach``."""
    lamp = lights.lamps[entry]
    if (lamp.visibility & path.event) == 0:
        return
    if lamp.shadow == 0 and path.pdf_w > 0.0:
        return
    t, radiance, pdf_w = see_lamp(lamp, vector(path.origin), vector(path.direction))
    if path.event == _CAMERA_BIT and path.reach < t and t < FAR:
        return
    if t > path.since and t <= reach:
        left = transmittance(materials, current_medium(materials, path), t - path.since)
        light = (radiance[0] * left[0], radiance[1] * left[1], radiance[2] * left[2])
        _see_light(path, sample, lights, gather, entry, light, pdf_w)


@kernel
def see_lamps(
    path: Row, sample: Row, materials: Table, lights: Row, gather: bool, reach: float
) -> None:
    """Lamps whose shape a path passes within ``reach`` of its last event.

    They do not stop it. What lies before ``path.since`` has been seen already.
    """
    o = vector(path.origin)
    d = vector(path.direction)
    # A lamp may lie in the plane of the face that the ray hits.
    reach *= 1.0 + 4.0 * OFFSET
    for j in range(len(lights.suns)):
        _see_lamp(path, sample, materials, lights, gather, lights.suns[j], reach)
    entry, node = next_lamp(lights.tree, 0, o, d, reach)
    while entry >= 0:
        _see_lamp(path, sample, materials, lights, gather, entry, reach)
        entry, node = next_lamp(lights.tree, node, o, d, reach)


@kernel
def see_world(
    path: Row, sample: Row, materials: Table, lights: Row, gather: bool, transparent: bool
) -> None:
    """A path leaves the scene."""
    see_lamps(path, sample, materials, lights, gather, FAR)
    if transparent and path.event == _CAMERA_BIT:
        return
    sample.alpha = 1.0
    entry = len(lights.lamps) + 1
    if visibility_of(lights, entry) & path.event == 0:
        return
    d = vector(path.direction)
    world = world_radiance(lights.world, d)
    left = transmittance(materials, current_medium(materials, path), FAR)
    light = (world[0] * left[0], world[1] * left[1], world[2] * left[2])
    pdf_w = 0.0
    if path.pdf_w > 0.0:
        pdf_w = pdf_world(lights.world, vector(path.normal), d)
    _see_light(path, sample, lights, gather, entry, light, pdf_w)


@kernel
def see_faces(
    path: Row,
    sample: Row,
    lights: Row,
    gather: bool,
    mesh: Row,
    materials: Table,
    shading: Row,
    hit: Row,
) -> None:
    """A face that may glow is hit, ``path.since`` after the last event."""
    material = materials[hit.row]
    emission = vector(material.emission)
    if emission[0] + emission[1] + emission[2] <= 0.0:
        return
    if material.closure_count > 0:
        emission = emitted_at(material, shading, hit.face, hit.u, hit.v)
    d = vector(path.direction)
    pdf_w = pdf_emitter_hit(lights, mesh, materials, hit.face, d, path.since)
    _see_light(path, sample, lights, gather, len(lights.lamps), emission, pdf_w)
