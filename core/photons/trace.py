"""Photons walk through the scene and are stored where surfaces scatter widely."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import (
    CASTING,
    SPREADING,
    WIDE,
    lobe_weights,
    part_bit,
    photon_weights,
)
from ..bsdf.hit import HIT, meet, shade
from ..bsdf.scatter import choose_transparency, goes_through, scatter
from ..geometry.interaction import inward, leave
from ..geometry.intersector import Hits
from ..geometry.media import cross_surface, current_medium, transmittance
from ..geometry.vector import Vector, dot, read, scale, store, times, vector
from ..jit import Row, Table, kernel
from ..lights.dispatch import casts_shadow
from ..lights.emission import reaches
from ..room import ROOM
from ..sampling.rng import uniform
from ..scene.tables import Visibility
from ..settings import Settings
from .adjoint import MOST_CORRECTION, adjoint_weight, normal_correction
from .emit import FIRST_BOUNCE, PHOTON_PATH, emit_photons
from .focus import FOCUSED, is_focused, mark, share_out

if TYPE_CHECKING:
    from ..prepared import Prepared

#: One stored photon: ``direction`` points back to where it came from, ``normal`` is the
#: surface's geometric normal on that side, ``flux`` [W] per channel. ``part`` of the lobes
#: there that answers to it: what has met casters alone goes on as a caustic photon from
#: rough mirrors and glass, so of the global map's photons their SPREADING part takes none.
PHOTON = np.dtype(
    [
        ("position", "f4", 3),
        ("direction", "f4", 3),
        ("flux", "f4", 3),
        ("normal", "f4", 3),
        ("part", "i4"),
    ]
)

_DIFFUSE_BIT = int(Visibility.DIFFUSE)
_SHADOW_BIT = int(Visibility.SHADOW)
_CASTS_NONE = int(Visibility.CASTS_NONE)
_SHOWS_NONE = int(Visibility.SHOWS_NONE)
_DIMENSIONS = 8  # random numbers a step may use
_CHOICE, _SURVIVAL, _LOBE, _U, _V, _PASS, _ON = range(7)
#: Surfaces that a photon may meet, those it goes straight through included.
_MOST_STEPS = 4096


class Walk(NamedTuple):
    """A batch's photons, their order, rays traced; those ``seen`` at once by the camera."""

    photons: NDArray[np.void]
    order: NDArray[np.int64]
    rays: int
    seen: NDArray[np.void] | None = None


class Watcher(Protocol):
    """Looks on at each step of a batch; what it is shown is overwritten afterwards."""

    def __call__(
        self, paths: NDArray[np.void], origins: NDArray[np.float32], hits: Hits
    ) -> None:
        """Paths (n,) ``PHOTON_PATH`` start at ``origins`` (n, 3) and meet ``hits``."""


def trace_photons(
    prepared: Prepared,
    spheres: Table,
    light_cdf: Table,
    aimed: bool,
    settings: Settings,
    purpose: int,
    i: int,
    start: int,
    count: int,
    total: int,
    watcher: Watcher | None = None,
) -> Walk:
    """Emit and trace photon paths ``start``..``start + count`` of ``total`` in pass ``i``.

    Returns a ``Walk``; its ``order`` grows with path and depth, so that batches can be
    put in one order whatever their size was.
    """
    origins = ROOM.take("photon origins", count, "f4", 3)
    directions = ROOM.take("photon directions", count, "f4", 3)
    paths = ROOM.take("photon paths", count, PHOTON_PATH)
    alive = emit_photons(
        prepared.mesh, prepared.materials, prepared.shading, prepared.lights,
        prepared.light_media, spheres, prepared.aim.histogram, light_cdf, aimed,
        settings.seed, purpose, i, start, count, total, origins, directions, paths,
    )  # fmt: skip
    room = prepared.lobe_room(0)
    meeting = np.zeros(1, HIT)
    each = 2 if prepared.focus.found > 0 and not aimed else 1
    kept = rays = 0
    while alive:
        rays += alive
        hits = prepared.intersector.nearest(origins[:alive], directions[:alive])
        if watcher is not None:
            watcher(paths[:alive], origins[:alive], hits)
        photons = ROOM.take("photons", kept + each * alive, PHOTON, kept=kept)
        order = ROOM.take("order", kept + each * alive, np.int64, kept=kept)
        alive, stored = step_photons(
            prepared.mesh, prepared.materials, room, prepared.shading, prepared.lights,
            prepared.focus, len(prepared.lobes), aimed, settings.photon_depth, hits.face,
            hits.u, hits.v, meeting, alive, origins, directions, paths, photons[kept:],
            order[kept:],
        )  # fmt: skip
        kept += stored
    photons = ROOM.take("photons", kept, PHOTON, kept=kept)
    order = ROOM.take("order", kept, np.int64, kept=kept)
    return Walk(photons.copy(), order.copy(), rays)


