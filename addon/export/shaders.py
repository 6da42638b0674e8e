"""Folds a tree of shader nodes into lobes and emission.

What becomes what, with the values of unlinked inputs:

| node | becomes |
|---|---|
| Diffuse BSDF | diffuse lobe; its roughness is ignored |
| Glossy BSDF | roughness below 0.03: mirror, else Phong lobe; without Fresnel, as in Cycles |
| Glass BSDF | smooth dielectric, tinted by the colour at every reflection and refraction |
| Refraction BSDF | smooth refraction without Fresnel |
| Emission, Background | emission of colour x strength |
| Mix Shader | both inputs, weighted by 1 - factor and factor |
| Add Shader | the sum of both inputs |
| Principled BSDF | see ``principled`` |
| nothing linked | black |
| any other shader | ``FALLBACK``, a grey diffuse lobe, with one warning |

Roughness r has alpha = r^2 and becomes the Phong exponent 2 / alpha^2 - 2, which has the
same curvature at the peak as the Beckmann distribution (Walter et al. 2007, "Microfacet
models for refraction through rough surfaces", section 5.2). Rough glass is rendered smooth.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.builder import Lobe, dielectric, diffuse, mirror, phong, refraction
from .nodes import NodeReader, as_number, shader_of

#: Below this roughness a surface counts as smooth; caustic photons need smooth surfaces.
SMOOTH_ROUGHNESS = 0.03

#: Albedo of a surface whose shader is not supported.
FALLBACK = 0.8

#: Principled inputs that are not rendered yet, and the value at which they do nothing.
IGNORED_INPUTS: dict[str, float] = {
    "Alpha": 1.0,
    "Subsurface Weight": 0.0,
    "Coat Weight": 0.0,
    "Sheen Weight": 0.0,
    "Anisotropic": 0.0,
    "Diffuse Roughness": 0.0,
    "Thin Film Thickness": 0.0,
    "Thin Wall": 0.0,
}


@dataclass(frozen=True)
class Shading:
    """What a shader socket folds to: lobes with their weights, and emitted radiance (3,)."""

    lobes: tuple[Lobe, ...] = ()
    emission: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))

    def scaled(self, factor: float) -> Shading:
        """The same with every weight times ``factor``."""
        lobes = tuple(lobe.scaled(factor) for lobe in self.lobes)
        return Shading(lobes, self.emission * factor)

    def plus(self, other: Shading) -> Shading:
        """The sum; lobes that differ in weight only become one."""
        return Shading(merged((*self.lobes, *other.lobes)), self.emission + other.emission)


def merged(lobes: Iterable[Lobe]) -> tuple[Lobe, ...]:
    """``lobes`` with equal ones added up and black ones left out."""
    sums: dict[Lobe, NDArray[np.float64]] = {}
    for lobe in lobes:
        key = replace(lobe, weight=(0.0, 0.0, 0.0))
        sums[key] = sums.get(key, np.zeros(3)) + np.array(lobe.weight)
    return tuple(
        replace(key, weight=(float(weight[0]), float(weight[1]), float(weight[2])))
        for key, weight in sums.items()
        if weight.any()
    )


class ShaderFolder:
    """Folds the shader nodes of one material, world or light; each node once."""

    def __init__(self, reader: NodeReader, instead: str = "a grey diffuse surface") -> None:
        self.reader = reader
        self.instead = instead
        self._folded: dict[int, Shading] = {}

    def fold(self, socket: Any) -> Shading:
        """The shading that arrives at the input ``socket``."""
        node = shader_of(socket)
        if node is None:
            return Shading()
        key = node.as_pointer()
        if key not in self._folded:
            self._folded[key] = self._node(node)
        return self._folded[key]

    def _node(self, node: Any) -> Shading:
        if node.type == "MIX_SHADER":
            # By place: the first input is called "Fac" before 5.0, the others alike.
            factor = min(1.0, max(0.0, as_number(self.reader.value(node.inputs[0]))))
            first = self.fold(node.inputs[1]).scaled(1.0 - factor)
            return first.plus(self.fold(node.inputs[2]).scaled(factor))
        if node.type == "ADD_SHADER":
            return self.fold(node.inputs[0]).plus(self.fold(node.inputs[1]))
        make = SHADERS.get(node.type)
        if make is None:
            self.reader.log.warn(
                f"{self.reader.owner}: shader node '{node.label or node.name}' is not "
                f"supported yet; {self.instead} is rendered instead"
            )
            return Shading((diffuse(FALLBACK),))
        shading = make(self.reader, node)
        self.reader.finish(node)
        return replace(shading, lobes=merged(shading.lobes))


def reflectance(reader: NodeReader, node: Any, name: str) -> NDArray[np.float64]:
    """The colour at ``name`` limited to 0..1: a surface gives back no more than it gets."""
    color = reader.color(node, name)
    if (color < 0).any() or (color > 1).any():
        reader.log.warn(
            f"{reader.owner}: '{name}' of '{node.name}' is outside 0..1 and is limited to it"
        )
    return np.clip(color, 0.0, 1.0)


def emitted(reader: NodeReader, color: NDArray[np.float64], strength: float) -> Shading:
    """Emission of ``color`` times ``strength``; never negative."""
    radiance = color * strength
    if (radiance < 0).any():
        reader.log.warn(f"{reader.owner}: negative emission is not possible, 0 is used")
    return Shading((), np.maximum(radiance, 0.0))


def glossy_lobe(reader: NodeReader, color: Any, roughness: float) -> Lobe:
    """Mirror or Phong lobe of a roughness as Blender's nodes have it."""
    if roughness < SMOOTH_ROUGHNESS:
        return mirror(color)
    reader.log.warn_group(
        "microfacet reflection is approximated by a Phong lobe in", reader.owner
    )
    alpha = min(1.0, roughness * roughness)
    return phong(color, 2.0 / (alpha * alpha) - 2.0)


