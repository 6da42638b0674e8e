"""Rays under way, and the places that they leave to be lit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bsdf.hit import HIT
from ..prepared import Prepared
from ..room import ROOM
from .records import PATH


class Rays:
    """Buffers of the rays under way: the thread's, so for one set of rays at a time."""

    def __init__(self, prepared: Prepared, count: int) -> None:
        self.origins = ROOM.take("origins", count, "f4", 3)
        self.directions = ROOM.take("directions", count, "f4", 3)
        self.paths = ROOM.take("paths", count, PATH)
        self.hits = np.zeros(1, HIT)
        self.lobes = prepared.lobe_room(count)
        self.traced = 0


class Lit(NamedTuple):
    """Vertices that paths left, ``VERTEX`` rows, and the table that holds their lobes.

    They lie in the thread's room: until the next camera paths, or gather paths, are followed.
    """

    vertices: NDArray[np.void]
    lobes: NDArray[np.void]
