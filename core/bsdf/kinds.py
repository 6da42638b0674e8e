"""The colour of a surface, apart by what its light does: diffuse, glossy, transmitted."""

from __future__ import annotations

from ..geometry.vector import Vector, add, dot, scale, times, vector
from ..jit import Row, Table, kernel
from .albedo import albedo_ggx, mean_rise
from .dispatch import part_share
from .fresnel import fresnel_dielectric
from .lobe import (
    DIELECTRIC,
    GGX,
    GGX_DIELECTRIC,
    LEAST_ALPHA,
    NO_FRESNEL,
    REFRACTION,
    SCHLICK,
    TRANSLUCENT,
    TRANSPARENT,
    TRUE_FRESNEL,
    eval_lobe,
    is_diffuse_like,
    is_rough_glass,
    reflectance,
    transmittance,
)

DIFFUSE_KIND = 0
GLOSSY_KIND = 1
TRANSMITTED_KIND = 2
_MIXED = -1
_WHITE = (1.0, 1.0, 1.0)
_BLACK = (0.0, 0.0, 0.0)


@kernel
def _mean_reflectance(lobe: Row, tables: Row, cosine: float) -> Vector:
    """What the facets of a GGX lobe reflect of light seen at ``cosine``."""
    if lobe.roughness < LEAST_ALPHA or len(tables.ggx) == 0:
        return reflectance(lobe, cosine)
    whole = albedo_ggx(tables, lobe.roughness, cosine)
    kind = lobe.fresnel
    if lobe.model == GGX_DIELECTRIC and kind == NO_FRESNEL:
        kind = TRUE_FRESNEL
    if kind != TRUE_FRESNEL and kind != SCHLICK:
        return scale(reflectance(lobe, cosine), whole)
    rise = mean_rise(tables, lobe.roughness, cosine, lobe.eta)
    f0 = vector(lobe.f0)
    if kind == TRUE_FRESNEL:
        f = ((lobe.eta - 1.0) / (lobe.eta + 1.0)) ** 2
        f0 = (f, f, f)
    return (
        whole * (f0[0] + (1.0 - f0[0]) * rise),
        whole * (f0[1] + (1.0 - f0[1]) * rise),
        whole * (f0[2] + (1.0 - f0[2]) * rise),
    )


@kernel
def _colors(lobe: Row, tables: Row, cosine: float, eta: float) -> tuple[Vector, Vector]:
    """What a lobe that is not diffuse reflects and what it transmits."""
    model = lobe.model
    if model == DIELECTRIC or model == REFRACTION:
        f, cos_t = fresnel_dielectric(cosine, eta)
        if model == REFRACTION:
            f = 1.0 if cos_t == 0.0 else 0.0
            return _BLACK, (1.0 - f, 1.0 - f, 1.0 - f)
        return (f, f, f), (1.0 - f, 1.0 - f, 1.0 - f)
    if model == GGX_DIELECTRIC:
        r = _mean_reflectance(lobe, tables, cosine)
        t = lobe.f90
        return r, ((1.0 - r[0]) * t[0], (1.0 - r[1]) * t[1], (1.0 - r[2]) * t[2])
    if is_rough_glass(model):
        return _BLACK, transmittance(lobe, cosine)
    if model == GGX:
        return _mean_reflectance(lobe, tables, cosine), _BLACK
    return _WHITE, _BLACK


@kernel
def colors_by_kind(
    surface: Row, lobes: Table, tables: Row, cosine: float, eta: float
) -> tuple[Vector, Vector, Vector]:
    """(diffuse, glossy, transmitted) albedo of a surface seen at ``cosine``.

    Translucent lobes count as diffuse, transparent ones not at all. ``tables``:
    ``albedo.AlbedoTables``; ``eta``: ratio of the indices of smooth glass at this hit.
    """
    diffuse = _BLACK
    glossy = _BLACK
    transmitted = _BLACK
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        lobe = lobes[k]
        weight = vector(lobe.weight)
        if lobe.model == TRANSPARENT:
            continue
        if is_diffuse_like(lobe.model) or lobe.model == TRANSLUCENT:
            diffuse = add(diffuse, weight)
            continue
        r, t = _colors(lobe, tables, cosine, eta)
        glossy = add(glossy, times(weight, r))
        transmitted = add(transmitted, times(weight, t))
    return diffuse, glossy, transmitted


@kernel
def one_kind(surface: Row, lobes: Table) -> int:
    """The kind of all that a surface scatters, -1 when there are several or none."""
    found = _MIXED
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        model = lobes[k].model
        if model == TRANSPARENT:
            continue
        kind = GLOSSY_KIND
        if is_diffuse_like(model) or model == TRANSLUCENT:
            kind = DIFFUSE_KIND
        elif model == GGX_DIELECTRIC or model == DIELECTRIC:
            return _MIXED
        elif is_rough_glass(model) or model == REFRACTION:
            kind = TRANSMITTED_KIND
        if found != _MIXED and found != kind:
            return _MIXED
        found = kind
    return found


@kernel
def eval_kinds(
    surface: Row, lobes: Table, n: Vector, wo: Vector, wi: Vector, part: int
) -> tuple[Vector, Vector, Vector]:
    """``dispatch.eval_part`` apart: (diffuse, glossy, transmitted), kinds as below."""
    diffuse = _BLACK
    glossy = _BLACK
    transmitted = _BLACK
    for k in range(surface.lobe_start, surface.lobe_start + surface.lobe_count):
        lobe = lobes[k]
        share = part_share(lobe, part)
        if share <= 0.0:
            continue
        f = scale(eval_lobe(lobe, n, wo, wi), share)
        if is_diffuse_like(lobe.model) or lobe.model == TRANSLUCENT:
            diffuse = add(diffuse, f)
        elif dot(n, wi) < 0.0:
            transmitted = add(transmitted, f)
        else:
            glossy = add(glossy, f)
    return diffuse, glossy, transmitted
