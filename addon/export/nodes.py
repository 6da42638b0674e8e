"""Reads node trees: follows links to their source and folds constants.

Only graph walking is here; what a shader node means is in ``shaders.py``.
"""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..report import ExportLog

#: Weights of scene-linear Rec. 709 with which Blender turns a colour into a number.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def tree_of(owner: Any) -> Any | None:
    """The node tree of a material, world or light when it is in use.

    ``use_nodes`` of materials and worlds is deprecated and always true from 5.0 on.
    """
    deprecated = bpy.app.version >= (5, 0, 0) and not isinstance(owner, bpy.types.Light)
    if not deprecated and not owner.use_nodes:
        return None
    return owner.node_tree


def source_of(socket: Any) -> Any:
    """Where the value of an input socket comes from.

    Goes through reroutes and muted nodes. An output socket of a node at work, or an input
    socket, whose own value then counts.
    """
    current = socket
    while current.is_linked:
        link = current.links[0]
        if link.is_muted or not link.is_valid:
            break
        node, output = link.from_node, link.from_socket
        if node.type == "REROUTE":
            if not node.inputs[0].is_linked:
                return socket
            current = node.inputs[0]
        elif node.mute:
            through = [inner for inner in node.internal_links if inner.to_socket == output]
            if not through:
                return socket
            current = through[0].from_socket
        else:
            return output
    return current


def shader_of(socket: Any) -> Any | None:
    """The shader node that feeds ``socket``, None when there is none."""
    source = source_of(socket)
    return source.node if source.is_output else None


class NodeReader:
    """Constant input values of the nodes of one material, world or light.

    A linked node that is no constant is replaced by the input's own value, with one warning
    for each such node. ``owner`` is its name in messages, as in "material 'Wood'".
    """

    def __init__(self, owner: str, log: ExportLog) -> None:
        self.owner = owner
        self.log = log
        self._read: set[Any] = set()

    def value(self, socket: Any) -> Any:
        """The value of ``socket``: a number or a sequence."""
        self._read.add(socket.as_pointer())
        source = source_of(socket)
        if source.is_output and source.node.type not in ("VALUE", "RGB"):
            self.warn_unread(source.node, socket)
            source = socket
        value = getattr(source, "default_value", 0.0)
        return value if isinstance(value, (bool, int, float, str)) else tuple(value)

    def number(self, node: Any, name: str, default: float = 0.0) -> float:
        """The number at input ``name``, ``default`` when this Blender has no such input."""
        socket = node.inputs.get(name)
        return default if socket is None else as_number(self.value(socket))

    def color(self, node: Any, name: str, default: float = 1.0) -> NDArray[np.float64]:
        """The colour (3,) at input ``name``."""
        socket = node.inputs.get(name)
        if socket is None:
            return np.full(3, default)
        value = self.value(socket)
        if isinstance(value, (bool, int, float)):
            return np.full(3, float(value))
        return np.array(value[:3], dtype=np.float64)

    def warn_unread(self, node: Any, socket: Any) -> None:
        """Warn that ``node`` is not evaluated."""
        label = node.label or node.name
        self.log.warn(
            f"{self.owner}: node '{label}' at input '{socket.name}' of "
            f"'{socket.node.name}' is not supported yet; the input's own value is used",
            key=(self.owner, node.name),
        )

    def finish(self, node: Any) -> None:
        """Warn about linked inputs of ``node`` that nobody has read, such as a bump map."""
        for socket in node.inputs:
            if socket.type == "SHADER" or socket.as_pointer() in self._read:
                continue
            source = source_of(socket)
            if source.is_output and socket.enabled:
                self.warn_unread(source.node, socket)


def as_number(value: Any) -> float:
    """A socket value as Blender converts it to a number."""
    if isinstance(value, (bool, int, float)):
        return float(value)
    return float(np.array(value[:3], dtype=np.float64) @ LUMINANCE)
