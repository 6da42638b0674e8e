"""One camera path: a loop of hits, light sampling at D vertices, and scattering."""

from __future__ import annotations

import math

import numpy as np

from ..jit import allocating_kernel as kernel
from ..scene.tables import Visibility
from .bounces import bounce_factor
from .brute import blocked, closest, shading_normal
from .flat import Flat, Floats
from .lamps import sample_lamp, seen_lamps
from .lobes import SPLIT_DIFFUSE, choose, eval_diffuse, pdf_diffuse, sample_diffuse
from .media import Stack
from .sky import sky_radiance
from .specular import PASSED, REFLECTED, scatter_specular
from .vector import Stream, Vec, along, dot, scaled, times, uniform, vec

LAYERS = 4
EMISSION, DIRECT, CAUSTICS, INDIRECT = range(LAYERS)
_CAMERA, _DIFFUSE = int(Visibility.CAMERA), int(Visibility.DIFFUSE)
_GLOSSY, _TRANSMISSION = int(Visibility.GLOSSY), int(Visibility.TRANSMISSION)
_ROULETTE_FROM, _ROULETTE_FIRMLY = 6, 64


@kernel
def _layer(diffuse: int, chain: int) -> int:
    """Layer of light found after ``diffuse`` D vertices and ``chain`` S vertices since."""
    if diffuse == 0:
        return EMISSION
    if diffuse > 1:
        return INDIRECT
    return DIRECT if chain == 0 else CAUSTICS


@kernel
def _add(light: Floats, layer: int, rgb: Vec) -> None:
    light[layer, 0] += rgb[0]
    light[layer, 1] += rgb[1]
    light[layer, 2] += rgb[2]


@kernel
def walk(
    s: Flat, o: Vec, d: Vec, far: float, stack: Stack, scratch: Stack, stream: Stream,
    light: Floats,
) -> None:  # fmt: skip
    """Add the radiance that arrives at ``o`` from ``d`` to ``light`` (LAYERS + 1, 3).

    The first ray sees things up to ``far``.

    ``beta`` is the throughput without the radiance scale (n_i / n_t)^2, kept in ``scale``:
    roulette must not judge a path by the medium it happens to be in.
    """
    beta, scale = (1.0, 1.0, 1.0), 1.0
    diffuse, chain, ray_kind, skip, pdf = 0, 0, _CAMERA, -1, 0.0
    bounce = 0
    while True:
        reach = far if bounce == 0 else math.inf
        t, face, u, v = closest(s, o, d, skip, reach)
        layer = _layer(diffuse, chain)
        sampled = diffuse > 0 and chain == 0
        if not sampled:
            lamps = seen_lamps(s, o, d, t, face < 0, ray_kind)
            _add(light, layer, scaled(times(beta, lamps), scale))
        if face < 0:
            # The sky is never light-sampled: scattering alone finds it, once.
            if s.sky_visibility & (_DIFFUSE if sampled else ray_kind):
                _add(light, layer, scaled(times(beta, sky_radiance(s, d)), scale))
            return
        material = s.faces[face].material
        ng = vec(s.faces[face].normal)
        entering = dot(d, ng) < 0.0
        if s.faces[face].density > 0.0:
            share = 1.0
            if sampled:
                other = s.faces[face].density * t * t / abs(dot(d, ng))
                share = pdf / (pdf + other)
            glow = vec(s.materials[material].emission)
            _add(light, layer, scaled(times(beta, glow), scale * share))
        bounce += 1
        if bounce >= _ROULETTE_FROM:
            survive = min(1.0, max(beta[0], max(beta[1], beta[2])))
            if bounce >= _ROULETTE_FIRMLY:
                survive = min(survive, 0.9)
            if uniform(stream) >= survive:
                return
            beta = scaled(beta, 1.0 / survive)
        p = along(o, d, t)
        if not entering:
            ng = scaled(ng, -1.0)
        ns = shading_normal(s, face, u, v, d, ng)
        lobe, prob = choose(s, material, uniform(stream))
        if prob <= 0.0:
            return
        beta = scaled(beta, 1.0 / prob)
        if lobe == SPLIT_DIFFUSE:
            diffuse, chain = diffuse + 1, 0
            _light_sampling(s, p, d, ng, ns, material, face, scaled(beta, scale),
                            _layer(diffuse, 0), stream, light)  # fmt: skip
            wi = sample_diffuse(s, material, d, ns, stream)
            pdf = pdf_diffuse(s, material, d, ns, wi)
            if dot(wi, ng) * dot(wi, ns) <= 0.0 or pdf <= 0.0:
                return
            cosine = abs(dot(wi, ns))
            beta = times(beta, scaled(eval_diffuse(s, material, d, ns, wi), cosine / pdf))
            d = wi
        else:
            cos_seen = -dot(d, ns)
            event, d, factor, tint = scatter_specular(
                s, lobe, material, d, ng, ns, entering, stack, scratch, stream
            )
            if event == PASSED:
                ray_kind, scale = _TRANSMISSION, scale * factor
            elif event == REFLECTED:
                ray_kind = _GLOSSY
            else:
                return
            beta = times(beta, times(tint, vec(s.lobes[lobe].weight)))
            beta = times(beta, bounce_factor(s.bounces[lobe], entering, cos_seen))
            chain += 1
        o, skip = p, face


@kernel
def _light_sampling(
    s: Flat, p: Vec, d: Vec, ng: Vec, ns: Vec, material: int, face: int, beta: Vec,
    layer: int, stream: Stream, light: Floats,
) -> None:  # fmt: skip
    """Light straight from every lamp and from one point of the emissive faces."""
    for lamp in range(len(s.lamps)):
        if not s.lamps[lamp].visibility & _DIFFUSE:
            continue
        wi, distance, radiance = sample_lamp(s, lamp, p, stream)
        cosine = abs(dot(wi, ns))
        if distance <= 0.0 or dot(wi, ns) * dot(wi, ng) <= 0.0:
            continue
        if radiance[0] + radiance[1] + radiance[2] <= 0.0:
            continue
        if not blocked(s, p, wi, face, -1, distance):
            f = eval_diffuse(s, material, d, ns, wi)
            _add(light, layer, scaled(times(beta, times(f, radiance)), cosine))
    if len(s.emitter) == 0:
        return
    k = int(np.searchsorted(s.emitter_cdf, uniform(stream), side="right"))
    target = int(s.emitter[min(k, len(s.emitter) - 1)])
    root, b = math.sqrt(uniform(stream)), uniform(stream)
    point = along(vec(s.faces[target].base), vec(s.faces[target].edge_1), root * (1.0 - b))
    point = along(point, vec(s.faces[target].edge_2), root * b)
    to_light = along(point, p, -1.0)
    square = dot(to_light, to_light)
    if target == face or square == 0.0:
        return
    distance = math.sqrt(square)
    wi = scaled(to_light, 1.0 / distance)
    cosine, cos_light = abs(dot(wi, ns)), abs(dot(wi, vec(s.faces[target].normal)))
    if dot(wi, ns) * dot(wi, ng) <= 0.0 or cos_light <= 0.0:
        return
    if not blocked(s, p, wi, face, target, distance):
        density = s.faces[target].density * square / cos_light
        # Balance heuristic (Veach & Guibas 1995): the other strategy is scattering.
        total = density + pdf_diffuse(s, material, d, ns, wi)
        rgb = times(
            eval_diffuse(s, material, d, ns, wi),
            vec(s.materials[s.faces[target].material].emission),
        )
        _add(light, layer, scaled(times(beta, rgb), cosine / total))
