"""Folds a tree of shader nodes into weighed shaders: through Mix and Add Shader.

Mix Shader gives both inputs, weighed by 1 - factor and factor; Add Shader the sum of both.
Constant factors become one weight; up to ``MOST_FACTORS - 1`` textured ones stay, of more
the mean counts, with a warning. The result is constant lobes where it can be, else rows of
``tables.CLOSURE``, which are worked out at each hit.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.builder import Lobe
from ...core.scene.closures import factor
from ...core.scene.tables import MOST_FACTORS, ClosureKind
from .nodes import NodeReader, Placed, node_behind, placed
from .normals import NormalSource, normal_source
from .shaders import FALLBACK, SHADERS, Shader
from .values import Value, ValueReader


@dataclass(frozen=True, eq=False)
class Leaf:
    """A shader node with its place in the tree: a weight and textured mix factors.

    ``factors``: pairs of a value and whether 1 minus it counts. ``key``: equal for one node.
    """

    key: tuple[Any, ...]
    shader: Shader
    normal: NormalSource | None = None
    weight: float = 1.0
    factors: tuple[tuple[Value, bool], ...] = ()

    @property
    def place(self) -> tuple[Any, ...]:
        """Equal for leaves that differ in weight only."""
        return (self.key, *((value.key, invert) for value, invert in self.factors))

    @property
    def average(self) -> float:
        """The weight, with the mean of every texture."""
        product = self.weight
        for value, invert in self.factors:
            mean = min(1.0, max(0.0, float(np.mean(value.average))))
            product *= 1.0 - mean if invert else mean
        return product

    def row(self) -> Any:
        """A row of ``tables.CLOSURE``."""
        rows = [factor(value.row(), invert) for value, invert in self.factors]
        if self.weight != 1.0:
            rows.insert(0, factor(self.weight))
        return self.shader.row(rows)


@dataclass(frozen=True, eq=False)
class Shading:
    """What a shader socket folds to."""

    leaves: tuple[Leaf, ...] = ()

    def plus(self, other: Shading) -> Shading:
        """The sum; leaves that differ in weight only become one."""
        sums: dict[tuple[Any, ...], Leaf] = {}
        for leaf in (*self.leaves, *other.leaves):
            before = sums.get(leaf.place)
            weight = leaf.weight + (before.weight if before else 0.0)
            sums[leaf.place] = replace(leaf, weight=weight)
        return Shading(tuple(leaf for leaf in sums.values() if leaf.weight > 0))

    def scaled(self, weight: float) -> Shading:
        """The same with every weight times ``weight``."""
        return Shading(tuple(replace(b, weight=b.weight * weight) for b in self.leaves))

    @property
    def emission(self) -> NDArray[np.float64]:
        """Emitted radiance (3,), its mean where it is textured."""
        total = np.zeros(3)
        for leaf in self.leaves:
            radiance = np.maximum(leaf.shader.get("emission").average, 0.0) * leaf.average
            if leaf.shader.kind == ClosureKind.PRINCIPLED:
                radiance = radiance * np.clip(leaf.shader.get("alpha").average, 0.0, 1.0)
            total += radiance
        return total

    @property
    def normals(self) -> list[NormalSource | None]:
        """Bent normals of the shaders that have one, each once."""
        found: dict[Any, NormalSource | None] = {}
        for leaf in self.leaves:
            if leaf.shader.kind not in (ClosureKind.EMISSION, ClosureKind.TRANSPARENT):
                found[leaf.normal and leaf.normal.key] = leaf.normal
        return list(found.values())

    @property
    def ior(self) -> float:
        """Index of the medium behind the surface, 0 without one."""
        return next((b.shader.ior for b in self.leaves if b.shader.ior > 0), 0.0)

    @property
    def passes(self) -> bool:
        """Whether some light goes straight through."""
        return any(leaf.shader.passes for leaf in self.leaves)

    @property
    def holdouts(self) -> tuple[Leaf, ...]:
        """Leaves that are holdouts."""
        return tuple(leaf for leaf in self.leaves if leaf.shader.holds_out)

    @property
    def is_holdout(self) -> bool:
        """Whether it is a hole and nothing else."""
        whole = bool(self.leaves) and self.holdouts == self.leaves
        # Less than all of a holdout is a black surface for the rest.
        return whole and all(leaf.weight >= 1.0 and not leaf.factors for leaf in self.leaves)

    def lobes(self) -> tuple[Lobe, ...] | None:
        """Constant lobes, None when the shaders have to be worked out at each hit."""
        if any(normal is not None for normal in self.normals):
            return None
        found: list[Lobe] = []
        for leaf in self.leaves:
            lobes = None if leaf.factors else leaf.shader.lobes()
            if lobes is None:
                return None
            found += [lobe.scaled(leaf.weight) for lobe in lobes]
        return merged(found)

    def rows(self) -> list[Any]:
        """Rows of ``tables.CLOSURE``."""
        return [leaf.row() for leaf in self.leaves]


def merged(lobes: Iterable[Lobe]) -> tuple[Lobe, ...]:
    """``lobes`` with equal ones added up and black ones left out."""
    sums: dict[Lobe, NDArray[np.float64]] = {}
    for lobe in lobes:
        key = replace(lobe, weight=(0.0, 0.0, 0.0))
        sums[key] = sums.get(key, np.zeros(3)) + np.array(lobe.weight)
    return tuple(
        replace(key, weight=(float(weight[0]), float(weight[1]), float(weight[2])))
        for key, weight in sums.items()
        if weight.any()
    )


class ShaderFolder:
    """Folds the shader nodes of one material, world or light; each node once."""

    def __init__(self, reader: NodeReader, instead: str = "a grey diffuse surface") -> None:
        if not isinstance(reader, ValueReader):
            reader = ValueReader(reader.owner, reader.log)
        self.reader = reader
        self.instead = instead
        self._folded: dict[tuple[int, ...], Shading] = {}

    def fold(self, socket: Any) -> Shading:
        """The shading that arrives at the input ``socket``."""
        node = node_behind(placed(socket))
        if node is None:
            return Shading()
        if node.key not in self._folded:
            self._folded[node.key] = self._node(node)
        return self._folded[node.key]

    def _node(self, node: Placed) -> Shading:
        kind, reader = node.item.type, self.reader
        if kind == "MIX_SHADER":
            # By place: the first input is called "Fac" before 5.0, the others alike.
            return self._mixed(reader.number_value(node, 0), node)
        if kind == "ADD_SHADER":
            return self._input(node, 0).plus(self._input(node, 1))
        make = SHADERS.get(kind)
        if make is None:
            reader.log.warn(
                f"{reader.owner}: shader node '{node.label}' is not supported yet; "
                f"{self.instead} is rendered instead"
            )
            grey = Shader(ClosureKind.DIFFUSE, {"color": Value(np.full(3, FALLBACK))})
            return Shading((Leaf(node.key, grey),))
        shader = make(reader, node)
        leaf = Leaf(node.key, shader, normal_source(reader, node))
        reader.finish(node)
        return Shading((leaf,))

    def _input(self, node: Placed, place: int) -> Shading:
        socket = node.input(place)
        return Shading() if socket is None else self.fold(socket)

    def _mixed(self, value: Value, node: Placed) -> Shading:
        first, second = self._input(node, 1), self._input(node, 2)
        if not value.is_constant:
            deepest = max((len(b.factors) for b in (*first.leaves, *second.leaves)), default=0)
            if deepest < MOST_FACTORS - 1:
                return _with(first, value, True).plus(_with(second, value, False))
            self.reader.log.warn(
                f"{self.reader.owner}: '{node.label}' mixes by one texture too many, the "
                "texture's mean is used"
            )
            value = Value(float(np.mean(value.average)))
        t = min(1.0, max(0.0, value.number))
        return first.scaled(1.0 - t).plus(second.scaled(t))


def _with(shading: Shading, value: Value, invert: bool) -> Shading:
    """``shading`` with one more textured factor."""
    return Shading(
        tuple(replace(b, factors=(*b.factors, (value, invert))) for b in shading.leaves)
    )
