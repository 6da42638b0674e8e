"""Normal Map and Bump nodes at the Normal input of a shader."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import Any

from ...core.scene.tables import Channel
from .nodes import Placed, node_behind
from .values import Value, ValueReader

#: Longest chain of bump nodes that is followed.
_MOST_NODES = 16


@dataclass(frozen=True)
class NormalSource:
    """Fields of ``tables.MATERIAL`` that bend the shading normal."""

    normal_texture: int = -1
    normal_strength: float = 1.0
    bump_texture: int = -1
    bump_strength: float = 1.0
    bump_distance: float = 0.0

    @property
    def key(self) -> tuple[Any, ...]:
        """Equal for equal normals."""
        return astuple(self)


def normal_source(reader: ValueReader, shader: Placed) -> NormalSource | None:
    """What bends the normal of the node ``shader``, None when nothing does.

    A Bump node may take its normal from a Normal Map; of two bump nodes in a row the first
    counts. Other nodes give one warning.
    """
    found: dict[str, Any] = {}
    socket = shader.input("Normal")
    for _ in range(_MOST_NODES):
        if socket is None or reader.pictures is None:
            break
        node = node_behind(socket)
        if node is None:
            break
        reader.note(socket)
        if node.item.type == "NORMAL_MAP":
            found |= _normal_map(reader, node)
            break
        if node.item.type != "BUMP" or "bump_texture" in found:
            reader.warn_unread(node, socket)
            break
        found |= _bump(reader, node)
        socket = node.input("Normal")
    return NormalSource(**found) if found else None


def _normal_map(reader: ValueReader, node: Placed) -> dict[str, Any]:
    """A tangent-space normal map by an image; other spaces and sources give a warning."""
    socket = node.input("Color")
    assert socket is not None and reader.pictures is not None
    source = node_behind(socket)
    reader.note(socket)
    if source is None:
        return {}
    image = source.item.type == "TEX_IMAGE"
    if node.item.space != "TANGENT" or not image:
        reader.warn_unread(node if image else source, socket)
        return {}
    flip = getattr(node.item, "convention", "OPENGL") == "DIRECTX"
    texture, _ = reader.pictures.texture(reader, source, flip_green=flip)
    return {
        "normal_texture": texture,
        "normal_strength": max(0.0, reader.number(node, "Strength", 1.0)),
    }


def _bump(reader: ValueReader, node: Placed) -> dict[str, Any]:
    """A height image; its factor goes into the distance."""
    height: Value = reader.number_value(node, "Height")
    if height.is_constant:
        return {}
    if height.channel == Channel.ALPHA:
        reader.log.warn_group("heights from alpha are read from the colour in", reader.owner)
    distance = reader.number(node, "Distance", 1.0) * float(height.color[0])
    return {
        "bump_texture": height.texture,
        "bump_strength": max(0.0, reader.number(node, "Strength", 1.0)),
        "bump_distance": -distance if node.item.invert else distance,
    }
