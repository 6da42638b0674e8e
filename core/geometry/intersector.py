"""Ray queries in batches through Embree (embreex)."""

from __future__ import annotations

import ctypes
from concurrent.futures import CancelledError
from copy import copy
from functools import cache
from importlib import metadata
from threading import Event
from typing import NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore import EmbreeDevice
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

from .mesh import Mesh


def check_version(version: str) -> None:
    """Raise ``ImportError`` for embreex 2, which pip falls back to where it finds no wheel.

    It holds the GIL during queries and its intersections are not robust.
    """
    major, minor = (int(part) for part in version.split(".")[:2])
    if (major, minor) < (4, 4):
        raise ImportError(
            f"embreex {version} is too old, Photon Map needs 4.4 or newer: pip install "
            "'embreex>=4.4' (there are wheels for 64-bit Linux, Windows and macOS)"
        )


@cache
def device() -> EmbreeDevice:
    """Embree for all scenes, to the end of the process.

    A scene that is freed tells its device so. With a device of its own, Python's collector
    frees that first where the scene is in a cycle (the traceback of a cancelled render is
    one): Blender 5.2 crashed.
    """
    made = EmbreeDevice()
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(made))
    return made


class Hits(NamedTuple):
    """Nearest hits: face (N,) i4, -1 = none; u, v (N,) f4 barycentrics of corners 1, 2."""

    face: NDArray[np.int32]
    u: NDArray[np.float32]
    v: NDArray[np.float32]


class Intersector:
    """Embree over one merged mesh; queries release the GIL and may run in many threads.

    Once ``stop`` is set every query raises ``CancelledError``: all work on rays comes by
    here, so a cancelled render ends within one step of one chunk.
    """

    def __init__(self, mesh: Mesh, stop: Event | None = None) -> None:
        check_version(metadata.version("embreex"))
        self._stop = stop or Event()
        self._scene = None
        if len(mesh.faces):
            self._scene = EmbreeScene(device())
            TriangleMesh(self._scene, mesh.vertices, mesh.faces)
            # The scene commits inside the first query: it must not happen in two threads.
            probe = np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32)
            self._scene.run(*probe, query="INTERSECT", output=1)

    def stopped_by(self, stop: Event | None) -> Intersector:
        """The same tree of the same mesh, whose queries end by another ``stop``."""
        other = copy(self)
        other._stop = stop or Event()
        return other

    def go_on(self) -> None:
        """Raise ``CancelledError`` once the render is stopped, for long work between rays."""
        if self._stop.is_set():
            raise CancelledError

    def nearest(self, origins: NDArray[np.float32], directions: NDArray[np.float32]) -> Hits:
        """First hit of each ray; origins and directions (N, 3) f4, any length."""
        self.go_on()
        count = len(origins)
        if self._scene is None or count == 0:
            nothing = np.zeros(count, np.float32)
            return Hits(np.full(count, -1, np.int32), nothing, nothing)
        found = self._scene.run(origins, directions, query="INTERSECT", output=1)
        return Hits(found["primID"], found["u"], found["v"])

    def is_free(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        lengths: NDArray[np.float32],
    ) -> NDArray[np.bool_]:
        """Whether nothing lies between origin and origin + length * direction.

        ``lengths`` (N,) f4, in multiples of the direction; its content is lost.
        """
        self.go_on()
        if self._scene is None or len(origins) == 0:
            return np.ones(len(origins), np.bool_)
        found = self._scene.run(origins, directions, lengths, query="OCCLUDED")
        free: NDArray[np.bool_] = found != 0
        return free
