"""Photons leave the lights: by power over the whole scene, or aimed at the casters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..bsdf.dispatch import SPREADING, WIDE
from ..geometry.interaction import OFFSET
from ..geometry.media import STACK
from ..geometry.vector import Vector, along, dot, store, to_world
from ..jit import Row, Table, kernel
from ..lights.dispatch import visibility_of
from ..lights.emission import (
    emitted,
    sample_anchor,
    sample_distant,
    sample_natural,
)
from ..sampling.distributions import probability, sample_discrete
from ..sampling.rng import stream, uniform
from ..sampling.warps import sample_disk
from .aim import aim_distant, aim_local
from .emission_histogram import emission_numbers, warp_emission

#: One photon on its way. ``flux`` [W] per channel; ``direction`` of travel; ``index`` of
#: its path in the pass; ``depth``: events so far, ``steps``: surfaces so far;
#: ``visibility`` bits of what it comes from, its light ``entry`` or the object of its last
#: event; ``passed``: surfaces that it met on its straight way from a lamp without shadows;
#: ``part`` of the lobes that answers to it (``trace.PHOTON``); ``focused``: the share of its
#: flux, per channel, that counts where it lands since it left a crowded place (``focus``);
#: ``lobe_start`` and ``lobe_count``: the lobes of the surface that it is on.
PHOTON_PATH = np.dtype(
    [
        ("key", "u8"),
        ("index", "i8"),
        ("flux", "f8", 3),
        ("direction", "f8", 3),
        ("focused", "f8", 3),
        ("depth", "i4"),
        ("steps", "i4"),
        ("lobe_start", "i4"),
        ("lobe_count", "i4"),
        ("visibility", "i4"),
        ("entry", "i4"),
        ("passed", "i4"),
        ("part", "i4"),
        ("media_count", "i4"),
        ("media", "i4", STACK),
    ],
    align=True,
)

# Dimensions of a photon's stream that emission uses; the bounces follow.
_FACE, _SIDE = 0, 1
FIRST_BOUNCE = 8


@kernel
def _distant_origin(
    lights: Row, spheres: Table, aimed: bool, w: Vector, u_disc: float, u: float, v: float
) -> Any:
    """Start of a distant light's beam outside the scene: (origin, pdf_a)."""
    if aimed:
        p, pdf_a = aim_distant(spheres, w, u_disc, u, v)
    else:
        x, y = sample_disk(u, v)
        p = to_world((lights.radius * x, lights.radius * y, 0.0), w)
        pdf_a = 1.0 / (math.pi * lights.radius * lights.radius)
    back = 1.01 * lights.radius + dot(p, w)
    return along(p, w, -back), pdf_a


@kernel
def _leave(path: Row, lights: Row, light_media: Table, entry: int) -> None:
    """Nothing has happened yet to a photon of light ``entry``."""
    path.depth = path.steps = path.passed = 0
    store(path.focused, (0.0, 0.0, 0.0))
    path.visibility = visibility_of(lights, entry)
    path.entry = entry
    path.media_count = light_media[entry, 0]
    for j in range(light_media[entry, 0]):
        path.media[j] = light_media[entry, 1 + j]


@kernel
def emit_photons(
    mesh: Row,
    materials: Table,
    shading: Row,
    lights: Row,
    light_media: Table,
    spheres: Table,
    histogram: Row,
    light_cdf: Table,
    aimed: bool,
    seed: int,
    purpose: int,
    i: int,
    start: int,
    count: int,
    total: int,
    origins: Table,
    directions: Table,
    paths: Table,
) -> Any:
    """Emit photon paths ``start``..``start + count`` of ``total``: how many have power.

    Writes rays into ``origins`` and ``directions`` (n, 3) f4 and records into ``paths``
    (n,) ``PHOTON_PATH``. Photons of a pass are points of one scrambled sequence, so they
    are stratified over lights, positions and directions. ``histogram`` warps the numbers of
    those that are ``aimed`` at ``spheres``.
    """
    out = 0
    scramble = stream(seed, purpose, i, -1)
    for k in range(start, start + count):
        key = stream(seed, purpose, i, k)
        u_light, u_cone, u, v, s, t = emission_numbers(scramble, k)
        entry = sample_discrete(light_cdf, u_light)
        prob = probability(light_cdf, entry)
        if prob <= 0.0:
            continue
        if aimed:
            u_cone, u, v, density = warp_emission(histogram, entry, u_cone, u, v)
            prob *= density
        if lights.distant[entry]:
            w, power = sample_distant(lights, entry, s, t)
            origin, pdf = _distant_origin(lights, spheres, aimed, w, u_cone, u, v)
        else:
            anchor, normal, margin, face = sample_anchor(
                lights, mesh, materials, entry, uniform(key, _FACE), s, t
            )
            if aimed:
                w, pdf = aim_local(spheres, anchor, normal, margin, u_cone, u, v)
            else:
                w, pdf = sample_natural(lights, mesh, entry, face, uniform(key, _SIDE), u, v)
            origin, n, power = emitted(
                lights, mesh, materials, shading, entry, face, anchor, w, s, t
            )
            if face < 0:
                n = normal
            if dot(n, n) > 0.0:
                # Off the face it starts on, and off the ceiling a lamp is snapped to.
                reach = max(abs(origin[0]), abs(origin[1]), abs(origin[2]))
                side = OFFSET * (lights.radius if reach < lights.radius else reach)
                origin = along(origin, n, side if dot(n, w) > 0.0 else -side)
        if pdf <= 0.0:
            continue
        share = 1.0 / (pdf * prob * total)
        flux = (power[0] * share, power[1] * share, power[2] * share)
        if not (flux[0] + flux[1] + flux[2] > 0.0):
            continue
        path = paths[out]
        path.key = key
        path.index = k
        path.part = WIDE if aimed else SPREADING
        store(path.flux, flux)
        store(path.direction, w)
        _leave(path, lights, light_media, entry)
        store(origins[out], origin)
        store(directions[out], w)
        out += 1
    return out
