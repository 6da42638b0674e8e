from __future__ import annotations

import io

import pytest

from photon_map import progress
from photon_map.core.film.stated_error import StatedError
from photon_map.core.settings import Settings
from photon_map.progress import ProgressDisplay, describe
from tests.fake_render import FakeFilm, FakeUpdate

FILM = FakeFilm(2, 2)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_log_gets_a_new_line_once_a_second_at_most(monkeypatch: pytest.MonkeyPatch):
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    stream = io.StringIO()
    with ProgressDisplay(stream) as display:
        for i in range(100):
            now[0] = 0.1 * i
            display.show(FakeUpdate(i // 10, FILM, seconds=0.1 * i), Settings())
    lines = stream.getvalue().splitlines()
    assert len(lines) == 10
    assert lines[0] == "render"
    assert lines[3].startswith("pass 3, 3.")


def test_nothing_is_said_twice(monkeypatch: pytest.MonkeyPatch):
    now = iter(range(100))
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(now)))
    stream = io.StringIO()
    with ProgressDisplay(stream) as display:
        for _ in range(5):
            display.show(FakeUpdate(0, FILM, message="compiling kernels"), Settings())
    assert stream.getvalue() == "compiling kernels\n"


def test_a_terminal_gets_a_bar(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("TERM", "xterm-256color")
    stream = Terminal()
    with ProgressDisplay(stream) as display:
        display.show(
            FakeUpdate(16, FILM, seconds=2.0, error=StatedError(0.25, 0.0)), Settings(passes=64)
        )
    assert "25 %" in stream.getvalue()
    assert "pass 16, 2.0 s, error 0.2500" in stream.getvalue()


def test_an_error_that_is_not_known_is_said_so():
    assert describe(FakeUpdate(1, FILM, seconds=1.0)) == "pass 1, 1.0 s, error not known yet"
