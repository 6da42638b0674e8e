"""BRDFs that are added to the engine: a file beside this one, and one of these lines.

``docs/brdf.md`` shows it with a whole example. A lobe of ``Model.ADDED_1`` is scattered by
the first, one of ``Model.ADDED_2`` by the second.
"""

from __future__ import annotations

from ..geometry.vector import Vector
from ..jit import Row, kernel
from . import nothing as added_1
from . import nothing as added_2


@kernel
def eval_added(first: bool, lobe: Row, n: Vector, wo: Vector, wi: Vector) -> Vector:
    """Value [1/sr] of the first or the second added BRDF."""
    if first:
        return added_1.evaluate(lobe, n, wo, wi)
    return added_2.evaluate(lobe, n, wo, wi)


@kernel
def sample_added(first: bool, lobe: Row, n: Vector, wo: Vector, u: float, v: float) -> Vector:
    """Direction drawn by the first or the second added BRDF."""
    if first:
        return added_1.sample(lobe, n, wo, u, v)
    return added_2.sample(lobe, n, wo, u, v)


@kernel
def pdf_added(first: bool, lobe: Row, n: Vector, wo: Vector, wi: Vector) -> float:
    """Density of ``sample_added`` per solid angle."""
    if first:
        return added_1.pdf(lobe, n, wo, wi)
    return added_2.pdf(lobe, n, wo, wi)
