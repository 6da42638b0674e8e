"""The world: uniform radiance, or that of an Environment Texture all around.

| node | becomes |
|---|---|
| Background, Emission | colour x strength, uniform |
| with an Environment Texture at Color | its picture x strength |
| Mix Shader, Add Shader | the weighted sum, of at most one picture |
| Mapping of generated coordinates | a turn of the picture; anything else redraws it |

A turn is kept as a matrix. A mirror ball, a stretched or moved mapping is drawn anew as an
equirectangular picture.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from mathutils import Euler
from numpy.typing import NDArray

from ...core.scene.tables import Visibility
from ..report import ExportLog
from .environment import MAGENTA, Lookup, image_texels, redrawn
from .folding import ShaderFolder
from .nodes import NodeReader, as_number, shader_of, source_of
from .trees import tree_of

#: Ray visibility switches of Blender's worlds, and the core's bits.
_VISIBILITY = {
    "camera": Visibility.CAMERA,
    "diffuse": Visibility.DIFFUSE,
    "glossy": Visibility.GLOSSY,
    "transmission": Visibility.TRANSMISSION,
}


@dataclass(frozen=True)
class Surroundings:
    """Radiance: (3,) ``constant`` plus (3,) ``factor`` times ``texels`` (h, w, 3), if any.

    ``rotation`` (3, 3) takes a direction to that of the picture.
    """

    constant: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    factor: NDArray[np.float64] = field(default_factory=lambda: np.ones(3))
    texels: NDArray[np.float32] | None = None
    rotation: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))

    def scaled(self, share: float) -> Surroundings:
        """The same, dimmed to ``share``."""
        return Surroundings(
            self.constant * share, self.factor * share, self.texels, self.rotation
        )

    def builder_values(self) -> dict[str, Any]:
        """Arguments of ``SceneBuilder.set_world``."""
        if self.texels is None:
            return {"radiance": self.constant}
        radiance, texels = self.factor, self.texels
        if self.constant.any():
            texels = (texels * radiance + self.constant).astype(np.float32)
            radiance = np.ones(3)
        return {"radiance": radiance, "world_map": texels, "rotation": self.rotation}


def world_values(world: Any | None, log: ExportLog) -> dict[str, Any]:
    """What ``SceneBuilder.set_world`` wants to know of ``world``."""
    if world is None:
        return {"radiance": np.zeros(3)}
    tree = tree_of(world)
    if tree is None:
        color = np.maximum(np.array(world.color[:3], dtype=np.float64), 0.0)
        return {"radiance": color, "visibility": world_visibility(world)}
    output = tree.get_output_node("CYCLES")
    if output is None:
        return {"radiance": np.zeros(3)}
    owner = f"world '{world.name}'"
    if output.inputs["Volume"].is_linked:
        log.warn(f"{owner}: volume is not supported yet and ignored")
    found = _WorldFolder(owner, log).fold(output.inputs["Surface"])
    return {**found.builder_values(), "visibility": world_visibility(world)}


def world_visibility(world: Any) -> Visibility:
    """Which rays see ``world``; all of them when Cycles, which has the switches, is off."""
    switches = getattr(world, "cycles_visibility", None)
    seen = Visibility(0)
    for name, bit in _VISIBILITY.items():
        if getattr(switches, name, True):
            seen |= bit
    return seen


class _WorldFolder:
    """Folds the shader nodes of a world."""

    def __init__(self, owner: str, log: ExportLog) -> None:
        self.owner = owner
        self.log = log
        self.reader = NodeReader(owner, log)
        self.shaders = ShaderFolder(self.reader, "black")

    def fold(self, socket: Any) -> Surroundings:
        """The radiance that arrives at the input ``socket``."""
        node = shader_of(socket)
        if node is None:
            return Surroundings()
        if node.type == "MIX_SHADER":
            share = min(1.0, max(0.0, as_number(self.reader.value(node.inputs[0]))))
            first = self.fold(node.inputs[1]).scaled(1.0 - share)
            return self._sum(first, self.fold(node.inputs[2]).scaled(share))
        if node.type == "ADD_SHADER":
            return self._sum(self.fold(node.inputs[0]), self.fold(node.inputs[1]))
        if node.type in ("BACKGROUND", "EMISSION"):
            source = source_of(node.inputs["Color"])
            if source.is_output and source.node.type == "TEX_ENVIRONMENT":
                strength = max(0.0, self.reader.number(node, "Strength", 1.0))
                return self._picture(source.node, strength)
        return Surroundings(self.shaders.fold(socket).emission)

    def _sum(self, first: Surroundings, second: Surroundings) -> Surroundings:
        if first.texels is not None and second.texels is not None:
            self.log.warn(f"{self.owner}: of two environment textures the second is left out")
        one = first if first.texels is not None else second
        return Surroundings(
            first.constant + second.constant, one.factor, one.texels, one.rotation
        )

    def _picture(self, node: Any, strength: float) -> Surroundings:
        if strength == 0.0:
            return Surroundings()
        texels = image_texels(node.image)
        if texels is None:
            name = node.image.name if node.image else "no image"
            self.log.warn(f"{self.owner}: environment texture '{name}' is missing, magenta")
            return Surroundings(strength * np.array(MAGENTA))
        if node.interpolation == "Closest":
            self.log.warn(f"{self.owner}: interpolation 'Closest' of the sky is made linear")
        lookup = self._lookup(node.inputs["Vector"])
        factor = np.full(3, strength)
        turn = lookup.rotation()
        if node.projection == "EQUIRECTANGULAR" and turn is not None:
            return Surroundings(factor=factor, texels=texels, rotation=turn)
        ball = node.projection == "MIRROR_BALL"
        return Surroundings(factor=factor, texels=redrawn(texels, lookup, ball))

    def _lookup(self, socket: Any) -> Lookup:
        """Which vector the picture is looked up with, from the coordinates at ``socket``."""
        source = source_of(socket)
        if not source.is_output:
            return Lookup()
        node = source.node
        if node.type == "MAPPING":
            return self._mapping(node)
        if not (node.type == "TEX_COORD" and source.identifier == "Generated"):
            self.reader.warn_unread(node, socket)
        return Lookup()

    def _mapping(self, node: Any) -> Lookup:
        inner = self._lookup(node.inputs["Vector"])
        values = {
            name: np.array(self.reader.value(node.inputs[name]), dtype=np.float64)
            if node.inputs.get(name) is not None and node.inputs[name].enabled
            else np.full(3, default)
            for name, default in (("Location", 0.0), ("Rotation", 0.0), ("Scale", 1.0))
        }
        turn = np.array(Euler(values["Rotation"], "XYZ").to_matrix(), dtype=np.float64)
        size = np.where(values["Scale"] == 0, 1e-12, values["Scale"])
        if node.vector_type == "TEXTURE":
            linear = np.diag(1.0 / size) @ turn.T
            offset = -linear @ values["Location"]
        elif node.vector_type == "NORMAL":
            linear, offset = turn @ np.diag(1.0 / size), np.zeros(3)
        else:
            linear, offset = turn @ np.diag(size), values["Location"]
        return Lookup(linear @ inner.linear, linear @ inner.offset + offset)


#: Exponents of mist that grows with distance.
_FALLOFF = {"LINEAR": 1.0, "QUADRATIC": 2.0, "INVERSE_QUADRATIC": 0.5}


def mist_of(world: Any) -> tuple[float, float, float]:
    """Start and depth of the mist [m] and the exponent of its growth."""
    if world is None:
        return 0.0, 100.0, 1.0
    mist = world.mist_settings
    return mist.start, max(1e-6, mist.depth), _FALLOFF.get(mist.falloff, 1.0)
