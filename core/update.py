"""What a render tells whoever pulls it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from .film.film import Film
from .film.stated_error import StatedError
from .plan import Plan

Phase = Literal["setup", "render", "done"]


@dataclass(frozen=True)
class Update:
    """The state of a render at one moment.

    ``passes``: whole passes in ``film``, which goes on changing when the render is pulled
    again; ``error``: see ``Film.stated_error``; ``seconds``: rendering alone;
    ``setup_seconds``: building and compiling before it; ``photon_bytes``: most memory that
    photon maps have taken so far, those under way included.
    """

    phase: Phase
    passes: int
    film: Film
    error: StatedError
    seconds: float
    setup_seconds: float
    plan: Plan
    message: str = ""
    photon_bytes: int = 0

    @property
    def relative_error(self) -> float:
        """The stated error, noise and bias together: 0.1 means 10 % in a typical pixel."""
        return self.error.relative_error