def smooth_glass(reader: NodeReader, node: Any) -> float:
    """The index of refraction of ``node``, with a warning when it is rough."""
    if reader.number(node, "Roughness") >= SMOOTH_ROUGHNESS:
        reader.log.warn_group("rough glass is rendered smooth in", reader.owner)
    return max(1e-3, reader.number(node, "IOR", 1.5))


def _diffuse(reader: NodeReader, node: Any) -> Shading:
    if reader.number(node, "Roughness") > 0:
        reader.log.warn_group("the roughness of Diffuse BSDF is ignored in", reader.owner)
    return Shading((diffuse(reflectance(reader, node, "Color")),))


def _glossy(reader: NodeReader, node: Any) -> Shading:
    if reader.number(node, "Anisotropy") != 0:
        reader.log.warn_group("anisotropy is ignored in", reader.owner)
    color = reflectance(reader, node, "Color")
    return Shading((glossy_lobe(reader, color, reader.number(node, "Roughness")),))


def _glass(reader: NodeReader, node: Any) -> Shading:
    color = reflectance(reader, node, "Color")
    return Shading((dielectric(smooth_glass(reader, node), color),))


def _refraction(reader: NodeReader, node: Any) -> Shading:
    color = reflectance(reader, node, "Color")
    return Shading((refraction(smooth_glass(reader, node), color),))


def _emission(reader: NodeReader, node: Any) -> Shading:
    return emitted(reader, reader.color(node, "Color"), reader.number(node, "Strength"))


def principled(reader: NodeReader, node: Any) -> Shading:
    """The Principled BSDF with base colour b, metallic m and transmission t.

    - m: mirror or Phong lobe of weight m b;
    - (1 - m) t: smooth dielectric, tinted sqrt(b) at each surface, so that light that goes
      in and out of a body is tinted b, as in Cycles;
    - (1 - m) (1 - t): a coat of constant weight F0 x specular tint (mirror or Phong) over a
      diffuse lobe of weight b (1 - F0), where F0 = ((ior - 1) / (ior + 1))^2 x 2 x specular
      level is the Fresnel reflectance at normal incidence;
    - emission colour x strength.

    The inputs of ``IGNORED_INPUTS`` are not rendered; one warning names those in use.
    """
    base = reflectance(reader, node, "Base Color")
    metallic = min(1.0, max(0.0, reader.number(node, "Metallic")))
    transmission = min(1.0, max(0.0, reader.number(node, "Transmission Weight")))
    roughness = reader.number(node, "Roughness")
    ior = max(1e-3, reader.number(node, "IOR", 1.5))
    level = max(0.0, reader.number(node, "Specular IOR Level", 0.5))
    tint = reflectance(reader, node, "Specular Tint")
    body = (1.0 - metallic) * (1.0 - transmission)
    glass = (1.0 - metallic) * transmission
    lobes: list[Lobe] = []
    if metallic > 0:
        lobes.append(glossy_lobe(reader, metallic * base, roughness))
    if glass > 0:
        lobes.append(dielectric(smooth_glass(reader, node), glass * np.sqrt(base)))
    if body > 0:
        f0 = min(1.0, ((ior - 1.0) / (ior + 1.0)) ** 2 * 2.0 * level)
        lobes.append(diffuse(body * (1.0 - f0) * base))
        if f0 > 0 and tint.any():
            lobes.append(glossy_lobe(reader, body * f0 * tint, roughness))
    ignored = [
        name
        for name, neutral in IGNORED_INPUTS.items()
        if reader.number(node, name, neutral) != neutral
    ]
    if ignored:
        reader.log.warn(f"{reader.owner}: {', '.join(ignored)} of '{node.name}' ignored")
    emission = emitted(
        reader,
        reader.color(node, "Emission Color"),
        reader.number(node, "Emission Strength", 0.0),
    )
    return Shading(tuple(lobes), emission.emission)


SHADERS: dict[str, Callable[[NodeReader, Any], Shading]] = {
    "BSDF_DIFFUSE": _diffuse,
    "BSDF_GLOSSY": _glossy,
    "BSDF_GLASS": _glass,
    "BSDF_REFRACTION": _refraction,
    "BSDF_PRINCIPLED": principled,
    "EMISSION": _emission,
    "BACKGROUND": _emission,
}
