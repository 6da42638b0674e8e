"""Choice between a material's lobes, and those of them that scatter into all directions.

Rough glass is not among them: its facets are drawn one by one, like mirrors.
"""

from __future__ import annotations

import math

from ..jit import allocating_kernel as kernel
from ..scene.tables import Model
from .bounces import bounce_factor
from .facets import eval_facets, eval_rough_diffuse, pdf_facets, sample_normal
from .flat import Flat
from .optics import mirrored
from .vector import TWO_PI, Stream, Vec, dot, sample_cosine_power, scaled, times, uniform

_DIFFUSE, _PHONG = int(Model.DIFFUSE), int(Model.PHONG)
_OREN_NAYAR, _GGX = int(Model.OREN_NAYAR), int(Model.GGX)
_TRANSLUCENT = int(Model.TRANSLUCENT)

#: Facets of less slope than this make a mirror.
LEAST_ALPHA = 1e-4

#: What ``choose`` answers for the non-specular lobes taken together.
SPLIT_DIFFUSE = -1


@kernel
def _strength(s: Flat, lobe: int) -> float:
    return (s.lobes[lobe].weight[0] + s.lobes[lobe].weight[1] + s.lobes[lobe].weight[2]) / 3.0


@kernel
def _is_diffuse(s: Flat, lobe: int) -> bool:
    model = s.lobes[lobe].model
    if model == _GGX:
        return s.lobes[lobe].roughness >= LEAST_ALPHA
    return model == _DIFFUSE or model == _PHONG or model == _OREN_NAYAR or model == _TRANSLUCENT


@kernel
def lobes_of(s: Flat, material: int) -> tuple[int, int]:
    """First row of the material's lobes and the one behind the last."""
    start = s.materials[material].lobe_start
    return start, start + s.materials[material].lobe_count


@kernel
def choose(s: Flat, material: int, u: float) -> tuple[int, float]:
    """A specular lobe or ``SPLIT_DIFFUSE``, with its probability; 0 when all is black."""
    first, stop = lobes_of(s, material)
    total, diffuse = 0.0, 0.0
    for lobe in range(first, stop):
        total += _strength(s, lobe)
        if _is_diffuse(s, lobe):
            diffuse += _strength(s, lobe)
    if total <= 0.0:
        return SPLIT_DIFFUSE, 0.0
    left = u * total
    last = -2
    for lobe in range(first, stop):
        if _is_diffuse(s, lobe) or _strength(s, lobe) <= 0.0:
            continue
        last = lobe
        left -= _strength(s, lobe)
        if left < 0.0:
            return lobe, _strength(s, lobe) / total
    if diffuse > 0.0:
        return SPLIT_DIFFUSE, diffuse / total
    # Rounding went past the last specular lobe.
    return last, _strength(s, last) / total


@kernel
def eval_diffuse(s: Flat, material: int, d: Vec, ns: Vec, wi: Vec) -> Vec:
    """Sum of the non-specular lobes' BSDFs [1/sr]; ``d`` arrives."""
    first, stop = lobes_of(s, material)
    r, g, b = 0.0, 0.0, 0.0
    above = dot(wi, ns) > 0.0
    cos_alpha = max(0.0, dot(mirrored(d, ns), wi))
    for lobe in range(first, stop):
        model = s.lobes[lobe].model
        if not _is_diffuse(s, lobe) or above == (model == _TRANSLUCENT):
            continue
        value = 1.0 / math.pi
        f = (value, value, value)
        if model == _PHONG:
            n = s.lobes[lobe].exponent
            value = (n + 2.0) / TWO_PI * cos_alpha**n
            f = (value, value, value)
        elif model == _GGX:
            f = eval_facets(s.lobes[lobe], d, ns, wi)
            f = times(f, bounce_factor(s.bounces[lobe], True, -dot(d, ns)))
        elif model == _OREN_NAYAR:
            f = (
                eval_rough_diffuse(s.lobes[lobe], d, ns, wi, 0),
                eval_rough_diffuse(s.lobes[lobe], d, ns, wi, 1),
                eval_rough_diffuse(s.lobes[lobe], d, ns, wi, 2),
            )
        r += f[0] * s.lobes[lobe].weight[0]
        g += f[1] * s.lobes[lobe].weight[1]
        b += f[2] * s.lobes[lobe].weight[2]
    return r, g, b


@kernel
def pdf_diffuse(s: Flat, material: int, d: Vec, ns: Vec, wi: Vec) -> float:
    """Density of ``sample_diffuse`` per solid angle."""
    first, stop = lobes_of(s, material)
    cos_alpha = max(0.0, dot(mirrored(d, ns), wi))
    total, density = 0.0, 0.0
    for lobe in range(first, stop):
        if not _is_diffuse(s, lobe):
            continue
        share = _strength(s, lobe)
        total += share
        if s.lobes[lobe].model == _PHONG:
            n = s.lobes[lobe].exponent
            density += share * (n + 1.0) / TWO_PI * cos_alpha**n
        elif s.lobes[lobe].model == _GGX:
            density += share * pdf_facets(s.lobes[lobe], d, ns, wi)
        elif s.lobes[lobe].model == _TRANSLUCENT:
            density += share * max(0.0, -dot(wi, ns)) / math.pi
        else:
            density += share * max(0.0, dot(wi, ns)) / math.pi
    return density / total if total > 0.0 else 0.0


@kernel
def sample_diffuse(s: Flat, material: int, d: Vec, ns: Vec, stream: Stream) -> Vec:
    """A direction of one non-specular lobe, chosen by weight; may point below ``ns``."""
    first, stop = lobes_of(s, material)
    total = 0.0
    for lobe in range(first, stop):
        if _is_diffuse(s, lobe):
            total += _strength(s, lobe)
    left = uniform(stream) * total
    chosen = -1
    for lobe in range(first, stop):
        if _is_diffuse(s, lobe) and _strength(s, lobe) > 0.0:
            chosen = lobe
            left -= _strength(s, lobe)
            if left < 0.0:
                break
    u, v = uniform(stream), uniform(stream)
    if s.lobes[chosen].model == _PHONG:
        return sample_cosine_power(mirrored(d, ns), s.lobes[chosen].exponent, u, v)
    if s.lobes[chosen].model == _GGX:
        return mirrored(d, sample_normal(ns, s.lobes[chosen].roughness, u, v))
    if s.lobes[chosen].model == _TRANSLUCENT:
        return sample_cosine_power(scaled(ns, -1.0), 1.0, u, v)
    return sample_cosine_power(ns, 1.0, u, v)
