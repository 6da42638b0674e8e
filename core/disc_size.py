"""How large the discs of caustics are, by what the film says of its noise and its bias.

Noise of caustics falls as the inverse square of a disc's radius, its squared bias grows as the
fourth power, so that their sum is least where the noise is twice the squared bias (Silverman
1986, section 4.3; for photons Hachisuka et al. 2010 and Kaplanyan & Dachsbacher 2013 choose
radii by both). Where a caustic has fine lines the discs of the pilot are too large, and the
shrinking of all progressive methods keeps noise and bias in the same proportion for ever.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .settings import AUTOMATIC, Settings

if TYPE_CHECKING:
    from .film.film import Film

#: Passes before the first look at the film; another follows at each doubling.
FIRST = 8
#: Passes after a look that still have discs of the size before, as they are under way.
LAG = 4
#: All looks together may change the radius to these factors.
LEAST, MOST = 0.5, 1.0
#: Squared bias at edges of light, where discs do harm, over what the film states (``film``).
EDGES = 2.0
#: As in the stated error: dark pixels count by this part of the mean's square.
_DARK = 0.01


def sizes_discs(settings: Settings) -> bool:
    """Whether a render chooses for itself: not where numbers or sizes are set by hand."""
    return (
        AUTOMATIC == settings.gather_rays == settings.photons_caustic and settings.alpha < 1.0
    )


class DiscSize:
    """The factor on the radius of the pilot's discs for each pass, 1 unless it is ``free``.

    It hangs on films of whole passes alone, at fixed passes, and so not on threads.
    """

    def __init__(self, free: bool) -> None:
        self._free = free
        #: Passes from which on a factor holds, and the factor.
        self._held = [(0, 1.0)]

    def look(self, i: int, film: Film) -> None:
        """Before pass ``i``, when ``film`` has those before it."""
        if self._free and i >= FIRST and i & (i - 1) == 0:
            # What the film says is said of all its passes: the bias goes with the square.
            so_far = float(np.sqrt(np.mean([self.factor(k) ** 2 for k in range(i)])))
            wanted = float(np.clip(so_far * better_size(film), LEAST, MOST))
            self._held.append((i + LAG, wanted))

    def factor(self, i: int) -> float:
        """On the radius of the pilot's discs in pass ``i``."""
        return next(factor for begin, factor in reversed(self._held) if i >= begin)


def better_size(film: Film) -> float:
    """Factor on the radius of caustics' discs that would make the least error; 1 in doubt."""
    lost = film.stated_error().bias ** 2
    whole, light = film.scatter_of_paths(1.0)
    others, _ = film.scatter_of_paths(0.0)
    weight = light**2 + _DARK * float(light.mean()) ** 2 + 1e-300
    noise = float(((whole - others) / weight).mean()) / film.passes
    if not (lost > 0.0 and noise > 0.0):
        return 1.0
    return float((noise / (2.0 * EDGES * lost)) ** (1.0 / 6.0))
