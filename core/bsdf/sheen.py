"""Sheen of fibres on a surface: a linearly transformed cosine (Zeltner et al. 2022).

The cosine lobe about the normal is scaled by 1 / ``scale`` across and sheared by ``shear``
in the plane of the viewer; it integrates to 1 over the hemisphere for any of them. Both
depend on the viewer, and the lobe is not reciprocal.
"""

from __future__ import annotations

import math

from ..geometry.vector import Vector, basis, cross, dot, normalize
from ..jit import Row, kernel
from ..sampling.warps import sample_disk


@kernel
def _frame(n: Vector, wo: Vector) -> tuple[Vector, Vector]:
    """Tangent towards ``wo`` and the one across."""
    c = dot(n, wo)
    t = (wo[0] - c * n[0], wo[1] - c * n[1], wo[2] - c * n[2])
    if dot(t, t) < 1e-20:
        return basis(n)
    t = normalize(t)
    return t, cross(n, t)


@kernel
def eval_sheen(n: Vector, wo: Vector, wi: Vector, scale: float, shear: float) -> float:
    """BSDF value for albedo 1 [1/sr], ``wi`` above ``n``."""
    t, s = _frame(n, wo)
    z = dot(n, wi)
    x = scale * dot(t, wi) + shear * z
    y = scale * dot(s, wi)
    square = x * x + y * y + z * z
    if square <= 0.0:
        return 0.0
    k = scale / square
    return k * k / math.pi


@kernel
def pdf_sheen(n: Vector, wo: Vector, wi: Vector, scale: float, shear: float) -> float:
    """Density of ``sample_sheen`` per solid angle."""
    return max(0.0, dot(n, wi)) * eval_sheen(n, wo, wi, scale, shear)


@kernel
def sample_sheen(
    n: Vector, wo: Vector, scale: float, shear: float, u: float, v: float
) -> Vector:
    """Direction with density value times cosine."""
    t, s = _frame(n, wo)
    x, y = sample_disk(u, v)
    z = math.sqrt(max(0.0, 1.0 - x * x - y * y))
    x = (x - z * shear) / scale
    y = y / scale
    return normalize((
        x * t[0] + y * s[0] + z * n[0],
        x * t[1] + y * s[1] + z * n[1],
        x * t[2] + y * s[2] + z * n[2],
    ))  # fmt: skip


@kernel
def sheen_at(tables: Row, roughness: float, cosine: float) -> tuple[float, float, float]:
    """Albedo, scale and shear seen at ``cosine``, from ``sheen_table``."""
    table = tables.sheen
    y = min(1.0, max(0.0, roughness)) * (table.shape[1] - 1)
    x = min(1.0, max(0.0, cosine)) * (table.shape[2] - 1)
    i = min(int(y), table.shape[1] - 2)
    j = min(int(x), table.shape[2] - 2)
    s = y - i
    t = x - j
    a = 0.0
    b = 0.0
    c = 0.0
    for k in range(2):
        for m in range(2):
            w = (s if k else 1.0 - s) * (t if m else 1.0 - t)
            a += w * table[0, i + k, j + m]
            b += w * table[1, i + k, j + m]
            c += w * table[2, i + k, j + m]
    return a, max(1e-4, b), c
