"""Shader nodes as lobes: what each one scatters at a hit, seen from ``wo``.

Each function writes lobes from row ``at`` on and returns the row behind the last. There is
room for ``MOST_LOBES`` at a hit. ``weight`` (3,): mix factors and layers above; ``cosine``
that of the viewer; ``tables``: ``albedo.AlbedoTables``.
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector, store, times
from ..jit import Row, Table, kernel
from .albedo import (
    albedo_ggx,
    mean_fresnel_dielectric,
    mean_rise,
    multiscatter,
    multiscatter_glass,
)
from .fresnel import f82_dip, fresnel_f82, normal_reflectance
from .lobe import (
    DIFFUSE,
    F82,
    GGX,
    GGX_DIELECTRIC,
    LEAST_ALPHA,
    LEAST_STEP,
    NO_FRESNEL,
    OREN_NAYAR,
    SCHLICK,
    SHEEN,
    TRUE_FRESNEL,
)
from .sheen import sheen_at

#: A weight below this scatters nothing worth a lobe.
LEAST_WEIGHT = 1e-7
#: Below this roughness a diffuse surface is Lambert's.
_LEAST_DIFFUSE_ROUGHNESS = 1e-5
_WHITE = (1.0, 1.0, 1.0)
_BLACK = (0.0, 0.0, 0.0)


@kernel
def largest(a: Vector) -> float:
    """Largest channel."""
    return max(a[0], max(a[1], a[2]))


@kernel
def clamped(a: Vector) -> Vector:
    """Each channel held within 0..1."""
    return (
        min(1.0, max(0.0, a[0])),
        min(1.0, max(0.0, a[1])),
        min(1.0, max(0.0, a[2])),
    )


@kernel
def put(
    lobes: Table,
    at: int,
    model: int,
    weight: Vector,
    albedo: float,
    roughness: float,
    eta: float,
    fresnel: int,
    f0: Vector,
    f90: Vector,
) -> int:
    """Write a lobe that scatters about ``albedo`` of its weight; black ones are left out."""
    if not largest(weight) > LEAST_WEIGHT:
        return at
    lobe = lobes[at]
    lobe.model = model
    lobe.fresnel = fresnel
    store(lobe.weight, weight)
    # Never quite zero: what scatters must be drawn sometimes.
    share = (weight[0] + weight[1] + weight[2]) / 3.0
    lobe.share = share * min(1.0, max(0.02, albedo))
    lobe.ior = eta
    lobe.exponent = 0.0
    lobe.roughness = roughness
    lobe.eta = eta
    store(lobe.f0, f0)
    store(lobe.f90, f90)
    return at + 1


@kernel
def put_plain(lobes: Table, at: int, model: int, weight: Vector) -> int:
    """A lobe without parameters."""
    return put(lobes, at, model, weight, 1.0, 0.0, 1.0, NO_FRESNEL, _BLACK, _WHITE)


@kernel
def put_diffuse(lobes: Table, at: int, weight: Vector, color: Vector, roughness: float) -> int:
    """Diffuse reflection of facets of albedo ``color``."""
    w = times(weight, color)
    if roughness < _LEAST_DIFFUSE_ROUGHNESS:
        return put_plain(lobes, at, DIFFUSE, w)
    return put(
        lobes, at, OREN_NAYAR, w, 1.0, min(1.0, roughness), 1.0, NO_FRESNEL,
        clamped(color), _WHITE,
    )  # fmt: skip


@kernel
def _compensated(
    tables: Row, alpha: float, cosine: float, mean_fresnel: Vector, multi: bool
) -> Vector:
    """Factor per channel for the bounces between facets, 1 without them."""
    if not multi or alpha < LEAST_ALPHA:
        return _WHITE
    return (
        multiscatter(tables, alpha, cosine, min(1.0, mean_fresnel[0])),
        multiscatter(tables, alpha, cosine, min(1.0, mean_fresnel[1])),
        multiscatter(tables, alpha, cosine, min(1.0, mean_fresnel[2])),
    )


@kernel
def put_glossy(
    lobes: Table,
    at: int,
    tables: Row,
    weight: Vector,
    color: Vector,
    alpha: float,
    cosine: float,
    multi: bool,
) -> int:
    """A rough mirror that reflects ``color`` at every angle."""
    w = times(times(weight, color), _compensated(tables, alpha, cosine, clamped(color), multi))
    return put(lobes, at, GGX, w, 1.0, alpha, 1.0, NO_FRESNEL, _BLACK, _WHITE)


@kernel
def _mean_f82(f0: float, tint: float) -> float:
    """Cosine-weighted mean of the F82 reflectance: the integrals of its two terms."""
    return f0 + (1.0 - f0) / 21.0 - f82_dip(f0, tint) / 126.0


@kernel
def put_metal(
    lobes: Table,
    at: int,
    tables: Row,
    weight: Vector,
    f0: Vector,
    tint: Vector,
    alpha: float,
    cosine: float,
    multi: bool,
) -> int:
    """A metal of reflectance ``f0`` and of ``tint`` towards grazing (F82)."""
    f0 = clamped(f0)
    tint = clamped(tint)
    mean = (_mean_f82(f0[0], tint[0]), _mean_f82(f0[1], tint[1]), _mean_f82(f0[2], tint[2]))
    w = times(weight, _compensated(tables, alpha, cosine, clamped(mean), multi))
    seen = fresnel_f82(cosine, (f0[0] + f0[1] + f0[2]) / 3.0, 1.0)
    return put(lobes, at, GGX, w, seen, alpha, 1.0, F82, f0, tint)


@kernel
def _mean_curve(f0: Vector, eta: float) -> Vector:
    """Cosine-weighted mean of a dielectric's reflectance, stretched to begin at ``f0``."""
    real = normal_reflectance(eta)
    rise = 0.0
    if real < 1.0:
        rise = min(1.0, max(0.0, (mean_fresnel_dielectric(eta) - real) / (1.0 - real)))
    return (
        f0[0] + (1.0 - f0[0]) * rise,
        f0[1] + (1.0 - f0[1]) * rise,
        f0[2] + (1.0 - f0[2]) * rise,
    )


