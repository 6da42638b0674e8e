"""Choice between a material's lobes, and its non-specular ones: Lambert and Phong."""

from __future__ import annotations

import math

from ..jit import allocating_kernel as kernel
from ..scene.tables import Model
from .flat import Flat
from .optics import mirrored
from .vector import TWO_PI, Stream, Vec, dot, sample_cosine_power, uniform

_DIFFUSE, _PHONG = int(Model.DIFFUSE), int(Model.PHONG)

#: What ``choose`` answers for the non-specular lobes taken together.
SPLIT_DIFFUSE = -1


@kernel
def _strength(s: Flat, lobe: int) -> float:
    return (s.lobes[lobe].weight[0] + s.lobes[lobe].weight[1] + s.lobes[lobe].weight[2]) / 3.0


@kernel
def _is_diffuse(s: Flat, lobe: int) -> bool:
    return s.lobes[lobe].model == _DIFFUSE or s.lobes[lobe].model == _PHONG


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
    """Sum of the non-specular lobes' BSDFs [1/sr]; ``d`` arrives, both sides alike."""
    first, stop = lobes_of(s, material)
    r, g, b = 0.0, 0.0, 0.0
    cos_alpha = max(0.0, dot(mirrored(d, ns), wi))
    for lobe in range(first, stop):
        if not _is_diffuse(s, lobe):
            continue
        value = 1.0 / math.pi
        if s.lobes[lobe].model == _PHONG:
            n = s.lobes[lobe].exponent
            value = (n + 2.0) / TWO_PI * cos_alpha**n
        r += value * s.lobes[lobe].weight[0]
        g += value * s.lobes[lobe].weight[1]
        b += value * s.lobes[lobe].weight[2]
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
    return sample_cosine_power(ns, 1.0, u, v)
