"""The kernel cache: an edit anywhere in the core must be seen, wherever it is called from."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import textwrap
import threading
from concurrent.futures import CancelledError, ThreadPoolExecutor

import numpy as np
import pytest
from numba import njit
from numba.core import event

from photon_map.core import jit
from photon_map.core.jit import fingerprint, kernel, obey
from photon_map.core.kernel_library import Task


@pytest.fixture(autouse=True)
def _nothing_kept(tmp_path, monkeypatch):
    """What the tests define is compiled in each of them, also where they ran before."""
    folder = tmp_path / "nothing_kept"
    monkeypatch.setattr(jit, "cache_folder", lambda: str(folder))


def run(folder, cache):
    """Run the small package with a kernel cache of its own; its printed result."""
    code = textwrap.dedent(
        f"""
        import os, sys
        os.environ["PHOTON_MAP_CACHE_DIR"] = {str(cache)!r}
        sys.path.insert(0, {str(folder)!r})
        from pathlib import Path
        from photon_map.core import jit
        own = jit.fingerprint
        jit.fingerprint = lambda folder=None: own(Path({str(folder)!r}))
        import caller
        print(caller.twice(5.0))
        """
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=True
    )
    return float(done.stdout)


def test_an_edited_callee_is_compiled_anew(tmp_path):
    sources, cache = tmp_path / "sources", tmp_path / "cache"
    sources.mkdir()
    head = "from photon_map.core.jit import kernel\n"
    (sources / "callee.py").write_text(head + "@kernel\ndef f(x):\n    return 2.0 * x\n")
    (sources / "caller.py").write_text(
        head + "from callee import f\n@kernel\ndef twice(x):\n    return 2.0 * f(x)\n"
    )
    assert run(sources, cache) == 20
    before = sorted(path.name for path in cache.iterdir())
    assert run(sources, cache) == 20
    assert sorted(path.name for path in cache.iterdir()) == before, "the cache was not used"
    (sources / "callee.py").write_text(head + "@kernel\ndef f(x):\n    return 3.0 * x\n")
    assert run(sources, cache) == 30


def test_the_fingerprint_follows_every_source(tmp_path):
    (tmp_path / "a.py").write_text("x = 1\n")
    first = fingerprint(tmp_path)
    assert fingerprint(tmp_path) == first
    (tmp_path / "b.py").write_text("")
    assert fingerprint(tmp_path) != first


def test_only_the_first_render_has_nothing_compiled(tmp_path, monkeypatch):
    monkeypatch.setattr(jit, "cache_folder", lambda: str(tmp_path))
    assert not jit.has_compiled()
    (tmp_path / "a kernel.nbi").touch()
    assert not jit.has_compiled()
    jit.set_compiled()
    assert jit.has_compiled()


def test_a_cache_that_cannot_be_written_stops_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(jit, "cache_folder", lambda: str(tmp_path / "missing"))
    jit.set_compiled()
    assert not jit.has_compiled()


@kernel
def _doubled(x):
    return 2.0 * x


@kernel
def _two_of(vector, k):
    return _doubled(vector[0]) + _doubled(vector[1]) + k


@kernel
def _larger(vector, k):
    return max(_two_of(vector, k), 0.0)


def test_one_version_of_a_callee_serves_constants_and_short_integers():
    def calls(callee):
        def both(short):
            return callee((1.0, 2.0), 3) + callee((1.0, 2.0), short)

        return both

    assert kernel(calls(_two_of))(np.int32(4)) == 6 + 3 + 6 + 4
    assert [str(kinds[1]) for kinds in _two_of.overloads] == ["int64"]


def test_a_kernel_is_called_by_python_kernels_and_plain_numba_alike():
    assert _two_of((1.0, 2.0), 1) == 7

    @njit
    def plain(v):
        return _larger(v, 1)

    assert plain((1.0, 2.0)) == 7
    # What only kernels call has no machine code of its own.
    assert not _doubled._wholes
    assert _doubled(2.0) == 4


@kernel
def _long(a, b, x):
    """Too long to be taken in, so that calls of it stay calls."""
    s = 0.0
    for k in range(int(b)):
        s += math.sin(x * k) / (1.0 + k)
        if s > a:
            s -= math.cos(x + a) * math.exp(-x) * math.log(2 + k * x)
        for j in range(k):
            s += math.sqrt(abs(s * j)) * 1e-3
            if s > 10 * b:
                s = math.atan2(s, x + j)
    for j in range(int(a)):
        s += math.sqrt(abs(s * j)) * 1e-3
        if s > b:
            s = math.atan2(s, x + j)
        s += math.sin(x * j) / (1.0 + j)
        if s > a:
            s -= math.cos(x + a) * math.exp(-x) * math.log(2 + j * x)
    return s


def test_what_a_kernel_makes_of_its_parts_is_its_own():
    @kernel
    def same_numbers(x):
        return _long(5.0, 3.0, x) + _long(5.0, 3.0, 2 * x) + _long(5.0, 3.0, x * x)

    @njit
    def others(x):
        return _long(1.0, 2.0, x) + _long(7.0, 1.0, x) + _long(2.0, 2.0, x * x)

    # It knows that two of the arguments are 5 and 3, and drops them.
    assert same_numbers(0.5) == pytest.approx(same_numbers.py_func(0.5), rel=1e-12)
    assert others(0.5) == pytest.approx(others.py_func(0.5), rel=1e-12)


def test_only_what_python_calls_is_written_to_the_cache(tmp_path):
    sources, cache = tmp_path / "sources", tmp_path / "cache"
    sources.mkdir()
    head = "from photon_map.core.jit import kernel\n"
    (sources / "callee.py").write_text(head + "@kernel\ndef f(x):\n    return 2.0 * x\n")
    (sources / "caller.py").write_text(
        head + "from callee import f\n@kernel\ndef twice(x):\n    return 2.0 * f(x)\n"
    )
    run(sources, cache)
    assert [path.name.split(".")[1] for path in cache.rglob("*.nbc")] == ["twice-3"]


def test_each_compiled_function_is_told():
    @kernel
    def inner(x):
        return x + 1

    @kernel
    def outer(x):
        return inner(x) + 1

    with event.install_recorder("numba:compile") as recorder:
        outer(1)
    told = [e.data["dispatcher"] for _, e in recorder.buffer if e.is_start]
    assert told == [outer, inner]


def test_a_cancelled_render_compiles_no_further_kernel():
    """Else Blender would wait for all of them when it is left during the first render."""
    stop = threading.Event()

    @kernel
    def known(x):
        return x + 1.0

    @kernel
    def unknown(x):
        return x + 2.0

    with ThreadPoolExecutor(1, "jit", obey, (stop,)) as pool:
        assert pool.submit(known, 1.0).result() == 2.0
        stop.set()
        with pytest.raises(CancelledError):
            pool.submit(unknown, 1.0).result()
        assert not unknown._wholes
        assert pool.submit(known, 1.0).result() == 2.0, "what is there can be called"
    assert unknown(1.0) == 3.0, "other threads may go on"


def test_other_threads_compile_while_machine_code_is_made(monkeypatch):
    @kernel
    def first(x):
        return _doubled(x) + 1.0

    @kernel
    def second(x):
        return _doubled(x) + 2.0

    make, seen = Task.run, []

    def run(task):
        if not seen:
            seen.append(None)
            with ThreadPoolExecutor(1) as pool:
                seen[0] = pool.submit(second, 1.0).result(timeout=60)
        make(task)

    monkeypatch.setattr(Task, "run", run)
    assert first(1.0) == 3.0
    assert seen == [4.0]


def test_two_threads_that_want_a_kernel_compile_it_once():
    @kernel
    def wanted(x):
        return _doubled(x) + 3.0

    with event.install_recorder("numba:compile") as recorder:
        with ThreadPoolExecutor(4) as pool:
            assert list(pool.map(wanted, [1.0] * 8)) == [5.0] * 8
    assert sum(e.is_start for _, e in recorder.buffer) == 1


def test_constants_mean_what_they_mean_to_numba():
    """What calls mean is remembered, and constant numbers count as any, but for powers."""

    def calculated(x, k, pair, rows):
        third = (x, 3, x + 1)[2]
        rows[0, 1] = rows[1, 0] + pair[1]
        for j in range(2, 8, k):
            third += x**2 + x**-3 + x**k + 7 % 4 + k // 2 + 5 / 2 + pow(2, k) + pow(x, 3)
            third += max(k, 1) + min(x, 2) + abs(-3) + int(2.7) + rows[j % 2, 1]
        return third + (k < 3) + (1 if 2 == k else 0) + math.hypot(3, 4) + round(x)

    rows = [np.arange(4.0).reshape(2, 2) for _ in range(2)]
    told = (1.5, 2, (4, 2.5))
    assert kernel(calculated)(*told, rows[0]) == calculated(*told, rows[1])
    assert (rows[0] == rows[1]).all()


def test_kernels_raise_also_when_they_come_from_the_cache(tmp_path):
    sources, cache = tmp_path / "sources", tmp_path / "cache"
    sources.mkdir()
    (sources / "caller.py").write_text(
        """
