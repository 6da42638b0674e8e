"""Which node tree of a datablock counts; apart, as panels ask it before NumPy is loaded."""

from __future__ import annotations

from typing import Any

import bpy


def tree_of(owner: Any) -> Any | None:
    """The node tree of a material, world or light when it is in use.

    ``use_nodes`` of materials and worlds is deprecated and always true from 5.0 on.
    """
    deprecated = bpy.app.version >= (5, 0, 0) and not isinstance(owner, bpy.types.Light)
    if not deprecated and not owner.use_nodes:
        return None
    return owner.node_tree
