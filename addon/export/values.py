"""What arrives at an input: a constant, or a constant times a channel of a texture.

| node | becomes |
|---|---|
| Value, RGB | a constant |
| Image Texture | its texture (``pictures.py``); Color, or Alpha |
| Separate Color (RGB), Separate XYZ | a channel of what comes in |
| RGB to BW | the luminance of what comes in |
| Math: Multiply; Mix: Multiply with factor 1 | the product, when one side is constant |
| Hue/Saturation, Gamma, Brightness/Contrast, Curves, Invert | constants of Invert and Gamma \
are worked out; a texture passes through unchanged, with one warning |
| any other | the input's own value, with one warning |
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.closures import param
from ...core.scene.tables import Channel
from .nodes import NodeReader, Placed, as_color, as_number, default_of, origin_of, placed
from .pictures import PictureTable

#: Nodes that only change colours, and where they take them from.
_COLOR_CHANGES = {
    "HUE_SAT": "Color", "GAMMA": "Color", "BRIGHTCONTRAST": "Color", "CURVE_RGB": "Color",
    "INVERT": "Color", "CLAMP": "Value",
}  # fmt: skip
#: Outputs of the separating nodes, in their three generations.
_CHANNELS = {
    "Red": Channel.RED, "Green": Channel.GREEN, "Blue": Channel.BLUE,
    "R": Channel.RED, "G": Channel.GREEN, "B": Channel.BLUE,
    "X": Channel.RED, "Y": Channel.GREEN, "Z": Channel.BLUE,
}  # fmt: skip
_SEPARATING = ("SEPARATE_COLOR", "SEPRGB", "SEPXYZ")


@dataclass(frozen=True, eq=False)
class Value:
    """``value`` (number or colour (3,)) times ``channel`` of ``texture`` (-1: alone).

    ``mean`` (3,): what it is on average over the picture.
    """

    value: Any
    texture: int = -1
    channel: Channel = Channel.COLOR
    mean: NDArray[np.float64] = field(default_factory=lambda: np.ones(3))

    @property
    def is_constant(self) -> bool:
        """Whether there is no texture."""
        return self.texture < 0

    @property
    def color(self) -> NDArray[np.float64]:
        """The constant as a colour (3,)."""
        return as_color(self.value)

    @property
    def number(self) -> float:
        """The constant as a number."""
        return as_number(self.value)

    @property
    def average(self) -> NDArray[np.float64]:
        """Mean colour (3,) over the surface: that of the whole picture."""
        return self.color if self.is_constant else self.color * self.mean

    def times(self, factor: Any) -> Value:
        """The same times a number or colour."""
        if isinstance(factor, float) and isinstance(self.value, float):
            return replace(self, value=self.value * factor)
        return replace(self, value=self.color * as_color(factor))

    def of_channel(self, channel: Channel) -> Value:
        """One number of this colour."""
        if self.is_constant:
            if channel == Channel.LUMINANCE:
                return Value(self.number)
            return Value(float(self.color[channel - Channel.RED]))
        if self.channel != Channel.COLOR:  # a number already
            return self
        weights = self.color
        if channel == Channel.LUMINANCE:
            number = float(weights @ [0.2126, 0.7152, 0.0722])
            mean = as_number((*self.mean, 1.0))
        else:
            number = float(weights[channel - Channel.RED])
            mean = float(self.mean[channel - Channel.RED])
        return Value(number, self.texture, channel, np.full(3, mean))

    def as_number(self) -> Value:
        """This value where Blender wants a number."""
        if self.is_constant:
            return Value(self.number)
        return self.of_channel(Channel.LUMINANCE)

    def row(self) -> Any:
        """A row of ``tables.PARAM``."""
        value = self.value if isinstance(self.value, float) else self.color
        return param(value, self.texture, self.channel)

    @property
    def key(self) -> tuple[Any, ...]:
        """Equal for equal values."""
        return (*self.color.tolist(), self.texture, int(self.channel))


class ValueReader(NodeReader):
    """Reads inputs that may be textured; the rest as ``NodeReader`` does."""

    def __init__(self, owner: str, log: Any, pictures: PictureTable | None = None) -> None:
        super().__init__(owner, log)
        self.pictures = pictures

    def color_value(self, node: Placed, name: str | int, default: float = 1.0) -> Value:
        """The colour at input ``name``."""
        socket = node.input(name)
        if socket is None:
            return Value(np.full(3, default))
        value = self.at(socket)
        return Value(value.color) if value.is_constant else value

    def number_value(self, node: Placed, name: str | int, default: float = 0.0) -> Value:
        """The number at input ``name``."""
        socket = node.input(name)
        return Value(default) if socket is None else self.at(socket).as_number()

    def value(self, socket: Any) -> Any:
        """The constant at ``socket``; a texture there is replaced by the input's own value."""
        socket = placed(socket)
        found = self.at(socket)
        if found.is_constant:
            plain = isinstance(found.value, (float, tuple))
            return found.value if plain else (*found.color, 1.0)
        self.warn_unread(origin_of(socket).node, socket)
        return default_of(socket)

    def at(self, socket: Placed) -> Value:
        """What arrives at the input ``socket``."""
        self.note(socket)
        source = origin_of(socket)
        if not source.item.is_output:
            return _constant(default_of(source))
        found = self._output(source)
        if found is None:
            self.warn_unread(source.node, socket)
            return _constant(default_of(socket))
        return found

    def _output(self, source: Placed) -> Value | None:
        """What an output says, None when its node is not supported."""
        node, kind, name = source.node, source.item.node.type, source.item.name
        if kind in ("VALUE", "RGB"):
            return _constant(default_of(source))
        if kind == "TEX_IMAGE" and self.pictures is not None:
            texture, mean = self.pictures.texture(self, node)
            if name == "Alpha":
                return Value(1.0, texture, Channel.ALPHA, np.full(3, mean[3]))
            return Value(np.ones(3), texture, Channel.COLOR, mean[:3])
        if kind in _SEPARATING and getattr(node.item, "mode", "RGB") == "RGB":
            return self.at(Placed(node.item.inputs[0], node.groups)).of_channel(_CHANNELS[name])
        if kind == "RGBTOBW":
            return self.color_value(node, "Color").as_number()
        if kind == "MATH" and node.item.operation == "MULTIPLY":
            return _product(self.number_value(node, 0), self.number_value(node, 1), node)
        if kind == "MIX" or kind == "MIX_RGB":
            return self._mixed(node)
        if kind == "TEX_CHECKER" and name == "Color":
            return self._checkered(node)
        if kind in _COLOR_CHANGES:
            return self._changed(node)
        return None

    def _mixed(self, node: Placed) -> Value | None:
        """A Mix node that multiplies; or shows one of its sides."""
        if node.item.type == "MIX" and node.item.data_type != "RGBA":
            return None
        old = node.item.type == "MIX_RGB"
        factor = self.number_value(node, "Fac" if old else "Factor")
        names = ("Color1", "Color2") if old else ("A", "B")
        first, second = (self.color_value(node, name) for name in names)
        if not factor.is_constant:
            return None
        t = min(1.0, max(0.0, factor.number))
        if t == 0.0:
            return first
        if node.item.blend_type == "MULTIPLY" and t == 1.0:
            return _product(first, second, node)
        if node.item.blend_type != "MIX":
            return None
        if t == 1.0:
            return second
        if first.is_constant and second.is_constant:
            return Value(first.color * (1.0 - t) + second.color * t)
        return None

    def _checkered(self, node: Placed) -> Value | None:
        """As a colour between those of its squares, with a warning."""
        first, second = (self.color_value(node, name) for name in ("Color1", "Color2"))
        if not first.is_constant or not second.is_constant:
            return None
        self.log.warn(
            f"{self.owner}: node '{node.label}' is not supported yet; the mean of its colours "
            "is used",
            key=(self.owner, node.item.name),
        )
        return Value(0.5 * (first.color + second.color))

    def _changed(self, node: Placed) -> Value:
        """A node that changes colours: exact for some constants, else left out."""
        kind = node.item.type
        before = self.color_value(node, _COLOR_CHANGES[kind])
        if before.is_constant and kind == "GAMMA":
            exponent = self.number_value(node, "Gamma", 1.0).number
            return Value(np.maximum(before.color, 0.0) ** exponent)
        if before.is_constant and kind == "INVERT":
            t = self.number_value(node, 0, 1.0).number
            return Value(before.color * (1.0 - t) + (1.0 - before.color) * t)
        self.log.warn(
            f"{self.owner}: node '{node.label}' is not supported yet; the colour that comes "
            "in passes unchanged",
            key=(self.owner, node.item.name),
        )
        return before


def _constant(value: Any) -> Value:
    if isinstance(value, str):
        return Value(0.0)
    return Value(float(value) if isinstance(value, (bool, int, float)) else value)


def _product(a: Value, b: Value, node: Placed) -> Value | None:
    """The product of two values of which one at most is textured."""
    limited = getattr(node.item, "use_clamp", False) or getattr(
        node.item, "clamp_result", False
    )
    if b.is_constant:
        a, b = b, a
    if not a.is_constant or (limited and not b.is_constant):
        return None
    product = b.times(a.value if isinstance(a.value, float) else a.color)
    if limited:
        product = replace(product, value=np.clip(product.color, 0.0, 1.0))
    return product
