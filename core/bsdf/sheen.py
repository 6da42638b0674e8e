"""Sheen of fibres on a surface: a linearly transformed cosine."""

from __future__ import annotations

from ..geometry.vector import Vector
from ..jit import Row, Table, kernel


@kernel
def put_sheen(
    lobes: Table, at: int, tables: Row, weight: Vector, roughness: float, cosine: float
) -> tuple[int, float]:
    """Not there yet."""
    return at, 0.0