@kernel
def _store(photon: Row, hit: Row, path: Row, ratio: float, share: Vector, part: int) -> None:
    """The ``share`` of a photon's flux, per channel, that ``part`` of the lobes answers to."""
    store(photon.position, vector(hit.p))
    store(photon.direction, vector(hit.wo))
    store(photon.normal, vector(hit.ng))
    store(photon.flux, scale(times(vector(path.flux), share), ratio))
    photon.part = part


@kernel
def _survive(path: Row, flux: Vector, weight: Vector, ratio: float, base: int) -> bool:
    """Russian roulette that keeps the flux of the survivors about what it was."""
    new = (
        flux[0] * weight[0] * ratio,
        flux[1] * weight[1] * ratio,
        flux[2] * weight[2] * ratio,
    )
    most = max(new)
    if not most > 0.0:
        return False
    survival = min(1.0, most / max(flux))
    if uniform(path.key, base + _SURVIVAL) >= survival:
        return False
    store(path.flux, scale(new, 1.0 / survival))
    return True


@kernel
def _arrive(
    path: Row,
    hit: Row,
    mesh: Row,
    materials: Table,
    lobes: Table,
    shading: Row,
    spare: int,
    base: int,
    shadowless: bool,
) -> bool:
    """Absorption on the way to a hit, and the lobes there: whether the photon goes through.

    Camera rays would know what kind of ray sees the surface; a photon goes through what
    casts no shadow when it comes from a light, and else through what diffuse rays miss.
    A ``shadowless`` one is not weakened by what lets it through.
    """
    left = transmittance(materials, current_medium(materials, path), hit.way)
    for c in range(3):
        path.flux[c] *= left[c]
    bit = _SHADOW_BIT if path.depth == 0 else _DIFFUSE_BIT
    if goes_through(materials, path, hit, (mesh.visible[hit.face] & bit) != 0):
        return True
    shade(hit, path, mesh, materials, lobes, shading, spare)
    if not materials[hit.row].passes:
        return False
    wide, narrow = lobe_weights(path, lobes)
    if shadowless and wide + narrow > 0.0:
        return False
    through, factor = choose_transparency(
        path, lobes, wide + narrow, uniform(path.key, base + _PASS)
    )
    for c in range(3):
        path.flux[c] *= factor[c]
    return bool(through)


@kernel
def _shines_on(path: Row, wide: float, base: int) -> bool:
    """Whether the photon of a lamp without shadows goes straight on behind a surface.

    It lights all surfaces on its line and is scattered at one of them, by even chances.
    Mirror and glass see such a lamp as any other: only where it is the first thing ahead.
    """
    path.passed += 1
    if path.passed > 1 and wide <= 0.0:
        return True
    for c in range(3):
        path.flux[c] *= 2.0
    on = uniform(path.key, base + _ON) < 0.5
    if on:
        path.part = WIDE
    return bool(on)


