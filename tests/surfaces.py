"""Surfaces for tests of scattering: lobes or closures on a plane, sampled and integrated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from photon_map.core.bsdf.dispatch import (
    NARROW,
    WIDE,
    eval_part,
    lobe_weights,
    pass_weight,
    pdf_part,
    sample_part,
)
from photon_map.core.bsdf.fresnel import fresnel_dielectric, reflect, refract
from photon_map.core.bsdf.resolve import MOST_LOBES, resolve
from photon_map.core.jit import allocating_kernel as kernel
from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.lobes import Lobe
from photon_map.core.scene.tables import LOBE
from photon_map.core.textures.shading import shading_tables

UP = (0.0, 0.0, 1.0)
SURFACE = np.dtype([("lobe_start", "i4"), ("lobe_count", "i4")])


@dataclass(frozen=True)
class Surface:
    """Lobes seen from ``wo`` (unit, above the plane z = 0); ``eta`` of what they refract."""

    row: Any
    lobes: NDArray[np.void]
    wo: tuple[float, float, float]
    eta: float = 1.0
    entering: bool = True


def direction(degrees: float, azimuth: float = 0.3) -> tuple[float, float, float]:
    """Unit direction at an angle from the normal."""
    t = math.radians(degrees)
    s = math.sin(t)
    return s * math.cos(azimuth), s * math.sin(azimuth), math.cos(t)


def of_lobes(lobes: list[Lobe], degrees: float) -> Surface:
    """The surface of constant lobes."""
    b = SceneBuilder("lobes")
    b.add_material("black", [])
    row = b.add_material("tested", lobes)
    scene = b.build()
    material = scene.materials[row]
    return Surface(_row(material["lobe_start"], len(lobes)), scene.lobes.copy(),
                   direction(degrees))  # fmt: skip


def _row(start: int, count: int) -> Any:
    row = np.zeros(1, SURFACE)
    row["lobe_start"], row["lobe_count"] = start, count
    return row[0]


class Resolver:
    """Closures of one material, resolved for any viewer."""

    def __init__(self, *closures: Any, **fields: Any) -> None:
        b = SceneBuilder("closures")
        row = b.add_material("tested", [], closures=closures, **fields)
        scene = b.build()
        self.material = scene.materials.copy()[row]
        self.shading = shading_tables(scene)
        self.ior = float(closures[0]["ior"]) if closures else 1.0

    def __call__(self, degrees: float, entering: bool = True, around: float = 1.0) -> Surface:
        wo = direction(degrees)
        lobes = np.zeros(MOST_LOBES, LOBE)
        count = resolve(
            self.material, self.shading, self.shading.uvs, 0, 0.3, 0.3, UP, wo, entering,
            around, lobes, 0,
        )  # fmt: skip
        eta = self.ior / around if entering else around / self.ior
        return Surface(_row(0, count), lobes, wo, eta, entering)


@kernel
def draw(row, lobes, wo, entering, part, u):
    """(N, 9): possible, wi, weight, pdf_w, transmitted."""
    out = np.zeros((len(u), 9))
    for k in range(len(u)):
        ok, wi, weight, pdf_w, transmitted, _ = sample_part(
            row, lobes, (0.0, 0.0, 1.0), wo, entering, 1.0, part, u[k, 0], u[k, 1], u[k, 2]
        )
        out[k, 0] = ok
        out[k, 1], out[k, 2], out[k, 3] = wi
        if ok:
            out[k, 4], out[k, 5], out[k, 6] = weight
        out[k, 7] = pdf_w
        out[k, 8] = transmitted
    return out


def samples(surface: Surface, part: int, count: int, rng: np.random.Generator) -> NDArray:
    """``draw`` with ``count`` random points."""
    return draw(
        surface.row, surface.lobes, surface.wo, surface.entering, part, rng.random((count, 3))
    )


@kernel
def _total(row, lobes, wo, entering, u, out):
    wide, narrow = lobe_weights(row, lobes)
    for k in range(len(u)):
        if wide + narrow <= 0.0:
            return
        part = 0 if u[k, 3] * (wide + narrow) < wide else 1
        prob = (wide if part == 0 else narrow) / (wide + narrow)
        ok, _, weight, _, _, _ = sample_part(
            row, lobes, (0.0, 0.0, 1.0), wo, entering, 1.0, part, u[k, 0], u[k, 1], u[k, 2]
        )
        if ok:
            for c in range(3):
                out[k, c] = weight[c] / prob


def albedo(
    surface: Surface, count: int, rng: np.random.Generator
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Share of flux that leaves, per channel, and the variance of that mean."""
    out = np.zeros((count, 3))
    _total(
        surface.row, surface.lobes, surface.wo, surface.entering, rng.random((count, 4)), out
    )
    through = np.array(pass_weight(surface.row, surface.lobes))
    return out.mean(axis=0) + through, out.var(axis=0) / count


