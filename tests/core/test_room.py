"""The arrays that threads work in: what is kept, and that nobody reads what is left in them."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from photon_map.core import Settings, render
from photon_map.core.camera_pass import chunk
from photon_map.core.room import ROOM, Room
from photon_map.tests import scenes


def test_rows_that_are_kept_stay_when_it_grows():
    room = Room()
    first = room.take("a", 4, "f8", 3)
    first[:] = np.arange(12).reshape(4, 3)
    assert np.shares_memory(first, room.take("a", 2, "f8", 3))
    grown = room.take("a", 1000, "f8", 3, kept=4)
    np.testing.assert_array_equal(grown[:4], first)
    assert grown.shape == (1000, 3) and room.take("a", 0, "i4").shape == (0,)


def test_threads_do_not_share_it():
    mine = ROOM.take("a", 10, "f8")
    theirs = []
    thread = threading.Thread(target=lambda: theirs.append(ROOM.take("a", 10, "f8")))
    thread.start()
    thread.join()
    assert not np.shares_memory(mine, theirs[0])


@pytest.mark.parametrize("dirt", [0x00, 0xFF, 0x7F])
def test_nobody_reads_what_is_left_there(dirt, monkeypatch):
    """0xFF is NaN and -1, 0x7F very large."""
    scene = scenes.cornell_glass()
    settings = Settings(passes=2, seed=3, threads=1, chunk_size=100, gather_rays=2)

    def film():
        *_, update = render(scene, settings)
        return update.film.resolve("combined"), update.film.resolve("indirect")

    clean = film()
    traced = chunk.trace_camera
    used = []

    def after_others(*arguments):
        for array in ROOM.arrays.values():
            array[:] = dirt
        used.append(len(ROOM.arrays))
        return traced(*arguments)

    monkeypatch.setattr(chunk, "trace_camera", after_others)
    for one, other in zip(clean, film(), strict=True):
        np.testing.assert_array_equal(one, other)
    assert max(used) >= 9, "the test would see nothing"
