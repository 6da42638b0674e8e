"""What a render tells whoever pulls it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .film.film import Film
from .plan import Plan

Phase = Literal["setup", "render", "done"]


@dataclass(frozen=True)
class Update:
    """The state of a render at one moment.

    ``passes``: whole passes in ``film``, which goes on changing when the render is pulled
    again; ``relative_error``, ``noise``, ``bias``: see ``Film.stated_error``; ``seconds``:
    rendering alone;
    ``setup_seconds``: building and compiling before it.
    """

    phase: Phase
    passes: int
    film: Film
    relative_error: float
    noise: float
    bias: float
    seconds: float
    setup_seconds: float
    plan: Plan
    message: str = ""
