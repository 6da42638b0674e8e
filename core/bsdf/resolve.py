"""Works out, at a hit, the lobes of a material that is made of shader nodes."""

from __future__ import annotations

from ..geometry.vector import Vector, dot, scale, times, vector
from ..jit import Row, Table, kernel
from ..scene.tables import ClosureKind
from ..textures.sampling import param_color, param_number
from .closure import (
    put,
    put_diffuse,
    put_glass,
    put_glossy,
    put_metal,
    put_plain,
    put_sheen,
)
from .lobe import GGX_REFRACTION, NO_FRESNEL, TRANSLUCENT, TRANSPARENT
from .principled import put_principled

#: Rows a hit's lobes may take; nodes that would need more than are left scatter nothing.
MOST_LOBES = 16
#: Most lobes of one node: a Principled one of all layers.
_MOST_OF_ONE = 7

_DIFFUSE = int(ClosureKind.DIFFUSE)
_GLOSSY = int(ClosureKind.GLOSSY)
_GLASS = int(ClosureKind.GLASS)
_REFRACTION = int(ClosureKind.REFRACTION)
_TRANSPARENT = int(ClosureKind.TRANSPARENT)
_TRANSLUCENT = int(ClosureKind.TRANSLUCENT)
_EMISSION = int(ClosureKind.EMISSION)
_PRINCIPLED = int(ClosureKind.PRINCIPLED)
_SHEEN = int(ClosureKind.SHEEN)
_METALLIC = int(ClosureKind.METALLIC)
_BLACK = (0.0, 0.0, 0.0)
_WHITE = (1.0, 1.0, 1.0)


@kernel
def _unit_number(shading: Row, param: Row, face: int, u: float, v: float) -> float:
    """A parameter held within 0..1."""
    return min(1.0, max(0.0, param_number(shading, param, face, u, v)))


@kernel
def _color(shading: Row, param: Row, face: int, u: float, v: float) -> Vector:
    """A colour without negative channels."""
    c = param_color(shading, param, face, u, v)
    return max(0.0, c[0]), max(0.0, c[1]), max(0.0, c[2])


@kernel
def mix_factor(shading: Row, closure: Row, face: int, u: float, v: float) -> float:
    """Product of a closure's mix factors at a hit."""
    product = 1.0
    for k in range(closure.factor_count):
        factor = closure.factors[k]
        x = _unit_number(shading, factor.param, face, u, v)
        product *= 1.0 - x if factor.invert else x
    return product


@kernel
def _resolve_one(
    closure: Row,
    shading: Row,
    face: int,
    u: float,
    v: float,
    cosine: float,
    entering: bool,
    n_around: float,
    lobes: Table,
    at: int,
) -> int:
    """Lobes of one closure; the row behind the last."""
    kind = closure.kind
    factor = mix_factor(shading, closure, face, u, v)
    if not factor > 0.0 or kind == _EMISSION:
        return at
    tables = shading.albedo
    weight = (factor, factor, factor)
    color = _color(shading, closure.color, face, u, v)
    roughness = _unit_number(shading, closure.roughness, face, u, v)
    alpha = roughness * roughness
    multi = closure.distribution == 1
    ior = max(1e-5, closure.ior)
    eta = ior / n_around if entering else n_around / ior
    if kind == _PRINCIPLED:
        return put_principled(
            closure, lobes, at, tables, weight, color, roughness,
            _unit_number(shading, closure.metallic, face, u, v),
            _unit_number(shading, closure.transmission, face, u, v),
            _unit_number(shading, closure.alpha, face, u, v), eta, cosine,
        )  # fmt: skip
    if kind == _DIFFUSE:
        return put_diffuse(lobes, at, weight, color, roughness)
    if kind == _GLOSSY:
        return put_glossy(lobes, at, tables, weight, color, alpha, cosine, multi)
    if kind == _METALLIC:
        tint = vector(closure.specular_tint)
        return put_metal(lobes, at, tables, weight, color, tint, alpha, cosine, multi)
    tinted = times(weight, color)
    if kind == _GLASS:
        return put_glass(lobes, at, tables, weight, color, alpha, eta, cosine, multi)
    if kind == _REFRACTION:
        return put(
            lobes, at, GGX_REFRACTION, tinted, 1.0, alpha, eta, NO_FRESNEL, _BLACK, _WHITE
        )
    if kind == _TRANSPARENT:
        return put_plain(lobes, at, TRANSPARENT, tinted)
    if kind == _TRANSLUCENT:
        return put_plain(lobes, at, TRANSLUCENT, tinted)
    if kind == _SHEEN:
        at, _ = put_sheen(lobes, at, tables, tinted, roughness, cosine)
    return at


@kernel
def resolve(
    material: Row,
    shading: Row,
    mesh: Row,
    face: int,
    u: float,
    v: float,
    n: Vector,
    wo: Vector,
    entering: bool,
    n_around: float,
    lobes: Table,
    start: int,
) -> int:
    """Write the lobes of a hit to rows ``start``.. of ``lobes``; how many, <= MOST_LOBES.

    ``n``: shading normal on the side of ``wo``, the viewer's, whose angle decides how much
    each layer takes from those below. ``n_around``: index on the far side of the material's
    own medium.
    """
    cosine = min(1.0, max(0.0, dot(n, wo)))
    at = start
    for k in range(material.closure_start, material.closure_start + material.closure_count):
        if at - start > MOST_LOBES - _MOST_OF_ONE:
            break
        at = _resolve_one(
            shading.closures[k], shading, face, u, v, cosine, entering, n_around, lobes, at
        )
    return at - start


@kernel
def emitted_at(material: Row, shading: Row, face: int, u: float, v: float) -> Vector:
    """Radiance that a surface sends to both sides, the same in all directions.

    Sheen and coat above a glowing base are left out: their shade depends on the viewer.
    """
    if material.closure_count == 0:
        return vector(material.emission)
    r = g = b = 0.0
    for k in range(material.closure_start, material.closure_start + material.closure_count):
        closure = shading.closures[k]
        if closure.kind != _EMISSION and closure.kind != _PRINCIPLED:
            continue
        factor = mix_factor(shading, closure, face, u, v)
        if closure.kind == _PRINCIPLED:
            factor *= _unit_number(shading, closure.alpha, face, u, v)
        glow = scale(_color(shading, closure.emission, face, u, v), factor)
        r += glow[0]
        g += glow[1]
        b += glow[2]
    return r, g, b
