"""Scattering at a specular lobe: reflect, refract or end, with the media kept in step."""

from __future__ import annotations

from ..jit import allocating_kernel as kernel
from ..scene.tables import Model
from .flat import Flat
from .media import Stack, cross_surface
from .optics import mirrored, reflectance, refracted
from .vector import Stream, Vec, dot, uniform

_CONDUCTOR, _DIELECTRIC = int(Model.CONDUCTOR), int(Model.DIELECTRIC)
ENDED, REFLECTED, PASSED = range(3)


@kernel
def _event(d: Vec, n: Vec, n_i: float, n_t: float, fresnel: bool, u: float) -> tuple[int, Vec]:
    """Reflect or refract at a smooth interface of normal ``n``, which faces ``d``."""
    if fresnel and u < reflectance(-dot(d, n), n_i, n_t):
        return REFLECTED, mirrored(d, n)
    passes, out = refracted(d, n, n_i, n_t)
    return (PASSED if passes else ENDED), out


@kernel
def scatter_specular(
    s: Flat, lobe: int, material: int, d: Vec, ng: Vec, ns: Vec, entering: bool,
    stack: Stack, scratch: Stack, stream: Stream,
) -> tuple[int, Vec, float]:  # fmt: skip
    """Event, new direction and radiance scale (n_i / n_t)^2; changes ``stack`` on passing.

    ``ng`` and ``ns`` face the arriving ray of direction ``d``. Where the shading normal
    would send light to the wrong side, the same event happens about ``ng``.
    """
    if s.lobes[lobe].model == _CONDUCTOR:
        out = mirrored(d, ns)
        return REFLECTED, (out if dot(out, ng) > 0.0 else mirrored(d, ng)), 1.0
    n_i, n_t = cross_surface(s, stack, material, entering, scratch)
    fresnel = s.lobes[lobe].model == _DIELECTRIC
    u = uniform(stream)
    event, out = _event(d, ns, n_i, n_t, fresnel, u)
    if event != ENDED and (dot(out, ng) < 0.0) != (event == PASSED):
        event, out = _event(d, ng, n_i, n_t, fresnel, u)
    if event != PASSED:
        return event, out, 1.0
    stack[:] = scratch
    ratio = n_i / n_t
    return PASSED, out, ratio * ratio
