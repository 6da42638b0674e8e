"""Light that bounces between facets: what single scattering loses, given back by a factor.

Turquin 2019, "Practical Multiple Scattering Compensation for Microfacet Models", with the
share that gets out again after Kulla and Conty 2017. By quadrature for each lobe, in air.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..jit import allocating_kernel as kernel
from ..scene.tables import LOBE, Model
from .facets import visible_both_ways
from .optics import cos_transmitted, reflectance

#: Nodes over the root of the cosine, and the points of the integrals.
NODES = 48
_SLOPES, _TURNS = 192, 48
_LEAST = 1e-4

Table = NDArray[np.float64]


def no_bounces() -> Table:
    """The factors (2, NODES, 3) of a lobe that scatters once."""
    return np.ones((2, NODES, 3))


def bounces_of(lobe: np.void, kept: NDArray[np.floating]) -> Table:
    """Factors (2, NODES, 3): seen from outside and inside, by the root of the cosine.

    ``kept`` (3,): what facets leave of the light that they reflect or transmit.
    """
    out = no_bounces()
    row = np.array([lobe], LOBE)[0]
    alpha, glass = float(row["roughness"]), row["model"] == Model.GGX_DIELECTRIC
    if alpha < _LEAST or (glass and abs(row["eta"] - 1.0) < _LEAST):
        return out
    x = np.linspace(0.0, 1.0, NODES)
    fine = (np.arange(512) + 0.5) / 512
    for side in range(2):
        eta = 0.0 if not glass else float(row["eta"]) ** (1 - 2 * side)
        single = np.array([_albedo(max(c, _LEAST), alpha, eta) for c in x * x])
        mean = float((np.interp(fine, x, single) * 4.0 * fine**3).mean())
        keep = np.clip(kept, 0.0, 1.0).astype(np.float64)
        many = keep * mean / (1.0 - keep * (1.0 - mean))
        lost = np.maximum(0.0, 1.0 - single) / np.maximum(0.01, single)
        out[side] = 1.0 + many * lost[:, None]
    return out


@kernel
def _albedo(cos_o: float, alpha: float, eta: float) -> float:
    """Share that a surface of facets scatters once and out; ``eta`` 0: all is reflected.

    The integral of f cos over directions, by facet normals of density D cos.
    """
    sine = math.sqrt(max(0.0, 1.0 - cos_o * cos_o))
    total = 0.0
    for i in range(_SLOPES):
        y = (i + 0.5) / _SLOPES
        # With 1 - u = y^2 the points lie close where the slopes are steep.
        slope = alpha * math.sqrt(1.0 / (y * y) - 1.0)
        cos_h = 1.0 / math.sqrt(1.0 + slope * slope)
        sin_h = slope * cos_h
        for k in range(_TURNS):
            cos_d = sine * sin_h * math.cos(math.pi * (k + 0.5) / _TURNS) + cos_o * cos_h
            if cos_d <= 0.0:
                continue
            part = 2.0 * y * cos_d / (cos_o * cos_h)
            f = 1.0 if eta == 0.0 else reflectance(cos_d, 1.0, eta)
            above = 2.0 * cos_d * cos_h - cos_o
            if above > 0.0:
                total += part * f * visible_both_ways(cos_o, above, alpha)
            if f < 1.0:
                cos_t = cos_transmitted(cos_d, 1.0, eta)
                below = cos_o / eta - (cos_d / eta - cos_t) * cos_h
                if below > 0.0:
                    total += part * (1.0 - f) * visible_both_ways(cos_o, below, alpha)
    return total / (_SLOPES * _TURNS)


@kernel
def bounce_factor(table: Table, entering: bool, cosine: float) -> tuple[float, float, float]:
    """Factors at the viewer's cosine, per channel."""
    side = table[0] if entering else table[1]
    x = math.sqrt(min(1.0, max(0.0, cosine))) * (NODES - 1)
    i = min(int(x), NODES - 2)
    t = x - i
    return (
        side[i, 0] + t * (side[i + 1, 0] - side[i, 0]),
        side[i, 1] + t * (side[i + 1, 1] - side[i, 1]),
        side[i, 2] + t * (side[i + 1, 2] - side[i, 2]),
    )
