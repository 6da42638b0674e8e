"""Joined work: who does the last part goes on, and no thread waits for another."""

from __future__ import annotations

import threading
from concurrent.futures import CancelledError, Future
from functools import partial

import pytest

from photon_map.core.pass_queue import PassQueue


@pytest.fixture
def stop():
    return threading.Event()


@pytest.fixture
def queue(stop):
    pool = PassQueue(2, stop)
    yield pool
    stop.set()
    pool.close(wait=True)


def test_results_are_in_the_order_of_the_parts(queue):
    """The first part ends last."""
    second = threading.Event()

    def first():
        assert second.wait(10)
        return "first"

    def other():
        second.set()
        return "second"

    assert queue.join([first, other], list).result(10) == ["first", "second"]
    assert queue.join([], list).result(10) == []


def test_a_thread_is_free_while_the_other_does_the_last_part(queue):
    """A task for what follows would hold it until the gate opens."""
    gate = threading.Event()
    joined = queue.join([partial(gate.wait, 10), partial(int, 1)], list)
    assert queue.submit(str, 5).result(10) == "5"
    assert not joined.done()
    gate.set()
    assert joined.result(10) == [True, 1]


@pytest.mark.parametrize("failing", [0, 1, 2])
def test_an_error_reaches_who_waits(queue, failing):
    def part(k):
        if k == failing:
            raise ValueError(f"part {k}")
        return k

    def then(found):
        raise ValueError("what follows")

    message = f"part {failing}" if failing < 2 else "what follows"
    with pytest.raises(ValueError, match=message):
        queue.join([partial(part, 0), partial(part, 1)], then).result(10)


def test_once_stopped_nothing_begins(queue, stop):
    stop.set()
    ran: list[int] = []
    joined: Future[list[None]] = queue.join([partial(ran.append, 1)] * 3, list)
    with pytest.raises(CancelledError):
        joined.result(10)
    assert not ran