from photon_map.core.jit import allocating_kernel, kernel
import numpy as np

@kernel
def checked(x):
    if x < 0.0:
        raise ValueError("below nothing")
    return 2.0 * x

@kernel
def told(x):
    return checked(x) + 1.0

@allocating_kernel
def summed(x):
    return np.full(3, checked(x)).sum()

def twice(x):
    for one in (told, summed):
        try:
            one(-x)
        except ValueError as error:
            assert "below nothing" in str(error)
        else:
            raise AssertionError
    return told(x) + summed(x)
"""
    )
    assert run(sources, cache) == 41
    assert run(sources, cache) == 41


def test_a_kernel_given_up_is_collected_in_any_order(tmp_path):
    """Finalizers of cyclic garbage have no order: LLVM's modules may not outlive their context.

    Blender 5.2 crashed in one that was freed after it.
    """
    script = tmp_path / "given_up.py"
    script.write_text("""
import gc
from photon_map.core.jit import kernel
from photon_map.core.kernel_library import Task

make = Task.__init__

def in_a_cycle(task, whole):
    make(task, whole)
    task.itself = task

Task.__init__ = in_a_cycle
gc.disable()
def adding(k):
    @kernel
    def given_up(x):
        return x + k
    return given_up

for k in range(20):
    assert adding(k)(1.0) == 1.0 + k
assert gc.collect() > 0
print("alive")
""")
    done = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, timeout=120,
        env={**os.environ, "PHOTON_MAP_CACHE_DIR": str(tmp_path / "kept")},
    )  # fmt: skip
    assert done.stdout == "alive\n", (done.returncode, done.stderr)
