"""The Principled BSDF: layers from the outside in, each taking from those below it.

The order and the parameters are those of Blender's node since 4.0; a layer dims what lies
below by its albedo towards the viewer, the largest of its channels (albedo scaling).
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector, scale, times
from ..jit import Row, Table, kernel
from .closure import (
    clamped,
    coat_transmission,
    put_diffuse,
    put_metal,
    put_plain,
    put_reflection,
    put_sheen,
    put_tinted_glass,
)
from .fresnel import normal_reflectance
from .lobe import TRANSPARENT

_LEAST = 1e-5


@kernel
def below_layer(weight: Vector, albedo: float) -> Vector:
    """What a layer of this albedo lets through to the next."""
    return scale(weight, min(1.0, max(0.0, 1.0 - albedo)))


@kernel
def _coat(
    closure: Row, lobes: Table, at: int, tables: Row, weight: Vector, cosine: float
) -> tuple[int, Vector]:
    """The clear coat: (next row, weight below it)."""
    coat = closure.coat
    ior = max(1.0, closure.coat_ior)
    rough = min(1.0, max(0.0, closure.coat_roughness))
    f = normal_reflectance(ior)
    at, albedo = put_reflection(
        lobes, at, tables, scale(weight, coat), (f, f, f), rough * rough, ior, cosine, True
    )
    weight = below_layer(weight, coat * albedo)
    t = closure.coat_tint
    mix = min(1.0, coat)
    return at, times(
        weight,
        (
            coat_transmission(t[0], mix, ior, cosine),
            coat_transmission(t[1], mix, ior, cosine),
            coat_transmission(t[2], mix, ior, cosine),
        ),
    )


@kernel
def specular_eta(ior: float, level: float) -> float:
    """Index whose reflectance at normal incidence is that of ``ior`` times 2 ``level``."""
    if level == 0.5:
        return ior
    root = math.sqrt(min(0.99, max(0.0, 2.0 * level * normal_reflectance(ior))))
    eta = (1.0 + root) / (1.0 - root)
    return 1.0 / eta if ior < 1.0 else eta


@kernel
def put_principled(
    closure: Row,
    lobes: Table,
    at: int,
    tables: Row,
    weight: Vector,
    color: Vector,
    roughness: float,
    metallic: float,
    transmission: float,
    alpha: float,
    eta: float,
    cosine: float,
) -> int:
    """All lobes of a Principled closure; ``eta`` is the relative index of the hit."""
    multi = closure.distribution == 1
    at = put_plain(lobes, at, TRANSPARENT, scale(weight, 1.0 - alpha))
    weight = scale(weight, alpha)
    if closure.sheen > _LEAST:
        tint = scale((closure.sheen_tint[0], closure.sheen_tint[1], closure.sheen_tint[2]),
                     closure.sheen)  # fmt: skip
        at, albedo = put_sheen(
            lobes, at, tables, times(weight, tint), closure.sheen_roughness, cosine
        )
        weight = below_layer(weight, albedo * max(tint[0], max(tint[1], tint[2])))
    if closure.coat > _LEAST:
        at, weight = _coat(closure, lobes, at, tables, weight, cosine)
    width = roughness * roughness
    t = closure.specular_tint
    tint = (t[0], t[1], t[2])
    base = clamped(color)
    if metallic > _LEAST:
        at = put_metal(
            lobes, at, tables, scale(weight, metallic), base, tint, width, cosine, multi
        )
        weight = scale(weight, 1.0 - metallic)
    if transmission > _LEAST:
        f = normal_reflectance(eta)
        passed = (math.sqrt(base[0]), math.sqrt(base[1]), math.sqrt(base[2]))
        at = put_tinted_glass(
            lobes, at, tables, scale(weight, transmission), scale(tint, f), passed, width,
            eta, cosine, multi,
        )  # fmt: skip
        weight = scale(weight, 1.0 - transmission)
    outer = specular_eta(max(1e-5, closure.ior), max(0.0, closure.specular_level))
    if outer != 1.0:
        at, albedo = put_reflection(
            lobes, at, tables, weight, scale(tint, normal_reflectance(outer)), width, outer,
            cosine, multi,
        )  # fmt: skip
        weight = below_layer(weight, albedo)
    return put_diffuse(lobes, at, weight, color, closure.diffuse_roughness)
