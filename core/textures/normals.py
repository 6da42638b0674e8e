"""Shading normals bent by pictures: tangent-space normal maps and bump from heights."""

from __future__ import annotations

import math

from ..geometry.vector import (
    Vector,
    add,
    along,
    cross,
    dot,
    normalize,
    read,
    scale,
    subtract,
)
from ..jit import Row, Table, kernel
from ..scene.tables import ClosureKind
from .sampling import luminance, sample_uv, uv_at

#: A mirror ray about the normal leaves at least at this sine above the surface, or at 0.9
#: of the viewer's where that is lower still.
_LEAST_SINE = 0.01
#: Step of the height's slope in texels: as good as its derivative within a texel.
_STEP = 0.01

_DIFFUSE = int(ClosureKind.DIFFUSE)
_TRANSLUCENT = int(ClosureKind.TRANSLUCENT)
_EMISSION = int(ClosureKind.EMISSION)


@kernel
def _uv_edges(uvs: Table, layer: int, face: int) -> tuple[float, float, float, float]:
    """How coordinates change along a face's edges 0-1 and 0-2: (ds1, dt1, ds2, dt2)."""
    if layer < 0 or layer >= uvs.shape[0]:
        return 0.0, 0.0, 0.0, 0.0
    c = uvs[layer, face]
    s, t = float(c[0, 0]), float(c[0, 1])
    return c[1, 0] - s, c[1, 1] - t, c[2, 0] - s, c[2, 1] - t


@kernel
def mapped_normal(
    n: Vector, e1: Vector, e2: Vector, uv: tuple[float, float, float, float], local: Vector
) -> Vector:
    """``local`` of a normal map in the frame of ``n`` and the directions of the coordinates.

    ``e1``, ``e2``: edges of the face; ``uv``: its coordinates' changes along them. The
    first axis goes with growing u at right angles to ``n``, the second to the side where v
    grows (Mikkelsen 2008, "Simulation of wrinkled surfaces revisited", with the tangent of
    the face instead of that smoothed over its corners). ``n`` itself where the coordinates
    do not span the face.
    """
    det = uv[0] * uv[3] - uv[2] * uv[1]
    if det == 0.0:
        return n
    grows_u = scale(subtract(scale(e1, uv[3]), scale(e2, uv[1])), math.copysign(1.0, det))
    t = normalize(along(grows_u, n, -dot(grows_u, n)))
    b = scale(cross(n, t), math.copysign(1.0, det))
    bent = normalize(add(add(scale(t, local[0]), scale(b, local[1])), scale(n, local[2])))
    # Not a number (broken coordinates) fails every comparison.
    if dot(t, t) > 0.5 and dot(bent, bent) > 0.5:
        return bent
    return n


@kernel
def bumped_normal(
    n: Vector, e1: Vector, e2: Vector, h1: float, h2: float, distance: float, strength: float
) -> Vector:
    """Normal of a surface lifted along ``n`` by ``distance`` times a height.

    ``h1``, ``h2``: how the height changes along the edges ``e1``, ``e2`` (Blinn 1978,
    "Simulation of wrinkled surfaces", with the surface gradient of Mikkelsen 2010). Mixed
    with ``n`` by ``strength``.
    """
    r1, r2 = cross(e2, n), cross(n, e1)
    det = dot(e1, r1)
    slope = add(scale(r1, h1), scale(r2, h2))
    lifted = normalize(along(scale(n, abs(det)), slope, -distance * math.copysign(1.0, det)))
    bent = normalize(add(scale(lifted, strength), scale(n, 1.0 - strength)))
    return bent if dot(bent, bent) > 0.5 else n


@kernel
def within_hemisphere(ng: Vector, n: Vector, wo: Vector) -> Vector:
    """``n``, turned towards ``ng`` until a mirror would send ``wo`` above the surface.

    In the plane of ``ng`` and ``n``, with ``a`` the angle between them, the mirror ray has
    the height x sin 2a + z cos 2a over the surface, where (x, z) is ``wo``.
    """
    z = dot(ng, wo)
    if not z > 0.0:
        return ng
    least = min(0.9 * z, _LEAST_SINE)
    if 2.0 * dot(n, wo) * dot(n, ng) - z >= least and dot(n, ng) > 0.0 and dot(n, wo) > 0.0:
        return n
    side = normalize(along(n, ng, -dot(n, ng)))
    x = dot(side, wo)
    reach = math.sqrt(x * x + z * z)
    if not dot(side, side) > 0.5:
        return ng
    a = 0.5 * (math.atan2(x, z) + math.acos(min(1.0, least / reach)))
    return add(scale(side, math.sin(a)), scale(ng, math.cos(a)))


