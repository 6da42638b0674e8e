"""Directional albedos of GGX: what single scattering keeps, worked out by quadrature.

Cosines c stand at (i / (n - 1))^2, widths at alpha = (i / (n - 1))^2 as Blender's roughness
does, relative indices by z = sqrt(|eta - 1| / (eta + 1)). The integral over the visible
normals runs over the two numbers of their sampling: midpoints over half a turn, because
both halves are alike, and over the height v = 1 - (1 - x)^3, closer together towards the
long tail of GGX, which holds what narrow lobes lose.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.vector import dot
from ..jit import Row, Table, kernel
from .fresnel import fresnel_dielectric, fresnel_rise, reflect, refract
from .microfacet import sample_visible_normal, shadowing_given_masking
from .sheen_table import sheen_table

_FINE = 32
_COARSE = 16
_TURNS = 16
_HEIGHTS = 32
#: Index step that stands for the last entry of z, which is infinite there.
_MOST_Z = 0.99
_LEAST_COS = 1e-4
_LEAST_ALPHA = 1e-4


class AlbedoTables(NamedTuple):
    """Albedos by width, cosine and index; ``rise`` and ``glass`` for eta above 1 and below.

    ``ggx`` (alpha, c): reflectance 1. ``ggx_mean`` (alpha,): its cosine-weighted mean.
    ``rise`` (2, z, alpha, c): mean of ``fresnel_rise`` over the visible facets, those that
    reflect downwards counted as 0 (as Cycles weighs them).
    ``glass`` (2, z, alpha, c): what rough glass reflects and transmits together, and
    ``glass_mean`` (2, z, alpha) its cosine-weighted mean.
    """

    ggx: NDArray[np.float64]
    ggx_mean: NDArray[np.float64]
    rise: NDArray[np.float64]
    glass: NDArray[np.float64]
    glass_mean: NDArray[np.float64]
    sheen: NDArray[np.float64]


def no_albedo_tables() -> AlbedoTables:
    """Tables for scenes that look nothing up."""
    ones = np.ones((2, 2, 2, 2))
    return AlbedoTables(ones[0, 0], ones[0, 0, 0], 0.0 * ones, ones, ones[0], ones[0])


@cache
def albedo_tables() -> AlbedoTables:
    """All tables, the same for every scene; about 0.2 s of work at the first call."""
    ggx = np.zeros((_FINE, _FINE))
    rise = np.zeros((2, _COARSE, _COARSE, _COARSE))
    glass = np.zeros((2, _COARSE, _COARSE, _COARSE))
    _fill_ggx(ggx)
    _fill_fresnel(rise, glass)
    return AlbedoTables(ggx, _mean(ggx), rise, glass, _mean(glass), sheen_table())


def _mean(table: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cosine-weighted mean over the last axis: with c = x^2 its 2 c dc is 4 x^3 dx."""
    x = (np.arange(1024) + 0.5) / 1024
    nodes = np.linspace(0.0, 1.0, table.shape[-1])
    rows = table.reshape(-1, table.shape[-1])
    mean = [float((np.interp(x, nodes, row) * 4.0 * x**3).mean()) for row in rows]
    return np.reshape(mean, table.shape[:-1])


@kernel
def _grid(i: int, count: int, least: float) -> float:
    x = i / (count - 1.0)
    return max(least, x * x)


@kernel
def _eta_at(i: int, count: int, inverse: bool) -> float:
    z = min(_MOST_Z, i / (count - 1.0))
    eta = (1.0 + z * z) / (1.0 - z * z)
    return 1.0 / eta if inverse else eta


@kernel
def _height(b: int) -> tuple[float, float]:
    """Place ``b`` of the heights, and its weight among all points."""
    x = 1.0 - (b + 0.5) / _HEIGHTS
    far = 1.0 - b / _HEIGHTS
    near = 1.0 - (b + 1.0) / _HEIGHTS
    return 1.0 - x * x * x, (far * far * far - near * near * near) / _TURNS


@kernel
def _fill_ggx(table: Table) -> None:
    n = (0.0, 0.0, 1.0)
    count = table.shape[0]
    for i in range(count):
        alpha = _grid(i, count, _LEAST_ALPHA)
        for j in range(count):
            c = _grid(j, count, _LEAST_COS)
            wo = (math.sqrt(max(0.0, 1.0 - c * c)), 0.0, c)
            total = 0.0
            for a in range(_TURNS):
                for b in range(_HEIGHTS):
                    v, part = _height(b)
                    h = sample_visible_normal(n, wo, alpha, 0.5 * (a + 0.5) / _TURNS, v)
                    wi = reflect(wo, h)
                    if wi[2] > 0.0:
                        total += part * shadowing_given_masking(c, wi[2], alpha)
            table[i, j] = total


