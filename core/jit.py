"""Compiles the kernels and keeps them in a cache that edits cannot make stale.

Numba checks a cached kernel against its own file only, so a kernel would keep an old
version of a function that it calls from another file. The cache folder is therefore named
by a fingerprint of every core source, the versions and the processor.
"""

from __future__ import annotations

import hashlib
import os
import platform
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import numba
import numpy as np
from llvmlite import binding
from numpy.typing import NDArray

from .kernel_dispatcher import KernelDispatcher
from .kernel_dispatcher import obey as obey

#: Kernel arguments: a structured array or plain array, and one row or named tuple of them.
#: NumPy's types cannot name the fields of a structured array.
Table: TypeAlias = NDArray[Any]
Row: TypeAlias = Any

#: A file in the cache folder.
_COMPILED = "compiled"
_KEEP_SECONDS = 14 * 24 * 3600.0


def cache_root() -> Path:
    """Folder of all kernel caches: ``PHOTON_MAP_CACHE_DIR``, else the user's cache folder."""
    chosen = os.environ.get("PHOTON_MAP_CACHE_DIR")
    if chosen:
        return Path(chosen)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "photon_map" / "kernels"


def fingerprint(folder: Path | None = None) -> str:
    """Hash of all sources below ``folder`` (the core), the versions and the processor."""
    root = folder or Path(__file__).parent
    digest = hashlib.sha256()
    versions = (numba.__version__, np.__version__, platform.python_version())
    digest.update(repr((versions, binding.get_host_cpu_name(), str(root))).encode())
    for source in sorted(root.rglob("*.py")):
        digest.update(source.relative_to(root).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:24]


@cache
def cache_folder() -> str:
    """This version's cache folder, made when missing; folders long unused are removed."""
    root = cache_root()
    folder = root / fingerprint()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        _remove_unused(root, folder)
    except OSError:
        # A read-only home must not stop a render: it only compiles again next time.
        return tempfile.mkdtemp(prefix="photon_map_kernels_")
    return str(folder)


def has_compiled() -> bool:
    """Whether a render has compiled all kernels that it takes, in this version."""
    return (Path(cache_folder()) / _COMPILED).exists()


def set_compiled() -> None:
    """Remember that the kernels of a render are in the cache."""
    with suppress(OSError):  # a full disk must not stop a render
        (Path(cache_folder()) / _COMPILED).touch()


def _remove_unused(root: Path, current: Path) -> None:
    limit = time.time() - _KEEP_SECONDS
    for other in root.iterdir():
        if other != current and other.is_dir() and other.stat().st_mtime < limit:
            shutil.rmtree(other, ignore_errors=True)


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile ``function`` at its first call: no GIL, cached, NaN-safe float arithmetic.

    Arrays are not counted, so a kernel cannot make any: its caller hands them in. The
    counters are atomic and shared by all threads; they took a fifth of a render's time.
    """
    return _compiled(function, _nrt=False)


def allocating_kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """As ``kernel``, for plain code that makes arrays of its own."""
    return _compiled(function)


def _compiled(function: Callable[..., Any], **options: bool) -> Callable[..., Any]:
    if numba.config.DISABLE_JIT:
        return function
    # The folder is chosen at decoration; other users of Numba keep their own setting.
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = cache_folder()
    try:
        compiled = KernelDispatcher(
            function,
            targetoptions={
                "nopython": True,
                "nogil": True,
                "error_model": "numpy",
                "boundscheck": None,
                **options,
            },
        )
        compiled.enable_caching()
    finally:
        numba.config.CACHE_DIR = before
    return compiled