@kernel
def put_reflection(
    lobes: Table,
    at: int,
    tables: Row,
    weight: Vector,
    f0: Vector,
    alpha: float,
    eta: float,
    cosine: float,
    multi: bool,
) -> tuple[int, float]:
    """A dielectric's reflection alone: (next row, its largest albedo over ``weight``).

    The true curve of ``eta``, stretched to begin at ``f0``.
    """
    f0 = clamped(f0)
    factor = _compensated(tables, alpha, cosine, _mean_curve(f0, eta), multi)
    # Without the bounces between facets the layer below is dimmed as if there were some:
    # it does not see what they lose (as in Cycles).
    whole = albedo_ggx(tables, alpha, cosine) if multi else 1.0
    risen = mean_rise(tables, alpha, cosine, eta)
    albedo = (
        factor[0] * whole * (f0[0] + (1.0 - f0[0]) * risen),
        factor[1] * whole * (f0[1] + (1.0 - f0[1]) * risen),
        factor[2] * whole * (f0[2] + (1.0 - f0[2]) * risen),
    )
    mean_albedo = (albedo[0] + albedo[1] + albedo[2]) / 3.0
    at = put(
        lobes, at, GGX, times(weight, factor), mean_albedo, alpha, eta, SCHLICK, f0, _WHITE
    )
    return at, largest(albedo)


@kernel
def _compensated_glass(
    tables: Row, alpha: float, eta: float, cosine: float, kept: Vector, multi: bool
) -> Vector:
    """As ``_compensated``, for glass whose facets keep ``kept`` of what meets them."""
    if not multi or alpha < LEAST_ALPHA or abs(eta - 1.0) < LEAST_STEP:
        return _WHITE
    return (
        multiscatter_glass(tables, alpha, cosine, eta, kept[0]),
        multiscatter_glass(tables, alpha, cosine, eta, kept[1]),
        multiscatter_glass(tables, alpha, cosine, eta, kept[2]),
    )


@kernel
def put_tinted_glass(
    lobes: Table,
    at: int,
    tables: Row,
    weight: Vector,
    f0: Vector,
    tint: Vector,
    alpha: float,
    eta: float,
    cosine: float,
    multi: bool,
) -> int:
    """Rough glass: reflection from ``f0`` on, the rest transmitted and tinted."""
    # Between facets most of the light is transmitted: its tint is that of the bounces.
    w = times(weight, _compensated_glass(tables, alpha, eta, cosine, tint, multi))
    f0 = clamped(f0)
    return put(lobes, at, GGX_DIELECTRIC, w, 1.0, alpha, eta, SCHLICK, f0, tint)


@kernel
def put_glass(
    lobes: Table,
    at: int,
    tables: Row,
    weight: Vector,
    color: Vector,
    alpha: float,
    eta: float,
    cosine: float,
    multi: bool,
) -> int:
    """Rough glass with Fresnel's reflectance; ``color`` tints all of it."""
    w = times(
        times(weight, color),
        _compensated_glass(tables, alpha, eta, cosine, clamped(color), multi),
    )
    return put(lobes, at, GGX_DIELECTRIC, w, 1.0, alpha, eta, TRUE_FRESNEL, _BLACK, _WHITE)


@kernel
def put_sheen(
    lobes: Table, at: int, tables: Row, weight: Vector, roughness: float, cosine: float
) -> tuple[int, float]:
    """A layer of fibres: (next row, its albedo over ``weight``)."""
    albedo, scale, shear = sheen_at(tables, max(1e-3, roughness), cosine)
    w = (weight[0] * albedo, weight[1] * albedo, weight[2] * albedo)
    shape = (scale, shear, 0.0)
    at = put(lobes, at, SHEEN, w, 1.0, roughness, 1.0, NO_FRESNEL, shape, _WHITE)
    return at, albedo


@kernel
def coat_transmission(tint: float, coat: float, ior: float, cosine: float) -> float:
    """What a coat's colour leaves of the light below it, along the refracted way."""
    sin2 = (1.0 - cosine * cosine) / (ior * ior)
    way = 1.0 / math.sqrt(max(1e-4, 1.0 - sin2))
    return 1.0 - coat + coat * math.pow(max(0.0, tint), way)
