"""How wrong an image says that it is."""

from __future__ import annotations

import math
from typing import NamedTuple


class StatedError(NamedTuple):
    """Noise and bias of an image, each as the square root of its part of the relMSE.

    ``noise`` is infinite as long as it is not known.
    """

    noise: float
    bias: float

    @property
    def relative_error(self) -> float:
        """Both together: 0.1 means 10 % in a typical pixel."""
        return math.hypot(self.noise, self.bias)


#: Before the second pass.
UNKNOWN = StatedError(math.inf, 0.0)
