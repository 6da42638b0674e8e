"""What single shader nodes become; ``folding.py`` puts their tree together.

| node | becomes |
|---|---|
| Diffuse BSDF | diffuse, Oren-Nayar with roughness |
| Glossy BSDF | mirror without roughness, else GGX; without Fresnel, as in Cycles |
| Metallic BSDF | GGX with the F82 curve, fitted where index and extinction are given |
| Glass BSDF | dielectric, tinted by the colour at every reflection and refraction |
| Refraction BSDF | refraction without Fresnel |
| Transparent, Translucent, Sheen BSDF | the same |
| Subsurface Scattering | diffuse, with one warning |
| Emission, Background | emission of colour x strength |
| Principled BSDF | itself; the inputs of ``IGNORED_INPUTS`` are not rendered |
| Holdout | black; a hole in the picture where the surface is nothing else |
| nothing linked | black |
| any other shader | ``FALLBACK``, a grey diffuse lobe, with one warning |

Textures drive base colour, roughness, metallic, transmission, alpha and emission; at other
inputs the input's own value counts, with one warning. Rough nodes are GGX whatever
distribution they name; anisotropy and thin films are ignored with a warning.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...core.scene.builder import (
    Lobe,
    dielectric,
    diffuse,
    mirror,
    refraction,
    translucent,
    transparent,
)
from ...core.scene.closures import closure
from ...core.scene.tables import ClosureKind
from .nodes import Placed
from .values import Value, ValueReader

#: Below this roughness a surface is sharp: its lobe is narrower than 1e-4 rad.
SHARP_ROUGHNESS = 0.01

#: Albedo of a surface whose shader is not supported.
FALLBACK = 0.8

#: Principled inputs that are not rendered yet, and the value at which they do nothing.
IGNORED_INPUTS: dict[str, float] = {
    "Anisotropic": 0.0,
    "Thin Film Thickness": 0.0,
    "Thin Wall": 0.0,
}

_BLACK = Value(0.0)


@dataclass(frozen=True, eq=False)
class Shader:
    """One shader node: what may be textured in ``values``, the rest in ``others``.

    ``holds_out``: it is a hole in the picture, and black in mirrors.
    """

    kind: ClosureKind
    values: dict[str, Value] = field(default_factory=dict)
    others: dict[str, Any] = field(default_factory=dict)
    holds_out: bool = False

    def get(self, name: str) -> Value:
        """A value, 0 where the node has none of the name."""
        return self.values.get(name, _BLACK)

    @property
    def is_constant(self) -> bool:
        """Whether no texture is in it."""
        return all(value.is_constant for value in self.values.values())

    @property
    def is_sharp(self) -> bool:
        """Whether its roughness is as good as none."""
        roughness = self.get("roughness")
        return roughness.is_constant and roughness.number < SHARP_ROUGHNESS

    @property
    def ior(self) -> float:
        """Index of the medium behind the surface, 0 when light does not enter one."""
        kinds = (ClosureKind.GLASS, ClosureKind.REFRACTION)
        transmits = self.get("transmission")
        principled = self.kind == ClosureKind.PRINCIPLED and bool(transmits.color.any())
        return float(self.others["ior"]) if self.kind in kinds or principled else 0.0

    @property
    def passes(self) -> bool:
        """Whether some light goes straight through."""
        if self.kind == ClosureKind.PRINCIPLED:
            alpha = self.get("alpha")
            return not (alpha.is_constant and alpha.number >= 1.0)
        return self.kind == ClosureKind.TRANSPARENT

    def row(self, factors: list[Any]) -> Any:
        """A row of ``tables.CLOSURE``."""
        values = {name: value.row() for name, value in self.values.items()}
        return closure(self.kind, factors, **values, **self.others)

    def lobes(self) -> tuple[Lobe, ...] | None:
        """The node as constant lobes, None when it has to be worked out at each hit."""
        if not self.is_constant:
            return None
        color = self.get("color").color
        if self.kind == ClosureKind.EMISSION:
            return ()
        if self.kind == ClosureKind.TRANSPARENT:
            return (transparent(color),)
        if self.kind == ClosureKind.TRANSLUCENT:
            return (translucent(color),)
        if self.kind == ClosureKind.DIFFUSE and self.get("roughness").number <= 0.0:
            return (diffuse(color),)
        if not self.is_sharp:
            return None
        if self.kind == ClosureKind.GLOSSY:
            return (mirror(color),)
        if self.kind == ClosureKind.GLASS or self._is_clear_glass():
            return (dielectric(self.others["ior"], color),)
        if self.kind == ClosureKind.REFRACTION:
            return (refraction(self.others["ior"], color),)
        return None

    def _is_clear_glass(self) -> bool:
        """A Principled shader that is glass and nothing else."""
        if self.kind != ClosureKind.PRINCIPLED:
            return False
        white = np.ones(3)
        return (
            self.get("transmission").number >= 1.0
            and self.get("metallic").number <= 0.0
            and self.get("alpha").number >= 1.0
            and self.others["coat"] == self.others["sheen"] == 0.0
            and np.array_equal(self.get("color").color, white)
            and np.array_equal(self.others["specular_tint"], white)
        )


def reflectance(reader: ValueReader, node: Placed, name: str) -> Value:
    """The colour at ``name`` limited to 0..1: a surface gives back no more than it gets."""
    value = reader.color_value(node, name)
    if value.is_constant and ((value.color < 0).any() or (value.color > 1).any()):
        reader.log.warn(
            f"{reader.owner}: '{name}' of '{node.item.name}' is outside 0..1 and is limited "
            "to it"
        )
        return Value(np.clip(value.color, 0.0, 1.0))
    return value


def emitted(reader: ValueReader, node: Placed, color: str, strength: str) -> Value:
    """Emission of colour times strength; never negative, and one of them textured at most."""
    tint, power = reader.color_value(node, color), reader.number_value(node, strength)
    if not tint.is_constant and not power.is_constant:
        socket = node.input(strength)
        assert socket is not None
        power = Value(float(socket.item.default_value))
        reader.log.warn(
            f"{reader.owner}: both {color.lower()} and strength of '{node.item.name}' are "
            "textured, the input's own strength is used"
        )
    got = tint.times(power.number) if power.is_constant else power.times(tint.color)
    if (got.color < 0).any():
        reader.log.warn(f"{reader.owner}: negative emission is not possible, 0 is used")
        return Value(np.zeros(3))
    return got


def _index(reader: ValueReader, node: Placed) -> float:
    return max(1e-3, reader.number(node, "IOR", 1.5))


def _distribution(reader: ValueReader, node: Placed, roughness: Value) -> int:
    """1 when light bounces between the facets too; a warning for what is no GGX."""
    name = node.item.distribution
    rough = not roughness.is_constant or roughness.number >= SHARP_ROUGHNESS
    if rough and name not in ("GGX", "MULTI_GGX"):
        reader.log.warn_group(f"the distribution {name} is rendered as GGX in", reader.owner)
    return int(name == "MULTI_GGX")


def _warn_anisotropy(reader: ValueReader, node: Placed) -> None:
    if reader.number(node, "Anisotropy") != 0:
        reader.log.warn_group("anisotropy is ignored in", reader.owner)


def _warn_film(reader: ValueReader, node: Placed) -> None:
    if reader.number(node, "Thin Film Thickness") != 0:
        reader.log.warn_group("thin films are ignored in", reader.owner)


def _diffuse(reader: ValueReader, node: Placed) -> Shader:
    values = {
        "color": reflectance(reader, node, "Color"),
        "roughness": reader.number_value(node, "Roughness"),
    }
    return Shader(ClosureKind.DIFFUSE, values)


def _subsurface(reader: ValueReader, node: Placed) -> Shader:
    reader.log.warn_group("subsurface scattering is rendered diffuse in", reader.owner)
    return Shader(ClosureKind.DIFFUSE, {"color": reflectance(reader, node, "Color")})


def _plain(kind: ClosureKind) -> Callable[[ValueReader, Placed], Shader]:
    def make(reader: ValueReader, node: Placed) -> Shader:
        return Shader(kind, {"color": reflectance(reader, node, "Color")})

    return make


def _sheen(reader: ValueReader, node: Placed) -> Shader:
    if node.item.distribution != "MICROFIBER":
        reader.log.warn_group("velvet is rendered as microfibre sheen in", reader.owner)
    values = {
        "color": reflectance(reader, node, "Color"),
        "roughness": reader.number_value(node, "Roughness"),
    }
    return Shader(ClosureKind.SHEEN, values)


def _rough(kind: ClosureKind) -> Callable[[ValueReader, Placed], Shader]:
    """A node of colour, roughness and perhaps an index of refraction."""

    def make(reader: ValueReader, node: Placed) -> Shader:
        roughness = reader.number_value(node, "Roughness")
        values = {"color": reflectance(reader, node, "Color"), "roughness": roughness}
        others: dict[str, Any] = {"distribution": _distribution(reader, node, roughness)}
        if kind == ClosureKind.GLOSSY:
            _warn_anisotropy(reader, node)
        else:
            others["ior"] = _index(reader, node)
            _warn_film(reader, node)
        return Shader(kind, values, others)

    return make


def _metallic(reader: ValueReader, node: Placed) -> Shader:
    roughness = reader.number_value(node, "Roughness")
    _warn_anisotropy(reader, node)
    _warn_film(reader, node)
    others: dict[str, Any] = {"distribution": _distribution(reader, node, roughness)}
    if node.item.fresnel_type == "F82":
        base = reflectance(reader, node, "Base Color")
        others["specular_tint"] = reader.color(node, "Edge Tint")
    else:
        n, k = reader.color(node, "IOR"), reader.color(node, "Extinction")
        f0 = conductor_reflectance(1.0, n, k)
        base = Value(f0)
        cosine = 1.0 / 7.0  # of about 82 degrees
        curve = f0 + (1.0 - f0) * (1.0 - cosine) ** 5
        others["specular_tint"] = conductor_reflectance(cosine, n, k) / curve
    return Shader(ClosureKind.METALLIC, {"color": base, "roughness": roughness}, others)


def conductor_reflectance(cosine: float, n: Any, k: Any) -> Any:
    """Fresnel reflectance of a conductor for unpolarised light (Born and Wolf, 14.2).

    ``n``, ``k`` (3,): real and imaginary part of its index relative to the medium outside.
    """
    sin2 = 1.0 - cosine * cosine
    root = np.sqrt(np.asarray(n) ** 2 - np.asarray(k) ** 2 - sin2 + 2j * np.asarray(n * k))
    across = (cosine - root) / (cosine + root)
    eta2 = (np.asarray(n) + 1j * np.asarray(k)) ** 2
    along = (eta2 * cosine - root) / (eta2 * cosine + root)
    return (np.abs(across) ** 2 + np.abs(along) ** 2) / 2.0


def _holdout(reader: ValueReader, node: Placed) -> Shader:
    return Shader(ClosureKind.DIFFUSE, {"color": _BLACK}, holds_out=True)


def _emission(reader: ValueReader, node: Placed) -> Shader:
    return Shader(
        ClosureKind.EMISSION, {"emission": emitted(reader, node, "Color", "Strength")}
    )


def principled(reader: ValueReader, node: Placed) -> Shader:
    """The Principled BSDF; inputs that only other renderers honour are named once."""
    roughness = reader.number_value(node, "Roughness")
    values = {
        "color": reflectance(reader, node, "Base Color"),
        "roughness": roughness,
        "metallic": reader.number_value(node, "Metallic"),
        "transmission": reader.number_value(node, "Transmission Weight"),
        "alpha": reader.number_value(node, "Alpha", 1.0),
        "emission": emitted(reader, node, "Emission Color", "Emission Strength"),
    }
    number = {
        "ior": ("IOR", 1.5),
        "specular_level": ("Specular IOR Level", 0.5),
        "coat": ("Coat Weight", 0.0),
        "coat_roughness": ("Coat Roughness", 0.03),
        "coat_ior": ("Coat IOR", 1.5),
        "sheen": ("Sheen Weight", 0.0),
        "sheen_roughness": ("Sheen Roughness", 0.5),
        "diffuse_roughness": ("Diffuse Roughness", 0.0),
    }
    others: dict[str, Any] = {
        name: max(0.0, reader.number(node, *socket)) for name, socket in number.items()
    }
    others["ior"] = max(1e-3, others["ior"])
    for name, socket_name in (
        ("specular_tint", "Specular Tint"),
        ("coat_tint", "Coat Tint"),
        ("sheen_tint", "Sheen Tint"),
    ):
        others[name] = np.clip(reader.color(node, socket_name), 0.0, None)
    others["distribution"] = _distribution(reader, node, roughness)
    ignored = [
        name
        for name, neutral in IGNORED_INPUTS.items()
        if reader.number(node, name, neutral) != neutral
    ]
    if ignored:
        names = ", ".join(ignored)
        reader.log.warn(f"{reader.owner}: {names} of '{node.item.name}' ignored")
    if reader.number(node, "Subsurface Weight") != 0:
        reader.log.warn_group("subsurface scattering is rendered diffuse in", reader.owner)
    return Shader(ClosureKind.PRINCIPLED, values, others)


SHADERS: dict[str, Callable[[ValueReader, Placed], Shader]] = {
    "BSDF_DIFFUSE": _diffuse,
    "BSDF_GLOSSY": _rough(ClosureKind.GLOSSY),
    "BSDF_GLASS": _rough(ClosureKind.GLASS),
    "BSDF_REFRACTION": _rough(ClosureKind.REFRACTION),
    "BSDF_METALLIC": _metallic,
    "BSDF_TRANSPARENT": _plain(ClosureKind.TRANSPARENT),
    "BSDF_TRANSLUCENT": _plain(ClosureKind.TRANSLUCENT),
    "BSDF_SHEEN": _sheen,
    "SUBSURFACE_SCATTERING": _subsurface,
    "BSDF_PRINCIPLED": principled,
    "EMISSION": _emission,
    "BACKGROUND": _emission,
    "HOLDOUT": _holdout,
}
