"""Which media a path is inside of: a stack of material rows, the innermost on top."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..jit import allocating_kernel as kernel
from .brute import closest
from .flat import Flat
from .vector import Vec, along, dot, vec

#: A stack is an int64 array: [0] counts the entries that follow.
SLOTS = 32
Stack = NDArray[np.int64]


@kernel
def _top(stack: Stack) -> int:
    return stack[stack[0]] if stack[0] > 0 else -1


@kernel
def _remove(stack: Stack, material: int) -> bool:
    """Take out the topmost entry of ``material``; False when it has none."""
    for i in range(stack[0], 0, -1):
        if stack[i] == material:
            for k in range(i, stack[0]):
                stack[k] = stack[k + 1]
            stack[0] -= 1
            return True
    return False


@kernel
def _push(stack: Stack, material: int) -> None:
    if stack[0] < SLOTS - 1:
        stack[0] += 1
        stack[stack[0]] = material


@kernel
def _index(s: Flat, material: int) -> float:
    return (
        s.materials[material].ior if material >= 0 and s.materials[material].ior > 0.0 else 1.0
    )


@kernel
def cross_surface(
    s: Flat, stack: Stack, material: int, entering: bool, after: Stack
) -> tuple[float, float]:
    """Indices (n_i, n_t) before and behind the surface; ``after``: the stack behind it."""
    after[:] = stack
    if entering:
        _push(after, material)
        return _index(s, _top(stack)), _index(s, material)
    # One left without having been entered: the path began inside it.
    _remove(after, material)
    return _index(s, material), _index(s, _top(after))


@kernel
def start_inside(s: Flat, o: Vec, stack: Stack) -> None:
    """Fill ``stack`` with the media around ``o``: those left but never entered on a line."""
    d = (0.4242640687119285, 0.5656854249492381, 0.7071067811865475)
    open_since = np.zeros(SLOTS, np.int64)
    found = np.zeros(SLOTS, np.int64)
    p, skip = o, -1
    for _ in range(10_000):
        t, face, _u, _v = closest(s, p, d, skip, np.inf)
        if face < 0:
            break
        p, skip = along(p, d, t), face
        material = s.faces[face].material
        if s.materials[material].ior <= 0.0:
            continue
        if dot(d, vec(s.faces[face].normal)) < 0.0:
            _push(open_since, material)
        elif not _remove(open_since, material):
            _push(found, material)
    # The first to be left is the innermost.
    stack[0] = 0
    for i in range(found[0], 0, -1):
        _push(stack, found[i])
