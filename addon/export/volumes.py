"""Absorption inside a body, from the nodes at a material's Volume output."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .nodes import Placed, node_behind, placed
from .values import ValueReader


def absorption(reader: ValueReader, socket: Any) -> NDArray[np.float64]:
    """Absorption coefficient (3,) [1/m] of the volume at ``socket``: (1 - colour) x density.

    Through Add Shader and Mix Shader with a constant factor; other volume nodes absorb
    nothing and give one warning.
    """
    return _of_node(reader, node_behind(placed(socket)))


def _of_node(reader: ValueReader, node: Placed | None) -> NDArray[np.float64]:
    if node is None:
        return np.zeros(3)
    if node.item.type == "VOLUME_ABSORPTION":
        clear = 1.0 - reader.color(node, "Color")
        density = max(0.0, reader.number(node, "Density", 1.0))
        reader.finish(node)
        return np.maximum(clear * density, 0.0)
    if node.item.type == "ADD_SHADER":
        return _input(reader, node, 0) + _input(reader, node, 1)
    if node.item.type == "MIX_SHADER":
        socket = node.input(0)
        assert socket is not None
        value = reader.value(socket)
        t = min(1.0, max(0.0, value if isinstance(value, float) else float(np.mean(value))))
        return (1.0 - t) * _input(reader, node, 1) + t * _input(reader, node, 2)
    reader.log.warn(
        f"{reader.owner}: volume node '{node.label}' is not supported yet and ignored, only "
        "Volume Absorption is rendered"
    )
    return np.zeros(3)


def _input(reader: ValueReader, node: Placed, place: int) -> NDArray[np.float64]:
    socket = node.input(place)
    return _of_node(reader, None if socket is None else node_behind(socket))
