"""Memory of renders goes back to the system once nobody needs it."""

from __future__ import annotations

import threading
import weakref
from typing import Any

import pytest

from tests.blender.support import add_cube, headless_render


@pytest.fixture
def asked(bpy: Any, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Grows when the allocator is asked to give back what is free."""
    if bpy is None:
        return []
    from photon_map.addon import allocator

    times: list[int] = []
    monkeypatch.setattr(allocator, "give_back", lambda: times.append(1))
    return times


def test_after_a_final_render(bpy: Any, core: Any, asked: list[int]) -> None:
    """When its film is free."""
    add_cube(bpy, "Cube")
    headless_render(bpy)
    assert core.closed == len(asked) == 1


def test_after_a_view_is_closed_and_its_worker_has_ended(bpy: Any, asked: list[int]) -> None:
    from photon_map.addon.engine import WATCH, watch
    from photon_map.addon.viewport import ViewportRender
    from photon_map.addon.worker import Picture

    class Engine:
        def tag_redraw(self) -> None:
            pass

    engine, go_on, view = Engine(), threading.Event(), ViewportRender()
    kept = [weakref.ref(view._kept), weakref.ref(view._memory)]
    look = watch(weakref.ref(engine), view)  # type: ignore[arg-type]
    worker: Any = threading.Thread(target=go_on.wait)
    worker.cancel, worker.picture = lambda: None, Picture(None, "")
    worker.start()
    view._worker = worker
    assert look() == WATCH and not asked
    view.close()
    del engine
    assert look() == WATCH and not asked and all(ref() is not None for ref in kept)
    go_on.set()
    worker.join()
    assert look() is None and len(asked) == 1
    assert all(ref() is None for ref in kept)