@kernel
def _bounce(
    path: Row,
    hit: Row,
    mesh: Row,
    materials: Table,
    lobes: Table,
    shading: Row,
    spare: int,
    caustic: bool,
    base: int,
    ratio: float,
    kept: float,
) -> Any:
    """Scatter a photon at a hit: (whether it lives, wi); ``ratio`` scales its flux.

    ``kept``: what does not count where it lands next. Caustic photons spread once at most.
    """
    spreading, casting = photon_weights(path, lobes)
    if caustic:
        if kept == 1.0:
            spreading = 0.0
        if mesh.visible[hit.face] & _CASTS_NONE and not is_focused(path):
            casting = 0.0
    part = SPREADING
    if path.passed > 1 and path.depth == 0:
        # No caustic photon comes here: gather rays have to see all but the mirror.
        part = WIDE
        spreading, casting = lobe_weights(path, lobes)[0], 0.0
    total = spreading + casting
    nowhere = (0.0, 0.0, 1.0)
    if total <= 0.0:
        return False, nowhere
    if spreading == 0.0 or uniform(path.key, base + _CHOICE) * total < casting:
        part = CASTING
    wi, weight, pdf_w, transmitted, eta = scatter(
        materials, lobes, path, hit, part, uniform(path.key, base + _LOBE),
        uniform(path.key, base + _U), uniform(path.key, base + _V),
    )  # fmt: skip
    if not max(weight) > 0.0:
        return False, nowhere
    if path.visibility & part_bit(path, lobes, part, transmitted) == 0:
        return False, nowhere
    mark(path, hit, lobes, part, wi, pdf_w, kept)
    if hit.own and pdf_w > 0.0:
        weight = adjoint_weight(
            path, hit, mesh, materials, lobes, shading, spare, part, wi, eta, weight
        )
    if transmitted and materials[hit.row].ior > 0.0:
        cross_surface(path, hit.row, hit.entering != 0)
    ratio *= normal_correction(hit, wi) * total / (casting if part == CASTING else spreading)
    alive = _survive(path, vector(path.flux), weight, ratio, base)
    path.visibility = mesh.visible[hit.face]
    if part != CASTING or mesh.visible[hit.face] & _CASTS_NONE:
        path.part = WIDE
    return alive, wi


@kernel
def step_photons(
    mesh: Row,
    materials: Table,
    lobes: Table,
    shading: Row,
    lights: Row,
    focus: Row,
    spare: int,
    caustic: bool,
    most_depth: int,
    hit_face: Table,
    hit_u: Table,
    hit_v: Table,
    hits: Table,
    count: int,
    origins: Table,
    directions: Table,
    paths: Table,
    photons: Table,
    order: Table,
) -> Any:
    """One surface for each photon: store, scatter, compact: (still alive, stored).

    ``caustic`` photons live on what casts alone and are stored only after some.
    ``hits`` (1,) ``HIT`` is room to work in, ``lobes`` has free rows from ``spare`` on.
    """
    alive = 0
    kept = 0
    hit = hits[0]
    for k in range(count):
        if hit_face[k] < 0:
            continue
        path = paths[k]
        u, v = inward(mesh, hit_face[k], hit_u[k], hit_v[k])
        meet(hit, mesh, hit_face[k], u, v, origins, k, path)
        if path.depth == 0 and not reaches(lights, path.entry, read(origins, k), vector(hit.p)):
            continue
        base = FIRST_BOUNCE + _DIMENSIONS * path.steps
        path.steps += 1
        wi = vector(path.direction)
        shadowless = not caustic and path.depth == 0 and not casts_shadow(lights, path.entry)
        if not _arrive(path, hit, mesh, materials, lobes, shading, spare, base, shadowless):
            focused = is_focused(path)
            wide, narrow = lobe_weights(path, lobes)
            cos_g = dot(vector(hit.wo), vector(hit.ng))
            cos_s = dot(vector(hit.wo), vector(hit.ns))
            ratio = min(MOST_CORRECTION, cos_s / cos_g) if cos_g > 0.0 else 0.0
            left, given = share_out(focus, path, hit, lobes, caustic)
            if wide > 0.0 and ratio > 0.0 and path.visibility & _DIFFUSE_BIT:
                shows = (mesh.visible[hit.face] & _SHOWS_NONE) == 0
                if not caustic or focused or (path.depth > 0 and shows):
                    number = path.index * most_depth + path.depth
                    if not caustic or not focused:
                        _store(photons[kept], hit, path, ratio, (left, left, left), path.part)
                        order[kept] = number
                        kept += 1
                    if focused:
                        _store(photons[kept], hit, path, ratio, vector(path.focused), FOCUSED)
                        order[kept] = number
                        kept += 1
            if not shadowless or not _shines_on(path, wide, base):
                if path.depth + 1 >= most_depth:
                    continue
                living, wi = _bounce(
                    path, hit, mesh, materials, lobes, shading, spare, caustic, base, ratio,
                    given,
                )  # fmt: skip
                if not living:
                    continue
                path.depth += 1
        if path.steps >= _MOST_STEPS or not max(vector(path.flux)) > 0.0:
            continue
        if alive != k:
            paths[alive] = paths[k]
        store(paths[alive].direction, wi)
        store(origins[alive], leave(vector(hit.p), vector(hit.ng), wi, hit.offset))
        store(directions[alive], wi)
        alive += 1
    return alive, kept
