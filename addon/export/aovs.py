"""AOV Output nodes: values of the user's own on surfaces, or of the world.

Inputs are read like those of shaders (``values.py``): constants, textures, and what can be
made of them; of anything else the input's own value is taken, with one warning.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..report import ExportLog
from .nodes import Placed
from .trees import tree_of
from .values import ValueReader


def material_aovs(reader: ValueReader, tree: Any, wanted: Mapping[str, str]) -> dict[str, Any]:
    """Rows of ``closures.param`` for those of ``wanted`` that ``tree`` has, by name."""
    found: dict[str, Any] = {}
    if not wanted:
        return found
    for node in _outputs(tree):
        name = node.item.aov_name
        if name not in wanted:
            continue
        if name in found:
            reader.log.warn(
                f"{reader.owner} has several outputs for AOV '{name}', the first one counts"
            )
            continue
        if wanted[name] == "COLOR":
            found[name] = reader.color_value(node, "Color").row()
        else:
            found[name] = reader.number_value(node, "Value").row()
    return found


def world_aovs(world: Any, wanted: Mapping[str, str], log: ExportLog) -> dict[str, Any]:
    """The same of a world, whose pictures are not looked up for it."""
    tree = None if world is None else tree_of(world)
    if tree is None:
        return {}
    return material_aovs(ValueReader(f"world '{world.name}'", log), tree, wanted)


def _outputs(tree: Any, groups: tuple[Any, ...] = ()) -> Iterator[Placed]:
    """The AOV Output nodes of a tree and of the groups in it."""
    for node in tree.nodes:
        if node.mute:
            continue
        if node.type == "OUTPUT_AOV":
            yield Placed(node, groups)
        elif node.type == "GROUP" and node.node_tree is not None and node not in groups:
            yield from _outputs(node.node_tree, (*groups, node))
