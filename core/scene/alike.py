"""Whether two scenes say the same, field by field."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .scene import Scene


def alike(a: Scene, b: Scene, names: Iterable[str]) -> bool:
    """Whether the fields ``names`` of two scenes are the same, bit for bit.

    An export that was made anew has other arrays of the same content.
    """
    return all(_same(getattr(a, name), getattr(b, name)) for name in names)


def _same(a: Any, b: Any) -> bool:
    if a is b:
        return True
    if not isinstance(a, np.ndarray):
        return bool(a == b)
    if a.shape != b.shape or a.dtype != b.dtype:
        return False
    names = a.dtype.names
    if names is not None:  # a copy has other bytes between its fields
        return all(_same(a[name], b[name]) for name in names)
    return bool(np.array_equal(_bytes(a), _bytes(b)))


def _bytes(array: NDArray[Any]) -> NDArray[np.uint8]:
    return np.ascontiguousarray(array).reshape(-1).view(np.uint8)
