"""Reads node trees: follows links to their source, into node groups and out of them.

Only graph walking is here; what the nodes mean is in ``values.py`` and ``shaders.py``. A
group's tree stands once in Blender and once for each node that uses it in the picture, so
sockets and nodes go about together with the group nodes that they were reached through.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..report import ExportLog

#: Weights of scene-linear Rec. 709 with which Blender turns a colour into a number.
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

#: Links followed for one value: a group that contains itself would have no end.
_MOST_STEPS = 1000


class Placed(NamedTuple):
    """A node or socket, and the group nodes it lies in, the outermost first."""

    item: Any
    groups: tuple[Any, ...] = ()

    @property
    def node(self) -> Placed:
        """The node of a socket."""
        return Placed(self.item.node, self.groups)

    @property
    def key(self) -> tuple[int, ...]:
        """Equal for the same item in the same groups."""
        return (self.item.as_pointer(), *(group.as_pointer() for group in self.groups))

    @property
    def label(self) -> str:
        """What the user calls this node."""
        return str(self.item.label or self.item.name)

    def input(self, name: str | int) -> Placed | None:
        """An input of this node by name or place, None when this Blender has none such."""
        if isinstance(name, int):
            return Placed(self.item.inputs[name], self.groups)
        for socket in self.item.inputs:
            # Nodes for several types have a socket of one name for each, one of them on.
            if socket.name == name and socket.enabled:
                return Placed(socket, self.groups)
        socket = self.item.inputs.get(name)
        return None if socket is None else Placed(socket, self.groups)


def placed(item: Any) -> Placed:
    """A node or socket of a tree that is no group, unless it is placed already."""
    return item if isinstance(item, Placed) else Placed(item)


def origin_of(socket: Any) -> Placed:
    """Where the value of an input socket comes from.

    Goes through reroutes, muted nodes and the borders of groups. An output socket of a node
    at work, or an input socket, whose own value then counts.
    """
    start = current = placed(socket)
    for _ in range(_MOST_STEPS):
        link = _link_to(current)
        if link is None:
            return current
        node, output = link.from_node, link.from_socket
        through: Placed | None
        if node.type == "REROUTE":
            through = Placed(node.inputs[0], current.groups)
            if not node.inputs[0].is_linked:
                return start
        elif node.mute:
            inner = [way.from_socket for way in node.internal_links if way.to_socket == output]
            through = Placed(inner[0], current.groups) if inner else None
        elif node.type == "GROUP" and node.node_tree is not None:
            through = _into_group(node, output, current.groups)
        elif node.type == "GROUP_INPUT" and current.groups:
            group = current.groups[-1]
            through = _by_identifier(group.inputs, output.identifier, current.groups[:-1])
        else:
            return Placed(output, current.groups)
        if through is None:
            return start
        current = through
    return start


def _link_to(socket: Placed) -> Any | None:
    """The link that ends at an input, None without one that counts."""
    if not socket.item.is_linked:
        return None
    link = socket.item.links[0]
    return None if link.is_muted or not link.is_valid else link


def _into_group(node: Any, output: Any, groups: tuple[Any, ...]) -> Placed | None:
    """The input of a group's output node that stands behind ``output`` of the group node."""
    ends = [inner for inner in node.node_tree.nodes if inner.type == "GROUP_OUTPUT"]
    active = [end for end in ends if end.is_active_output] or ends
    if not active or node in groups:
        return None
    return _by_identifier(active[0].inputs, output.identifier, (*groups, node))


def _by_identifier(sockets: Any, identifier: str, groups: tuple[Any, ...]) -> Placed | None:
    for socket in sockets:
        if socket.identifier == identifier:
            return Placed(socket, groups)
    return None


def node_behind(socket: Any) -> Placed | None:
    """The node that feeds ``socket`` with the groups it lies in, None without one."""
    source = origin_of(socket)
    return source.node if source.item.is_output else None


def source_of(socket: Any) -> Any:
    """The socket that the value of ``socket`` comes from, for those who keep out of groups."""
    return origin_of(socket).item


def shader_of(socket: Any) -> Any | None:
    """The node that feeds ``socket``, None when there is none."""
    node = node_behind(socket)
    return None if node is None else node.item


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
        socket = placed(socket)
        self.note(socket)
        source = origin_of(socket)
        if source.item.is_output and source.item.node.type not in ("VALUE", "RGB"):
            self.warn_unread(source.node, socket)
            source = socket
        return default_of(source)

    def number(self, node: Any, name: str, default: float = 0.0) -> float:
        """The number at input ``name``, ``default`` when this Blender has no such input."""
        socket = placed(node).input(name)
        return default if socket is None else as_number(self.value(socket))

    def color(self, node: Any, name: str, default: float = 1.0) -> NDArray[np.float64]:
        """The colour (3,) at input ``name``."""
        socket = placed(node).input(name)
        return np.full(3, default) if socket is None else as_color(self.value(socket))

    def note(self, socket: Placed) -> None:
        """Remember that somebody has read ``socket``."""
        self._read.add(socket.key)

    def warn_unread(self, node: Any, socket: Any) -> None:
        """Warn that ``node`` is not evaluated."""
        node, socket = placed(node), placed(socket)
        self.log.warn(
            f"{self.owner}: node '{node.label}' at input '{socket.item.name}' of "
            f"'{socket.item.node.name}' is not supported yet; the input's own value is used",
            key=(self.owner, node.item.name),
        )

    def finish(self, node: Any) -> None:
        """Warn about linked inputs of ``node`` that nobody has read, such as a tangent."""
        node = placed(node)
        for socket in node.item.inputs:
            here = Placed(socket, node.groups)
            if socket.type == "SHADER" or here.key in self._read:
                continue
            source = origin_of(here)
            if source.item.is_output and socket.enabled:
                self.warn_unread(source.node, here)


def default_of(socket: Placed) -> Any:
    """A socket's own value: a number or a tuple."""
    value = getattr(socket.item, "default_value", 0.0)
    return value if isinstance(value, (bool, int, float, str)) else tuple(value)


def as_number(value: Any) -> float:
    """A socket value as Blender converts it to a number."""
    if isinstance(value, (bool, int, float)):
        return float(value)
    if isinstance(value, tuple) and len(value) == 3:  # a vector, not a colour
        return float(np.mean(value))
    return float(np.array(value[:3], dtype=np.float64) @ LUMINANCE)


def as_color(value: Any) -> NDArray[np.float64]:
    """A socket value as Blender converts it to a colour (3,)."""
    if isinstance(value, (bool, int, float)):
        return np.full(3, float(value))
    return np.array(value[:3], dtype=np.float64)
