"""Points, paths and rings of photons as arrays; loaded with the first of them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .look import LOOK, Picked

#: Points stand this much off their surface, in radii of the scene, so as to be seen.
_OFF = 1e-3
_CORNERS = 64
_ALPHA = 0.7


class Cloud(NamedTuple):
    """What is drawn: points (N, 3) and colours (N, 4), segments (2S, 3) and theirs, rings."""

    points: NDArray[np.float32]
    shades: NDArray[np.float32]
    ends: NDArray[np.float32]
    end_shades: NDArray[np.float32]
    rings: list[NDArray[np.float32]]
    words: list[tuple[str, tuple[float, float, float]]]


def cloud_of(own: Any) -> Cloud | None:
    """What ``LOOK`` has to draw by the choices in ``own``; None when there is nothing."""
    if LOOK.viewed is None:
        return None
    from ...core import photon_colours, photon_legend, power_scale

    view, size = LOOK.viewed.view, LOOK.viewed.size
    shades = photon_colours(view, own.colour)
    shown = np.ones(len(shades), np.bool_)
    if own.kind != "ALL":
        shown = view.caustic == (own.kind == "CAUSTIC")
    if own.colour == "power":
        words = [(f"{watt:.2g} W", shade) for watt, shade in power_scale(view)]
    else:
        legend = photon_legend(view.only(shown), own.colour)[:10]
        words = [(f"{entry.name}: {entry.number}", entry.colour) for entry in legend]
    ends, end_shades = np.zeros((0, 3)), np.zeros((0, 3))
    rings: list[NDArray[np.float32]] = []
    if LOOK.picked is not None:
        rings = [ring(disc, _OFF * size) for disc in LOOK.picked.discs]
        if own.paths:
            ends, end_shades = segments(LOOK.picked, shades, shown)
    lifted = view.position + _OFF * size * view.normal
    return Cloud(
        points=lifted[shown].astype(np.float32),
        shades=with_alpha(shades[shown], 1.0),
        ends=ends.astype(np.float32),
        end_shades=with_alpha(end_shades, _ALPHA),
        rings=rings,
        words=words,
    )


def with_alpha(shades: NDArray[np.float64], alpha: float) -> NDArray[np.float32]:
    """Colours (N, 3) with how much of them is seen, (N, 4)."""
    return np.column_stack([shades, np.full(len(shades), alpha)]).astype(np.float32)


def segments(
    picked: Picked, shades: NDArray[np.float64], shown: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Ends (2S, 3) of all pieces of the paths of ``shown`` photons, and their colours."""
    ends, colours = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for row, path in zip(picked.rows, picked.paths, strict=True):
        if shown[row] and len(path) > 1:
            pieces = np.repeat(path, 2, axis=0)[1:-1]
            ends.append(pieces)
            colours.append(np.broadcast_to(shades[row], pieces.shape))
    return np.concatenate(ends), np.concatenate(colours)


def ring(disc: Any, off: float) -> NDArray[np.float32]:
    """The rim of a gather disc (C, 3), its first point again at the end."""
    normal = disc.place.normal
    aside = np.cross(normal, np.eye(3)[np.argmin(abs(normal))])
    aside /= np.linalg.norm(aside)
    turn = np.linspace(0, 2 * np.pi, _CORNERS + 1)[:, None]
    rim = np.cos(turn) * aside + np.sin(turn) * np.cross(normal, aside)
    place = disc.place.position + off * normal
    return np.asarray(place + disc.radius * rim, np.float32)