def weights(surface: Surface) -> tuple[float, float]:
    """``lobe_weights`` of a surface."""
    return lobe_weights(surface.row, surface.lobes)


def main_part(surface: Surface) -> int:
    """The part of larger weight."""
    wide, narrow = weights(surface)
    return WIDE if wide >= narrow else NARROW


def value(surface: Surface, wi: tuple[float, float, float], part: int) -> NDArray[np.float64]:
    """``eval_part``."""
    return np.array(eval_part(surface.row, surface.lobes, UP, surface.wo, wi, part))


def _frame(axis):
    n = np.asarray(axis)
    helper = np.array((1.0, 0.0, 0.0)) if abs(n[0]) < 0.6 else np.array((0.0, 1.0, 0.0))
    t = np.cross(helper, n)
    t /= np.linalg.norm(t)
    return t, np.cross(n, t), n


#: Angles about the axis of a lobe: fine where narrow lobes are, coarse far away.
EDGES = np.concatenate(([0.0], np.geomspace(1e-3, math.pi, 14)))
COLUMNS = 8


@kernel
def _integrals(row, lobes, wo, part, t, s, n, up, edges, columns, fine):
    """Integral of ``pdf_part`` over each cell about ``n``, on one side of the plane."""
    out = np.zeros((len(edges) - 1, columns))
    for i in range(len(edges) - 1):
        for j in range(columns):
            total = 0.0
            low, high = edges[i], edges[i + 1]
            for a in range(fine):
                angle = low + (high - low) * (a + 0.5) / fine
                for b in range(fine):
                    phi = -math.pi + 2.0 * math.pi * (j + (b + 0.5) / fine) / columns
                    r = math.sin(angle)
                    x, y, z = r * math.cos(phi), r * math.sin(phi), math.cos(angle)
                    wi = (
                        x * t[0] + y * s[0] + z * n[0],
                        x * t[1] + y * s[1] + z * n[1],
                        x * t[2] + y * s[2] + z * n[2],
                    )
                    if (wi[2] > 0.0) == up:
                        pdf_w = pdf_part(row, lobes, (0.0, 0.0, 1.0), wo, wi, part)
                        total += pdf_w * r
            out[i, j] = total * (high - low) * 2.0 * math.pi / columns / (fine * fine)
    return out


def cells(
    surface: Surface, part: int, drawn: NDArray, fine: int = 32
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Counts of ``drawn`` and their expectation from ``pdf_part``: cells about the mirror

    direction above the plane, about the refracted one below, and one for what was lost.
    """
    counts, expected = [], []
    ok = drawn[:, 0] > 0
    _, cos_t = fresnel_dielectric(surface.wo[2], surface.eta)
    axes = (reflect(surface.wo, UP), refract(surface.wo, UP, surface.eta, cos_t))
    for up, axis in zip((True, False), axes, strict=True):
        unit = np.array(axis) / np.linalg.norm(axis)
        t, s, n = _frame(unit)
        here = ok & ((drawn[:, 3] > 0) == up)
        wi = drawn[here, 1:4]
        # The arc's chord tells small angles apart, the cosine does not.
        angle = 2 * np.arcsin(np.clip(np.linalg.norm(wi - n, axis=1) / 2, 0, 1))
        azimuth = np.arctan2(wi @ s, wi @ t)
        grid = (EDGES, np.linspace(-np.pi, np.pi, COLUMNS + 1))
        counts.append(np.histogram2d(angle, azimuth, bins=grid)[0].ravel())
        expected.append(
            len(drawn) * _integrals(
                surface.row, surface.lobes, surface.wo, part, tuple(t), tuple(s), tuple(n), up,
                EDGES, COLUMNS, fine,
            ).ravel()
        )  # fmt: skip
    observed, mean = np.concatenate(counts), np.concatenate(expected)
    lost = len(drawn) - mean.sum()
    return np.append(observed, (~ok).sum()), np.append(mean, lost)
