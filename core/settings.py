"""What a user may choose about a render, checked once, then frozen."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Literal, NamedTuple

from .film.layers import FIRST_HIT_LAYERS, KIND_COLORS

PixelFilter = Literal["BOX", "GAUSSIAN", "BLACKMAN_HARRIS"]
StaleMaps = Literal["TRACE", "REBUILD", "REFUSE"]

#: What the names of files with baked photon maps end with.
MAPS_SUFFIX = ".pmap"

#: A count that is chosen for the image.
AUTOMATIC = -1
#: Gather rays where nothing is known of the noise.
USUAL_GATHER_RAYS = 4
USUAL_LIGHT_SAMPLES = 1


class SettingsError(ValueError):
    """A setting out of its range; the message names it and the range."""


class LightGroup(NamedTuple):
    """Lights whose light is kept by itself: names of lamps and of glowing objects."""

    name: str
    lights: tuple[str, ...] = ()
    objects: tuple[str, ...] = ()
    world: bool = False


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Settings of one render.

    It stops at ``passes``, ``seconds`` (0 = no limit) or when ``relative_error`` reaches
    ``error_goal`` (0 = none), whichever comes first; one whole pass is always made.
    Photon counts are emitted photons per pass, -1: half the
    number of pixels but 8192 at least, 0: none; ``gather_rays`` final-gather rays leave
    each place where a camera path ends, -1: as many as make the least noise in the same time,
    and so many caustic photons and ``light_samples``, points on lights asked at a place, if
    their counts are -1 (``balance``); depths count surface interactions.
    ``alpha``: how slowly the caustic discs shrink from pass to pass, 1 keeps them.
    Camera paths split at smooth glass at their first ``split_depth`` events, into branches
    that carry ``split_least`` at least (``camera_pass/tree``); 0: one is drawn by chance.
    ``min_throughput``: camera paths that carry less are ended. ``region`` is
    (x0, y0, x1, y1) in pixels, row 0 at the bottom, None for the whole image.
    ``adaptive``: whether pixels get camera paths by their noise (``path_density``), as many in
    all as one each.
    ``exposure`` is a factor on the light of the film's layers. ``first_hit``: layers of
    ``film.first_hits.LAYERS`` to render beside the light; mattes keep ``matte_ranks`` names.
    ``light_kinds``: whether the light is kept by kind as well (``film.layers.KIND_LAYERS``),
    which needs their colours.
    ``aovs``: names of the scene's AOVs to have layers (``film.layers.aov_layer``).
    ``light_groups``: lights to have layers of their own (``film.layers.group_layer``).
    ``threads`` 0 takes every core. Neither ``threads`` nor ``chunk_size`` (paths worked on
    at a time) changes a bit of the result.
    ``draft``: a first look in less time, by not looking where surfaces run into others, so
    that gather discs reach through walls that stand in a floor, and by choosing the discs
    from fewer pixels and photons.
    ``focus``: whether photons, instead of gather rays, bring the light of small bright places
    (``photons/focus``). ``guide``: whether gather rays may be guided to where indirect light
    comes from, where that pays (``guide_pass``); ``learn_aim``: whether lights may send caustic
    photons to where this camera sees them (``aim_pass``).
    ``photon_maps``: file of baked maps to take photons from, "" for none; where they do not
    fit the scene, ``stale_maps`` says to trace as usual, to bake them again, or to refuse.
    ``photon_memory`` [MB]: most that both photon maps of a pass, and those of the passes under
    way, may take; where it is too little there are fewer photons.
    ``shadow_photons`` straight paths from the lamps, 0 for none, spare shadow rays where less
    than ``shadow_lit`` or more than ``shadow_dark`` of ``shadow_least`` or more photons around
    a place are shadow photons, with confidence (``photons/shadow``).
    """

    passes: int = 64
    seconds: float = 0.0
    error_goal: float = 0.0
    seed: int = 0
    threads: int = 0
    photons_global: int = AUTOMATIC
    photons_caustic: int = AUTOMATIC
    gather_rays: int = AUTOMATIC
    light_samples: int = AUTOMATIC
    camera_depth: int = 32
    photon_depth: int = 32
    min_throughput: float = 1e-4
    split_depth: int = 4
    split_least: float = 0.1
    caustic_radius: float = 1.4
    alpha: float = 2.0 / 3.0
    pixel_filter: PixelFilter = "BLACKMAN_HARRIS"
    filter_width: float = 1.5
    adaptive: bool = True
    transparent: bool = False
    exposure: float = 1.0
    region: tuple[int, int, int, int] | None = None
    chunk_size: int = 8192
    photon_maps: str = ""
    stale_maps: StaleMaps = "TRACE"
    first_hit: tuple[str, ...] = ()
    matte_ranks: int = 6
    light_kinds: bool = False
    light_groups: tuple[LightGroup, ...] = ()
    aovs: tuple[str, ...] = ()
    photon_memory: int = 4096
    shadow_photons: int = 0
    shadow_lit: float = 0.1
    shadow_dark: float = 0.96
    shadow_least: int = 16
    draft: bool = False
    focus: bool = True
    guide: bool = True
    learn_aim: bool = True

    def __post_init__(self) -> None:
        for name, (low, high) in _RANGES.items():
            value = getattr(self, name)
            if not (math.isfinite(value) and low <= value <= high):
                raise SettingsError(f"{name} is {value}, it must be from {low:g} to {high:g}")
        for name in ("gather_rays", "light_samples"):
            if getattr(self, name) == 0:
                raise SettingsError(f"{name} is 0, it must be from 1 to 1024, or -1")
        if self.pixel_filter not in ("BOX", "GAUSSIAN", "BLACKMAN_HARRIS"):
            raise SettingsError(
                f"pixel_filter is {self.pixel_filter!r}, it must be BOX, GAUSSIAN or "
                "BLACKMAN_HARRIS"
            )
        if self.stale_maps not in ("TRACE", "REBUILD", "REFUSE"):
            raise SettingsError(
                f"stale_maps is {self.stale_maps!r}, it must be TRACE, REBUILD or REFUSE"
            )
        if self.photon_maps and not self.photon_maps.lower().endswith(MAPS_SUFFIX):
            raise SettingsError(f"photon_maps is {self.photon_maps!r}, no {MAPS_SUFFIX} file")
        unknown = [name for name in self.first_hit if name not in FIRST_HIT_LAYERS]
        if unknown:
            known = ", ".join(FIRST_HIT_LAYERS)
            raise SettingsError(f"first_hit: no layer '{unknown[0]}'; there are {known}")
        missing = set(KIND_COLORS) - set(self.first_hit)
        if self.light_kinds and missing:
            raise SettingsError(f"light_kinds needs first_hit to have {', '.join(KIND_COLORS)}")
        names = [group.name for group in self.light_groups]
        if len(set(names)) < len(names):
            raise SettingsError(f"light_groups: two of one name among {', '.join(names)}")
        if len(set(self.aovs)) < len(self.aovs):
            raise SettingsError(f"aovs: two of one name among {', '.join(self.aovs)}")
        if self.region is not None:
            x0, y0, x1, y1 = self.region
            if not (0 <= x0 < x1 and 0 <= y0 < y1):
                raise SettingsError(f"region {self.region} has no pixel")

    def photon_count(self, chosen: int, pixels: int) -> int:
        """Photons to emit per pass: ``chosen``, or what suits an image of ``pixels``."""
        return max(8192, pixels // 2) if chosen == AUTOMATIC else chosen

    @property
    def rays_each(self) -> int:
        """Gather rays from a place, as long as nobody has decided it."""
        return USUAL_GATHER_RAYS if self.gather_rays == AUTOMATIC else self.gather_rays

    @property
    def lights_each(self) -> int:
        """Points of lights asked for at a place, as long as nobody has decided it."""
        return USUAL_LIGHT_SAMPLES if self.light_samples == AUTOMATIC else self.light_samples

    @property
    def thread_count(self) -> int:
        """Threads to use: the setting, or every core this process may run on."""
        if self.threads:
            return self.threads
        if hasattr(os, "sched_getaffinity"):
            return len(os.sched_getaffinity(0))
        return os.cpu_count() or 1


_RANGES: dict[str, tuple[float, float]] = {
    "passes": (1, 10_000_000),
    "seconds": (0, 1e9),
    "error_goal": (0, 10),
    "seed": (0, 2**31 - 1),
    "threads": (0, 1024),
    "photons_global": (AUTOMATIC, 100_000_000),
    "photons_caustic": (AUTOMATIC, 100_000_000),
    "gather_rays": (AUTOMATIC, 1024),
    "light_samples": (AUTOMATIC, 1024),
    "camera_depth": (1, 1024),
    "photon_depth": (1, 1024),
    "min_throughput": (0, 1),
    "split_depth": (0, 16),
    "split_least": (1e-6, 1),
    "caustic_radius": (0.1, 1000),
    "alpha": (0.01, 1),
    "filter_width": (0.01, 100),
    "exposure": (0, 10),
    "chunk_size": (1, 10_000_000),
    "matte_ranks": (1, 16),
    "photon_memory": (16, 1_000_000),
    "shadow_photons": (0, 100_000_000),
    "shadow_lit": (0, 1),
    "shadow_dark": (0, 1),
    "shadow_least": (1, 1_000_000),
}
