"""The world: uniform radiance from every direction."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..report import ExportLog
from .nodes import NodeReader, tree_of
from .shaders import ShaderFolder


def world_radiance(world: Any | None, log: ExportLog) -> NDArray[np.float64]:
    """Radiance (3,) [W/(m^2 sr)] of ``world``: colour x strength of its Background."""
    if world is None:
        return np.zeros(3)
    tree = tree_of(world)
    if tree is None:
        return np.maximum(np.array(world.color[:3], dtype=np.float64), 0.0)
    output = tree.get_output_node("CYCLES")
    if output is None:
        return np.zeros(3)
    owner = f"world '{world.name}'"
    if output.inputs["Volume"].is_linked:
        log.warn(f"{owner}: volume is not supported yet and ignored")
    return ShaderFolder(NodeReader(owner, log), "black").fold(output.inputs["Surface"]).emission
