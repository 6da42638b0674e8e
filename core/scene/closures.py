"""Rows of shader nodes: what the exporter, scripts and tests make materials of."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .scene import SceneError
from .tables import CLOSURE, FACTOR, MOST_FACTORS, PARAM, PARAM_NAMES, Channel, ClosureKind

#: What Blender's nodes begin with, where that is not 0 or no texture.
_DEFAULTS: tuple[tuple[str, Any], ...] = (
    ("color", 0.8),
    ("alpha", 1.0),
    ("ior", 1.5),
    ("specular_level", 0.5),
    ("specular_tint", 1.0),
    ("coat_roughness", 0.03),
    ("coat_ior", 1.5),
    ("coat_tint", 1.0),
    ("sheen_roughness", 0.5),
    ("sheen_tint", 1.0),
)


def param(value: ArrayLike, texture: int = -1, channel: Channel = Channel.COLOR) -> Any:
    """A row of ``tables.PARAM``: ``value`` (number or (3,)) times a channel of a texture."""
    row = np.zeros((), PARAM)
    row["value"] = value
    row["texture"] = texture
    row["channel"] = int(channel)
    return row[()]


def factor(value: ArrayLike | np.void, invert: bool = False) -> Any:
    """A row of ``tables.FACTOR``; ``invert`` for the upper of two mixed shaders."""
    row = np.zeros((), FACTOR)
    row["param"] = value if isinstance(value, np.void) else param(value)
    row["invert"] = invert
    return row[()]


def closure(kind: ClosureKind, factors: Sequence[np.void] = (), **values: Any) -> Any:
    """A row of ``tables.CLOSURE`` with the values of a fresh node where none are given.

    Parameters take a number, a colour, a row of ``param`` or (value, texture) or (value,
    texture, channel). Raises ``SceneError`` for an unknown field or too many factors.
    """
    if len(factors) > MOST_FACTORS:
        raise SceneError(f"a shader has {len(factors)} mix factors, at most {MOST_FACTORS}")
    row = np.zeros((), CLOSURE)
    row["kind"] = int(kind)
    row["factor_count"] = len(factors)
    row["factors"]["param"]["texture"] = -1
    for k, given in enumerate(factors):
        row["factors"][k] = given
    for name in PARAM_NAMES:
        row[name] = param(0.0)
    for name, value in (*_DEFAULTS, *values.items()):
        if name not in (CLOSURE.names or ()):
            raise SceneError(f"shaders have no field '{name}'")
        row[name] = _param_of(value) if name in PARAM_NAMES else value
    return row[()]


def glossy(color: ArrayLike, roughness: float, multiscatter: bool = True) -> Any:
    """A rough mirror, as Blender's Glossy node."""
    return closure(
        ClosureKind.GLOSSY, color=color, roughness=roughness, distribution=int(multiscatter)
    )


def rough_glass(
    ior: float, roughness: float, color: ArrayLike = 1.0, multiscatter: bool = True
) -> Any:
    """Rough glass, as Blender's Glass node."""
    return closure(
        ClosureKind.GLASS, color=color, roughness=roughness, ior=ior,
        distribution=int(multiscatter),
    )  # fmt: skip


def sheen(color: ArrayLike, roughness: float) -> Any:
    """A layer of fibres, as Blender's Sheen node."""
    return closure(ClosureKind.SHEEN, color=color, roughness=roughness)


def principled(multiscatter: bool = True, **values: Any) -> Any:
    """Blender's Principled node with the given fields of ``tables.CLOSURE``."""
    return closure(ClosureKind.PRINCIPLED, distribution=int(multiscatter), **values)


def medium_of(row: Any) -> float:
    """Index of the medium behind a surface of this closure, 0 when light does not get in."""
    refracts = row["kind"] in (ClosureKind.GLASS, ClosureKind.REFRACTION)
    if row["kind"] == ClosureKind.PRINCIPLED:
        through = row["transmission"]
        refracts = through["value"][0] > 0.0
    return float(row["ior"]) if refracts else 0.0


def lets_pass(row: Any) -> bool:
    """Whether some ray may go straight through this closure."""
    if row["kind"] == ClosureKind.PRINCIPLED:
        return bool(row["alpha"]["texture"] >= 0 or row["alpha"]["value"][0] < 1.0)
    return bool(row["kind"] == ClosureKind.TRANSPARENT)


def _param_of(value: Any) -> Any:
    if isinstance(value, np.void):
        return value
    if isinstance(value, tuple) and len(value) in (2, 3) and isinstance(value[1], int):
        return param(*value)
    return param(value)
