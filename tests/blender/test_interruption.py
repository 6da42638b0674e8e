"""What the user's break does between two updates of the core."""

from __future__ import annotations

import threading
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any

import pytest

from tests.blender.support import headless_render, read_exr, save_exr


class Kept:
    """Tells when it is cancelled."""

    def __init__(self) -> None:
        self.cancelled = threading.Event()

    def cancel(self) -> None:
        self.cancelled.set()


@pytest.mark.parametrize("breaks", [False, True])
def test_a_render_is_cancelled_when_its_user_breaks_it(breaks: bool) -> None:
    from photon_map.addon.interruption import interrupting

    kept, looks, looked = Kept(), [], threading.Event()

    def wanted() -> bool:
        looks.append(threading.current_thread().name)
        if len(looks) == 3:
            looked.set()
        return breaks and len(looks) == 3

    with interrupting(wanted, kept):  # type: ignore[arg-type]
        assert looked.wait(20)
        if breaks:
            assert kept.cancelled.wait(20)
    assert kept.cancelled.is_set() == breaks
    count = len(looks)
    assert set(looks) == {"photon_map_break"}
    assert "photon_map_break" not in [thread.name for thread in threading.enumerate()]
    assert len(looks) == count and (count == 3 or not breaks)


@pytest.mark.parametrize("wanted", [False, True])
def test_what_was_cancelled_between_updates_keeps_its_picture(
    bpy: Any, core: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wanted: bool
) -> None:
    """Where nobody wanted it, the same is an error."""
    from photon_map.addon import final

    bpy.context.scene.photon_map.passes = 1000
    over: list[int] = []

    def on_pass(number: int) -> None:
        if number == 3:
            over.append(number)
            raise CancelledError

    core.on_pass = on_pass
    monkeypatch.setattr(final, "stopped", lambda engine: wanted and bool(over))
    save_exr(bpy, tmp_path / "a.exr")
    if not wanted:
        with pytest.raises(RuntimeError):
            headless_render(bpy)
        assert list(tmp_path.iterdir()) == []
        return
    job = headless_render(bpy)
    assert core.closed == 1 and job.update.passes == 2
    assert read_exr(tmp_path / "a.exr")["ViewLayer.Combined"].any()
