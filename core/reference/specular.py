"""Scattering at a specular lobe: reflect, refract or end, with the media kept in step.

Rough glass is a heap of small smooth facets: one is drawn, and light meets it as it would
meet smooth glass.
"""

from __future__ import annotations

from ..jit import allocating_kernel as kernel
from ..scene.tables import Model
from .facets import fresnel_of, sample_normal, visible_both_ways
from .flat import Flat
from .lobes import LEAST_ALPHA
from .media import Stack, cross_surface
from .optics import mirrored, reflectance, refracted
from .vector import Stream, Vec, dot, uniform

_CONDUCTOR, _DIELECTRIC = int(Model.CONDUCTOR), int(Model.DIELECTRIC)
_TRANSPARENT, _GGX = int(Model.TRANSPARENT), int(Model.GGX)
_GGX_DIELECTRIC, _GGX_REFRACTION = int(Model.GGX_DIELECTRIC), int(Model.GGX_REFRACTION)
_WHITE = (1.0, 1.0, 1.0)
ENDED, REFLECTED, PASSED = range(3)


@kernel
def _event(d: Vec, n: Vec, n_i: float, n_t: float, fresnel: bool, u: float) -> tuple[int, Vec]:
    """Reflect or refract at a smooth interface of normal ``n``, which faces ``d``."""
    if fresnel and u < reflectance(-dot(d, n), n_i, n_t):
        return REFLECTED, mirrored(d, n)
    passes, out = refracted(d, n, n_i, n_t)
    return (PASSED if passes else ENDED), out


@kernel
def _rough_event(
    d: Vec, n: Vec, alpha: float, n_i: float, n_t: float, fresnel: bool, stream: Stream
) -> tuple[int, Vec, float]:
    """The same at a facet: event, direction, and what masking leaves over the density."""
    h = sample_normal(n, alpha, uniform(stream), uniform(stream))
    cos_d, cos_h = -dot(d, h), dot(h, n)
    u = uniform(stream)
    if cos_d <= 0.0:
        return ENDED, d, 0.0
    event, out = _event(d, h, n_i, n_t, fresnel, u)
    cos_out = abs(dot(out, n))
    if event == ENDED or (dot(out, n) < 0.0) != (event == PASSED) or cos_out == 0.0:
        return ENDED, d, 0.0
    # f cos / density of Walter et al. 2007, equation 41.
    kept = cos_d * visible_both_ways(-dot(d, n), cos_out, alpha) / (-dot(d, n) * cos_h)
    return event, out, kept


@kernel
def scatter_specular(
    s: Flat, lobe: int, material: int, d: Vec, ng: Vec, ns: Vec, entering: bool,
    stack: Stack, scratch: Stack, stream: Stream,
) -> tuple[int, Vec, float, Vec]:  # fmt: skip
    """Event, new direction, radiance scale (n_i / n_t)^2, colour; changes ``stack`` on passing.

    ``ng`` and ``ns`` face the arriving ray of direction ``d``. Where the shading normal
    would send light to the wrong side, the same event happens about ``ng``.
    """
    model = s.lobes[lobe].model
    if model == _TRANSPARENT:
        return PASSED, d, 1.0, _WHITE
    if model == _CONDUCTOR or model == _GGX:
        out = mirrored(d, ns)
        out = out if dot(out, ng) > 0.0 else mirrored(d, ng)
        tint = fresnel_of(s.lobes[lobe], -dot(d, ns)) if model == _GGX else _WHITE
        return REFLECTED, out, 1.0, tint
    n_i, n_t = cross_surface(s, stack, material, entering, scratch)
    fresnel = model == _DIELECTRIC or model == _GGX_DIELECTRIC
    alpha = s.lobes[lobe].roughness
    kept = 1.0
    if (model == _GGX_DIELECTRIC or model == _GGX_REFRACTION) and alpha >= LEAST_ALPHA:
        event, out, kept = _rough_event(d, ns, alpha, n_i, n_t, fresnel, stream)
        if event != ENDED and (dot(out, ng) < 0.0) != (event == PASSED):
            event = ENDED
    else:
        u = uniform(stream)
        event, out = _event(d, ns, n_i, n_t, fresnel, u)
        if event != ENDED and (dot(out, ng) < 0.0) != (event == PASSED):
            event, out = _event(d, ng, n_i, n_t, fresnel, u)
    if event != PASSED:
        return event, out, 1.0, (kept, kept, kept)
    stack[:] = scratch
    ratio = n_i / n_t
    return PASSED, out, ratio * ratio, (kept, kept, kept)
