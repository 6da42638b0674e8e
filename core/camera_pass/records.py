"""The rows that travel through a camera pass: paths under way and where they stopped."""

from __future__ import annotations

import numpy as np

from ..geometry.media import STACK

REFLECTED, REFRACTED = 1, -1

_MEDIA = [("media_count", "i4"), ("media", "i4", STACK)]

#: A camera path on a chain of narrow scattering. ``slot``: its row among the chunk's samples;
#: ``number``: which of its pixel's paths it is, see ``Pixels``;
#: ``event``: ``Visibility`` bit of its last event; ``length``: way from the lens [m],
#: ``begun`` where the chain began; ``depth``: events so far; ``steps``: surfaces so far, those
#: it went straight through included; ``reach``: how far a camera ray sees [m]. ``origin``,
#: ``normal``: its last event, ``since`` the way from there [m], ``pdf_w`` the density of its
#: direction where light sampling was the other technique, else 0. ``lobe_start`` and
#: ``lobe_count``: the lobes of the surface that it is on. ``forced``: what it does at the next
#: event where that was split (``tree``), 0 for what chance says; ``portion``: the part of the
#: path that it is, and of the gather rays that it may send.
PATH = np.dtype(
    [
        ("key", "u8"),
        ("pixel_key", "u8"),
        ("slot", "i4"),
        ("number", "i4"),
        ("depth", "i4"),
        ("steps", "i4"),
        ("event", "i4"),
        ("forced", "i4"),
        ("portion", "f8"),
        ("beta", "f8", 3),
        ("direction", "f8", 3),
        ("length", "f8"),
        ("begun", "f8"),
        ("reach", "f8"),
        ("origin", "f8", 3),
        ("normal", "f8", 3),
        ("since", "f8"),
        ("pdf_w", "f8"),
        ("lobe_start", "i4"),
        ("lobe_count", "i4"),
        *_MEDIA,
    ],
    align=True,
)

#: A vertex that is lit. ``part``: WIDE at the end of a chain, where photons are gathered
#: too, NARROW where the chain goes on. ``row``: material, ``lobe_start`` and ``lobe_count``:
#: its lobes there; ``way`` from where its chain began [m]; ``offset`` and ``entering``: see
#: ``interact``; ``number`` and ``portion``: its path's.
VERTEX = np.dtype(
    [
        ("key", "u8"),
        ("pixel_key", "u8"),
        ("slot", "i4"),
        ("number", "i4"),
        ("depth", "i4"),
        ("part", "i4"),
        ("row", "i4"),
        ("lobe_start", "i4"),
        ("lobe_count", "i4"),
        ("entering", "i4"),
        ("portion", "f8"),
        ("offset", "f8"),
        ("length", "f8"),
        ("way", "f8"),
        ("p", "f8", 3),
        ("ng", "f8", 3),
        ("ns", "f8", 3),
        ("wo", "f8", 3),
        ("beta", "f8", 3),
        *_MEDIA,
    ],
    align=True,
)

# Dimensions of a camera path's stream.
FILTER = 0
LENS = 2
LIGHT = 4
LIGHT_POINT = 6
GATHER = 8
CHAIN = 16
CHAIN_STEP = 8
GATHER_LOBE = 1 << 20
GATHER_STEP = 1
GATHER_NUMBER = 1 << 21
THIN = GATHER_NUMBER + 1
SPLIT = 1 << 22
# Within a step of a chain: stop or go on (a pair), lobe, event, and going straight through.
STEP_LOBE = 1
STEP_EVENT = 2
STEP_AROUND = 3
STEP_PASS = 4