@kernel
def _fill_fresnel(rise: Table, glass: Table) -> None:
    n = (0.0, 0.0, 1.0)
    count = rise.shape[1]
    for i in range(count):
        alpha = _grid(i, count, _LEAST_ALPHA)
        for j in range(count):
            c = _grid(j, count, _LEAST_COS)
            wo = (math.sqrt(max(0.0, 1.0 - c * c)), 0.0, c)
            for a in range(_TURNS):
                for b in range(_HEIGHTS):
                    v, part = _height(b)
                    h = sample_visible_normal(n, wo, alpha, 0.5 * (a + 0.5) / _TURNS, v)
                    cos_h = dot(wo, h)
                    wi = reflect(wo, h)
                    kept = 0.0
                    if wi[2] > 0.0:
                        kept = shadowing_given_masking(c, wi[2], alpha)
                    for k in range(2 * count):
                        eta = _eta_at(k % count, count, k >= count)
                        f, cos_t = fresnel_dielectric(cos_h, eta)
                        side = k // count
                        if wi[2] > 0.0:
                            rise[side, k % count, i, j] += part * fresnel_rise(cos_h, eta)
                        energy = f * kept
                        below = -refract(wo, h, eta, cos_t)[2]
                        if f < 1.0 and below > 0.0:
                            energy += (1.0 - f) * shadowing_given_masking(c, below, alpha)
                        glass[side, k % count, i, j] += part * energy


@kernel
def _place(x: float, count: int) -> tuple[int, float]:
    """Entry below a coordinate of 0..1 and the way from it to the next."""
    x = min(1.0, max(0.0, x)) * (count - 1)
    i = min(int(x), count - 2)
    return i, x - i


@kernel
def _read_2d(table: Table, alpha: float, cosine: float) -> float:
    i, s = _place(math.sqrt(alpha), table.shape[0])
    j, t = _place(math.sqrt(max(0.0, cosine)), table.shape[1])
    low = table[i, j] + t * (table[i, j + 1] - table[i, j])
    high = table[i + 1, j] + t * (table[i + 1, j + 1] - table[i + 1, j])
    return float(low + s * (high - low))


@kernel
def _read_3d(table: Table, alpha: float, cosine: float, eta: float) -> float:
    sheet = table[0] if eta >= 1.0 else table[1]
    k, r = _place(math.sqrt(abs(eta - 1.0) / (eta + 1.0)), sheet.shape[0])
    low = _read_2d(sheet[k], alpha, cosine)
    return float(low + r * (_read_2d(sheet[k + 1], alpha, cosine) - low))


@kernel
def albedo_ggx(tables: Row, alpha: float, cosine: float) -> float:
    """Albedo of the GGX lobe of reflectance 1."""
    return _read_2d(tables.ggx, alpha, cosine)


@kernel
def mean_rise(tables: Row, alpha: float, cosine: float, eta: float) -> float:
    """Mean of ``fresnel_rise`` over the visible facets of a GGX surface."""
    return _read_3d(tables.rise, alpha, cosine, eta)


@kernel
def _albedo_glass(tables: Row, alpha: float, cosine: float, eta: float) -> float:
    """Albedo of colourless rough glass, reflection and transmission together."""
    return _read_3d(tables.glass, alpha, cosine, eta)


@kernel
def _mean_glass(tables: Row, alpha: float, eta: float) -> float:
    """Cosine-weighted mean of ``_albedo_glass``."""
    sheet = tables.glass_mean[0] if eta >= 1.0 else tables.glass_mean[1]
    k, r = _place(math.sqrt(abs(eta - 1.0) / (eta + 1.0)), sheet.shape[0])
    i, s = _place(math.sqrt(alpha), sheet.shape[1])
    low = sheet[k, i] + s * (sheet[k, i + 1] - sheet[k, i])
    high = sheet[k + 1, i] + s * (sheet[k + 1, i + 1] - sheet[k + 1, i])
    return float(low + r * (high - low))


@kernel
def _many_bounces(albedo: float, mean: float, kept: float) -> float:
    """Factor 1 + F (1 - E) / E on a lobe of albedo E, whose facets keep ``kept``."""
    many = kept * mean / (1.0 - kept * (1.0 - mean))
    return 1.0 + many * max(0.0, 1.0 - albedo) / max(0.01, albedo)


@kernel
def multiscatter(tables: Row, alpha: float, cosine: float, mean_fresnel: float) -> float:
    """Factor on a GGX lobe that stands for the bounces between its facets.

    1 + F (1 - E) / E with F the share that leaves after more than one bounce (Turquin
    2019, "Practical Multiple Scattering Compensation for Microfacet Models"; F from Kulla
    and Conty 2017, "Revisiting Physically Based Shading at Imageworks", appendix).
    """
    i, s = _place(math.sqrt(alpha), len(tables.ggx_mean))
    mean = tables.ggx_mean[i] + s * (tables.ggx_mean[i + 1] - tables.ggx_mean[i])
    return _many_bounces(albedo_ggx(tables, alpha, cosine), mean, mean_fresnel)


@kernel
def multiscatter_glass(
    tables: Row, alpha: float, cosine: float, eta: float, mean_kept: float
) -> float:
    """The same factor on rough glass whose facets keep ``mean_kept`` of the light."""
    e = _albedo_glass(tables, alpha, cosine, eta)
    return _many_bounces(e, _mean_glass(tables, alpha, eta), mean_kept)


@kernel
def mean_fresnel_dielectric(eta: float) -> float:
    """Cosine-weighted mean of Fresnel's reflectance (fits by Kulla and Conty 2017)."""
    if eta < 1.0:
        return 0.997118 + eta * (0.1014 - eta * (0.965241 + eta * 0.130607))
    return (eta - 1.0) / (4.08567 + 1.00071 * eta)


def shading_albedo(needed: Any) -> AlbedoTables:
    """The tables when something needs them."""
    return albedo_tables() if needed else no_albedo_tables()
