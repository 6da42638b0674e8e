"""The rows that travel through a camera pass: paths under way and where they stopped."""

from __future__ import annotations

import numpy as np

from ..geometry.media import STACK

_MEDIA = [("media_count", "i4"), ("media", "i4", STACK)]

#: A camera path on a specular chain. ``slot``: its row among the chunk's samples; ``event``:
#: ``Visibility`` bit of its last event; ``length``: way from the lens, ``reach``:
#: how far a camera ray sees from where it starts [m]. A final-gather
#: path also knows where it left (``origin``, ``normal``) and with which ``pdf_w``.
PATH = np.dtype(
    [
        ("key", "u8"),
        ("pixel_key", "u8"),
        ("slot", "i4"),
        ("depth", "i4"),
        ("event", "i4"),
        ("beta", "f8", 3),
        ("direction", "f8", 3),
        ("length", "f8"),
        ("reach", "f8"),
        ("origin", "f8", 3),
        ("normal", "f8", 3),
        ("pdf_w", "f8"),
        *_MEDIA,
    ],
    align=True,
)

#: A non-specular vertex: the end of a chain. ``row``: material; ``offset``: see ``interact``.
VERTEX = np.dtype(
    [
        ("key", "u8"),
        ("pixel_key", "u8"),
        ("slot", "i4"),
        ("depth", "i4"),
        ("row", "i4"),
        ("offset", "f8"),
        ("length", "f8"),
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
CHAIN_STEP = 4
GATHER_LOBE = 1 << 20
GATHER_STEP = 1
