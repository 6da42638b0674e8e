"""What a render leaves to the next one of the same scene, or of a part of it."""

from __future__ import annotations

from dataclasses import fields
from threading import Event, Lock

import numpy as np
from numpy.typing import NDArray

from .focus_pass import focus_of, wants_focus, with_focus_stage
from .photon_pass import Batch, PhotonSource
from .photons.focus import Focus
from .photons.trace import Walk
from .plan import Plan
from .prepared import Prepared, prepare, with_camera
from .scene.alike import alike
from .scene.scene import Scene
from .settings import Settings
from .steps import Steps

#: Photons are kept up to so much memory [bytes]; later passes trace them again.
MOST_BYTES = 1 << 28

#: All that photons hang on.
_BUT_CAMERA = tuple(
    field.name for field in fields(Scene) if field.name not in ("camera", "name")
)


class _Known:
    """What is known of one scene.

    Work of a render that was cancelled may go on for a moment: what it finds belongs to its
    own scene.
    """

    def __init__(self, scene: Scene, prepared: Prepared) -> None:
        self.scene, self.prepared = scene, prepared
        self.walks: dict[tuple[object, ...], Walk] = {}
        self.pilots: dict[tuple[object, ...], NDArray[np.float64]] = {}
        self.focus: dict[tuple[object, ...], Focus] = {}
        self.nbytes = 0


class Kept:
    """The mesh in Embree, the lights and the photons: they do not hang on the camera.

    Hand the same one to every ``render`` of a scene that changes. All of it serves a scene
    that differs in its camera alone, the mesh one that has the same faces. Results stay the
    same, bit for bit. One render at a time may use it, but for those that were cancelled.
    """

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self.most_bytes = most_bytes
        #: What the present render leaves of it.
        self.room = most_bytes
        self._known: _Known | None = None
        self._stop = Event()
        self._lock = Lock()

    @property
    def nbytes(self) -> int:
        """Memory of the photons."""
        return self._known.nbytes if self._known is not None else 0

    def cancel(self) -> None:
        """Have the present render end with ``CancelledError`` at its next ray.

        From any thread: closing its iterator takes until the next update.
        """
        self._stop.set()

    def prepare(self, scene: Scene, settings: Settings, stop: Event) -> Prepared:
        """As ``prepared.prepare``, from what is known of ``scene``."""
        with self._lock:
            self._stop, known = stop, self._known
        if known is not None and alike(known.scene, scene, _BUT_CAMERA):
            return with_camera(known.prepared, scene, settings, stop)
        like = (known.scene, known.prepared) if known is not None else None
        known = _Known(scene, prepare(scene, settings, stop, like))
        with self._lock:  # else what a cancelled render finds late would hide the next one's
            if not stop.is_set():
                self._known = known
        return known.prepared

    def focused(
        self, prepared: Prepared, settings: Settings, plan: Plan
    ) -> Steps[tuple[Prepared, Plan, dict[Batch, Walk]]]:
        """``prepared`` with the places where photons crowd, and the plan that tells of them.

        As they are where nobody asks for them. The pilot's walks that have just been traced
        come third.
        """
        walks: dict[Batch, Walk] = {}
        if not wants_focus(settings, plan):
            return prepared, plan, walks
        caustics = plan.is_on("caustics")
        key = (settings.seed, settings.photon_depth, caustics)
        known = self._known
        if known is not None and known.prepared.lights is not prepared.lights:
            known = None
        found = known.focus.get(key) if known is not None else None
        if found is None:
            found, walks = yield from focus_of(prepared, settings, caustics)
            if known is not None:
                known.focus[key] = found
        return prepared._replace(focus=found), with_focus_stage(plan, found), walks

    def leave(self, room: int) -> None:
        """Keep no more than ``room`` bytes of photons from now on."""
        self.room = max(0, min(self.most_bytes, room))
        known = self._known
        if known is not None and known.nbytes > self.room:
            known.walks.clear()
            known.pilots.clear()
            known.nbytes = 0

    def photons(self, source: PhotonSource, settings: Settings) -> PhotonSource:
        """``source``, asked only for what is not in memory, if it serves other cameras."""
        if source.learnt or self._known is None:
            return source
        return _KeptPhotons(self, self._known, source, settings)

    def has_room(self, known: _Known, nbytes: int) -> bool:
        """Whether ``nbytes`` of photons may be kept; they are counted then."""
        with self._lock:
            fits = known.nbytes + nbytes <= self.room
            if fits:
                known.nbytes += nbytes
        return fits


class _KeptPhotons:
    """The photons of ``source`` by way of ``kept``."""

    def __init__(
        self, kept: Kept, known: _Known, source: PhotonSource, settings: Settings
    ) -> None:
        self._kept, self._known = kept, known
        self._source = source
        # What photons hang on, beside the scene.
        told = (settings.photon_maps, source.focused)
        self._key: tuple[object, ...] = (settings.seed, settings.photon_depth, *told)
        self.batches = source.batches
        self.focused, self.learnt = source.focused, source.learnt
        self.seed = source.seed
        self.passes = source.passes

    def walk(self, i: int, batch: Batch) -> Walk:
        """What ``batch`` of pass ``i`` left, from memory where it has been asked for before."""
        key = (*self._key, i, batch)
        found = self._known.walks.get(key)
        if found is None:
            found = self._source.walk(i, batch)
            if self._kept.has_room(self._known, found.photons.nbytes):
                self._known.walks[key] = found
        return found

    def pilot(self) -> NDArray[np.float64]:
        """Positions (P, 3) of the pilot's global photons, from memory as well."""
        key = (*self._key, *self.batches)
        found = self._known.pilots.get(key)
        if found is None:
            found = self._source.pilot()
            if self._kept.has_room(self._known, found.nbytes):
                self._known.pilots[key] = found
        return found
