"""What photons are coloured by, and what the colours stand for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .photon_view import PhotonView

#: What the points of photons can be coloured by.
BY = ("power", "bounce", "caster", "light")
#: Display colours from the weakest photon to the strongest, dark to bright.
_POWERS = (
    (0.16, 0.06, 0.34), (0.45, 0.10, 0.45), (0.77, 0.20, 0.33), (0.95, 0.47, 0.12),
    (0.98, 0.79, 0.23), (1.00, 1.00, 0.78),
)  # fmt: skip
#: ... by the bounces so far.
_BOUNCES = (
    (0.95, 0.90, 0.35), (0.45, 0.85, 0.35), (0.15, 0.70, 0.60), (0.20, 0.50, 0.85),
    (0.45, 0.30, 0.85), (0.70, 0.20, 0.60), (0.55, 0.15, 0.25),
)  # fmt: skip
#: ... and of things that are told apart, and of none (-1).
_THINGS = (
    (0.26, 0.53, 0.96), (0.98, 0.60, 0.15), (0.30, 0.75, 0.35), (0.90, 0.25, 0.25),
    (0.65, 0.45, 0.90), (0.60, 0.42, 0.30), (0.95, 0.50, 0.75), (0.70, 0.72, 0.30),
    (0.25, 0.80, 0.85), (0.80, 0.80, 0.80),
)  # fmt: skip
_NONE = (0.5, 0.5, 0.5)
#: Photons that met nothing before.
DIRECT = "straight from the light"


def photon_colours(view: PhotonView, by: str) -> NDArray[np.float64]:
    """Display colours (N, 3), 0..1, by one of ``BY``.

    Power goes from dark to bright over the 2nd to 98th percentile of its logarithm.
    """
    if by == "power":
        power = _powers(view)
        low, high = _power_range(view)
        share = (power - low) / (high - low) if high > low else np.full_like(power, 0.5)
        table = np.array(_POWERS)
        place = share.clip(0, 1) * (len(table) - 1)
        steps = np.arange(len(table))
        return np.stack([np.interp(place, steps, column) for column in table.T], axis=1)
    if by == "bounce":
        return np.array(_BOUNCES)[view.bounce.clip(0, len(_BOUNCES) - 1)]
    return thing_colours(view.caster if by == "caster" else view.light)


def thing_colours(index: NDArray[np.int32]) -> NDArray[np.float64]:
    """Colours (N, 3) of lights or casters; those ten apart share one."""
    return np.where(index[:, None] >= 0, np.array(_THINGS)[index % len(_THINGS)], _NONE)


class Entry(NamedTuple):
    """What photons of a colour have in common, their number, their share of the light."""

    name: str
    number: int
    share: float
    colour: tuple[float, float, float]


def photon_legend(
    view: PhotonView, by: str, weight: NDArray[np.float64] | None = None
) -> list[Entry]:
    """What the colours of ``photon_colours`` stand for, most photons first.

    ``weight`` (N,) of a disc makes the shares those of its irradiance. Power has no things to
    tell apart: it goes by bounces, see ``power_scale``.
    """
    index: NDArray[np.int32]
    names: Sequence[str]
    if by == "caster":
        index, names = view.caster, (*view.objects, DIRECT)
    elif by == "light":
        index, names = view.light, view.lights
    else:
        index, by = view.bounce, "bounce"
        names = [f"bounce {k}" for k in range(int(index.max(initial=0)) + 1)]
    light = view.flux.astype(np.float64).mean(axis=1) * (1.0 if weight is None else weight)
    total = light.sum() or 1.0
    shades = photon_colours(view, by)
    values, first = np.unique(index, return_index=True)
    found = []
    for k, row in zip(values, first, strict=True):
        own = index == k
        red, green, blue = (float(part) for part in shades[row])
        share = float(light[own].sum() / total)
        found.append(Entry(names[int(k)], int(own.sum()), share, (red, green, blue)))
    return sorted(found, key=lambda entry: (-entry.number, entry.name))


def power_scale(view: PhotonView) -> list[tuple[float, tuple[float, float, float]]]:
    """Power [W] and colour from weak photons to strong ones."""
    if len(view.flux) == 0:
        return []
    low, high = _power_range(view)
    steps = np.exp(np.linspace(low, high, len(_POWERS)))
    return [(float(watt), shade) for watt, shade in zip(steps, _POWERS, strict=True)]


def _powers(view: PhotonView) -> NDArray[np.float64]:
    """Logarithm of each photon's power."""
    return np.log(np.maximum(view.flux.mean(axis=1).astype(np.float64), 1e-30))


def _power_range(view: PhotonView) -> tuple[float, float]:
    """Between the 2nd and the 98th percentile lie the colours."""
    low, high = np.percentile(_powers(view), (2, 98)) if len(view.flux) else (0.0, 1.0)
    return float(low), float(high)
