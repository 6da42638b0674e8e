"""Lobes for materials that are the same everywhere; scripts and tests make them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from .light_builder import rgb
from .tables import Fresnel, Model


@dataclass(frozen=True)
class Lobe:
    """One scattering lobe of a material; ``weight`` is its albedo per channel."""

    model: Model
    weight: tuple[float, float, float]
    ior: float = 0.0
    exponent: float = 0.0
    roughness: float = 0.0
    fresnel: Fresnel = Fresnel.NONE
    f0: tuple[float, float, float] = (0.0, 0.0, 0.0)
    f90: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def scaled(self, factor: float | Sequence[float]) -> Lobe:
        """The same lobe with its weight times ``factor`` (number or (3,))."""
        weight = np.asarray(self.weight) * np.asarray(factor)
        return replace(self, weight=(float(weight[0]), float(weight[1]), float(weight[2])))


def diffuse(color: ArrayLike) -> Lobe:
    """Lambertian reflection of albedo ``color`` (number or (3,))."""
    return Lobe(Model.DIFFUSE, rgb(color))


def phong(color: ArrayLike, exponent: float) -> Lobe:
    """Energy-normalised Phong lobe around the mirror direction."""
    return Lobe(Model.PHONG, rgb(color), exponent=float(exponent))


def mirror(color: ArrayLike = 1.0) -> Lobe:
    """Smooth conductor of constant reflectivity ``color``."""
    return Lobe(Model.CONDUCTOR, rgb(color))


def dielectric(ior: float, color: ArrayLike = 1.0) -> Lobe:
    """Smooth dielectric with Fresnel reflection and refraction, tinted by ``color``."""
    return Lobe(Model.DIELECTRIC, rgb(color), ior=float(ior))


def refraction(ior: float, color: ArrayLike = 1.0) -> Lobe:
    """Refraction alone: no Fresnel weight, black at total internal reflection."""
    return Lobe(Model.REFRACTION, rgb(color), ior=float(ior))


def oren_nayar(color: ArrayLike, roughness: float) -> Lobe:
    """Rough diffuse reflection; ``roughness`` 0..1, as in Blender's Diffuse node."""
    f0 = rgb(np.clip(color, 0.0, 1.0))
    return Lobe(Model.OREN_NAYAR, rgb(color), roughness=float(roughness), f0=f0)


def translucent(color: ArrayLike) -> Lobe:
    """Lambertian transmission."""
    return Lobe(Model.TRANSLUCENT, rgb(color))


def transparent(color: ArrayLike = 1.0) -> Lobe:
    """Lets rays go straight on."""
    return Lobe(Model.TRANSPARENT, rgb(color))


def ggx(
    color: ArrayLike,
    roughness: float,
    fresnel: Fresnel = Fresnel.NONE,
    ior: float = 1.5,
    f0: ArrayLike = 1.0,
    f90: ArrayLike = 1.0,
) -> Lobe:
    """Microfacet reflection, single scattering; ``roughness`` as Blender shows it.

    ``ior`` shapes DIELECTRIC and SCHLICK, ``f0`` and ``f90`` F82 and SCHLICK. Rough glass
    and what depends on the viewer by layers are made of closures.
    """
    return Lobe(
        Model.GGX, rgb(color), ior=float(ior), roughness=float(roughness) ** 2,
        fresnel=fresnel, f0=rgb(f0), f90=rgb(f90),
    )  # fmt: skip


def lobe_row(lobe: Lobe) -> tuple:
    """The fields of ``tables.LOBE`` in their order."""
    # Black to every eye, and denormal numbers would divide to NaN: 0 is what it means.
    weight = tuple(w if abs(w) >= 1e-30 else 0.0 for w in lobe.weight)
    return (
        int(lobe.model), int(lobe.fresnel), weight, _share(lobe), lobe.ior,
        lobe.exponent, lobe.roughness, lobe.ior, lobe.f0, lobe.f90,
    )  # fmt: skip


def _share(lobe: Lobe) -> float:
    """Estimate of what a lobe reflects: Fresnel at normal incidence, and some for grazing."""
    weight = np.asarray(lobe.weight)
    if lobe.model != Model.GGX or lobe.fresnel == Fresnel.NONE:
        return float(weight.mean())
    f0 = np.asarray(lobe.f0)
    if lobe.fresnel == Fresnel.DIELECTRIC:
        f0 = np.full(3, ((lobe.ior - 1) / (lobe.ior + 1)) ** 2)
    return float((weight * (f0 + (1 - f0) / 21)).mean())
