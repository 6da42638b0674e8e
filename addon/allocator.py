"""Memory that renders have freed, given back to the system.

Allocators keep what is freed for whoever asks next, as much of it as a render's threads have
used at a time: 300 MB after one of 640x480 in Blender 5.2.
"""

from __future__ import annotations

import ctypes
import sys

#: `TBBMALLOC_CLEAN_ALL_BUFFERS` of `scalable_allocation_command`.
_ALL_BUFFERS = 0
#: All arenas, for `mallctl` of jemalloc.
_ALL_ARENAS = b"arena.4096.purge"


def give_back() -> tuple[str, ...]:
    """Have allocators return what is free; their names, none where nobody knows them.

    From any thread, in about 20 ms. Blender is linked with TBB's, with jemalloc or with none
    and then has glibc's; its module has glibc's and brings TBB's along. Windows and Macs keep
    theirs in other places.
    """
    if not sys.platform.startswith("linux"):
        return ()
    library = ctypes.CDLL(None)
    asked = []
    if hasattr(library, "scalable_allocation_command"):
        library.scalable_allocation_command(_ALL_BUFFERS, None)
        asked.append("TBB")
    if hasattr(library, "mallctl"):
        library.mallctl(b"thread.tcache.flush", None, None, None, 0)
        library.mallctl(_ALL_ARENAS, None, None, None, 0)
        asked.append("jemalloc")
    if hasattr(library, "malloc_trim"):
        library.malloc_trim(0)
        asked.append("glibc")
    return tuple(asked)
