"""What a render leaves to the next one of the same scene from another place."""

from __future__ import annotations

from dataclasses import fields
from threading import Event, Lock

import numpy as np
from numpy.typing import NDArray

from .focus_pass import wants_focus, with_focus, with_focus_stage
from .photon_pass import Batch, PhotonSource
from .photons.focus import Focus
from .photons.trace import Walk
from .plan import Plan
from .prepared import Prepared, prepare, with_camera
from .scene.scene import Scene
from .settings import Settings

#: Photons are kept up to so much memory [bytes]; later passes trace them again.
MOST_BYTES = 1 << 28


class Kept:
    """The mesh in Embree, the lights and the photons: they do not hang on the camera.

    Hand the same one to every ``render`` of a scene that changes its camera alone (by
    ``dataclasses.replace``); another scene starts it anew. Results stay the same, bit for
    bit. One render at a time may use it.
    """

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self.most_bytes = most_bytes
        #: What the present render leaves of it.
        self.room = most_bytes
        self.nbytes = 0
        self._scene: Scene | None = None
        self._prepared: Prepared | None = None
        self._walks: dict[tuple[object, ...], Walk] = {}
        self._focus: dict[tuple[object, ...], Focus] = {}
        self._lock = Lock()

    def prepare(self, scene: Scene, settings: Settings, stop: Event) -> Prepared:
        """As ``prepared.prepare``, from what is known of ``scene``."""
        if self._prepared is not None and _differ_in_camera_alone(self._scene, scene):
            return with_camera(self._prepared, scene, settings, stop)
        self._scene, self._prepared, self.nbytes = None, None, 0
        self._walks.clear()
        self._focus.clear()
        prepared = prepare(scene, settings, stop)
        self._scene, self._prepared = scene, prepared
        return prepared

    def focused(
        self, prepared: Prepared, settings: Settings, plan: Plan
    ) -> tuple[Prepared, Plan]:
        """``prepared`` with the places where photons crowd, and the plan that tells of them.

        As they are where nobody asks for them.
        """
        if not wants_focus(settings, plan):
            return prepared, plan
        caustics = plan.is_on("caustics")
        key = (settings.seed, settings.photon_depth, caustics)
        if key not in self._focus:
            self._focus[key] = with_focus(prepared, settings, caustics).focus
        found = self._focus[key]
        return prepared._replace(focus=found), with_focus_stage(plan, found)

    def leave(self, room: int) -> None:
        """Keep no more than ``room`` bytes of photons from now on."""
        self.room = max(0, min(self.most_bytes, room))
        if self.nbytes > self.room:
            self._walks.clear()
            self.nbytes = 0

    def photons(self, source: PhotonSource, settings: Settings) -> PhotonSource:
        """``source``, asked only for what is not in memory, if it serves other cameras."""
        return source if source.learnt else _KeptPhotons(self, source, settings)

    def walk(self, source: PhotonSource, settings: Settings, i: int, batch: Batch) -> Walk:
        """As ``source.walk``, from memory where it has been asked for before."""
        told = (settings.photon_maps, source.focused)
        key = (settings.seed, settings.photon_depth, *told, i, batch)
        found = self._walks.get(key)
        if found is None:
            found = source.walk(i, batch)
            with self._lock:
                if self.nbytes + found.photons.nbytes <= self.room:
                    self.nbytes += found.photons.nbytes
                    self._walks[key] = found
        return found


class _KeptPhotons:
    """The photons of ``source`` by way of ``kept``."""

    def __init__(self, kept: Kept, source: PhotonSource, settings: Settings) -> None:
        self._kept, self._source, self._settings = kept, source, settings
        self.batches = source.batches
        self.focused, self.learnt = source.focused, source.learnt
        self.seed = source.seed
        self.passes = source.passes

    def walk(self, i: int, batch: Batch) -> Walk:
        """What ``batch`` of pass ``i`` left."""
        return self._kept.walk(self._source, self._settings, i, batch)

    def pilot(self) -> NDArray[np.float64]:
        """Positions (P, 3) of the pilot's global photons; traced anew, they are few."""
        return self._source.pilot()


def _differ_in_camera_alone(a: Scene | None, b: Scene) -> bool:
    """Whether everything else in two scenes is the very same."""
    return a is not None and all(
        getattr(a, field.name) is getattr(b, field.name)
        for field in fields(Scene)
        if field.name not in ("camera", "name")
    )