@kernel
def facing(n: Vector, wo: Vector) -> Vector:
    """``n``, turned towards ``wo`` until the viewer is not behind it."""
    below = _LEAST_SINE - dot(n, wo)
    return normalize(along(n, wo, below)) if below > 0.0 else n


@kernel
def _only_diffuse(shading: Row, material: Row) -> bool:
    """Whether no shader node of the material reflects like a mirror."""
    for k in range(material.closure_start, material.closure_start + material.closure_count):
        kind = shading.closures[k].kind
        if kind != _DIFFUSE and kind != _TRANSLUCENT and kind != _EMISSION:
            return False
    return bool(material.closure_count > 0)


@kernel
def _height(shading: Row, texture_id: int, s: float, t: float) -> float:
    r, g, b, _ = sample_uv(shading, texture_id, s, t)
    return luminance(r, g, b)


@kernel
def _height_slope(
    shading: Row,
    texture_id: int,
    at: tuple[float, float],
    uv: tuple[float, float, float, float],
) -> tuple[float, float]:
    """Change of a height image along the two edges whose coordinates change by ``uv``."""
    texture = shading.textures[texture_id]
    image = shading.images[texture.image]
    m = texture.to_image
    texels_s = math.hypot(m[0, 0] * image.width, m[1, 0] * image.height)
    texels_t = math.hypot(m[0, 1] * image.width, m[1, 1] * image.height)
    h = _height(shading, texture_id, at[0], at[1])
    by_s = by_t = 0.0
    if texels_s > 0.0:
        step = _STEP / texels_s
        by_s = (_height(shading, texture_id, at[0] + step, at[1]) - h) / step
    if texels_t > 0.0:
        step = _STEP / texels_t
        by_t = (_height(shading, texture_id, at[0], at[1] + step) - h) / step
    return by_s * uv[0] + by_t * uv[1], by_s * uv[2] + by_t * uv[3]


@kernel
def shading_normal(
    shading: Row,
    mesh: Row,
    material: Row,
    face: int,
    u: float,
    v: float,
    ng: Vector,
    ns: Vector,
    wo: Vector,
) -> Vector:
    """``ns`` bent by the material's normal map, then by its bump map; unit length.

    ``ng``, ``ns``: geometric and shading normal on the side of ``wo``, which the result
    keeps: a mirror about it sends ``wo`` to the outside of the surface, so that nothing
    goes black. Diffuse nodes alone take any normal that faces the viewer. Heights and
    distances count in world space [m].
    """
    a = read(mesh.vertices, mesh.faces[face, 0])
    e1 = subtract(read(mesh.vertices, mesh.faces[face, 1]), a)
    e2 = subtract(read(mesh.vertices, mesh.faces[face, 2]), a)
    # Maps belong to the side that the winding calls outside; the back is its reverse.
    side = 1.0 if dot(cross(e1, e2), ng) > 0.0 else -1.0
    n = scale(ns, side)
    if material.normal_texture >= 0:
        layer = shading.textures[material.normal_texture].uv
        s, t = uv_at(shading.uvs, layer, face, u, v)
        r, g, b, _ = sample_uv(shading, material.normal_texture, s, t)
        strength = material.normal_strength
        flat = 1.0 - min(1.0, max(0.0, strength))
        local = (
            (2.0 * r - 1.0) * strength,
            (2.0 * g - 1.0) * strength,
            flat + (1.0 - flat) * (2.0 * b - 1.0),
        )
        uv = _uv_edges(shading.uvs, layer, face)
        n = mapped_normal(n, e1, e2, uv, local)
    if material.bump_texture >= 0:
        layer = shading.textures[material.bump_texture].uv
        at = uv_at(shading.uvs, layer, face, u, v)
        uv = _uv_edges(shading.uvs, layer, face)
        h1, h2 = _height_slope(shading, material.bump_texture, at, uv)
        strength = max(0.0, material.bump_strength)
        n = bumped_normal(n, e1, e2, h1, h2, material.bump_distance, strength)
    n = scale(n, side)
    if _only_diffuse(shading, material) and dot(n, ng) > 0.0 and dot(ng, wo) > _LEAST_SINE:
        return facing(n, wo)
    return within_hemisphere(ng, n, wo)
