"""One chunk of a camera pass: the order of its steps between Embree and the kernels."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..bsdf.dispatch import NARROW
from ..film.film import SAMPLE
from ..film.first_hits import FIRST_HIT
from ..film.layers import DENSITY_LAYER, END_LAYERS
from ..photons.coverage import BorderGrid
from ..photons.photon_map import Crowd, PhotonMap
from ..photons.shadow import ShadowMap
from ..photons.sight import SIGHT
from ..prepared import Prepared
from ..room import ROOM
from ..settings import Settings
from .caustics import gather_caustics
from .density import DensityMaps, count_photons
from .first_hit import step_first_hits
from .indirect import gather_indirect, gather_order, start_gather
from .kinds import KindLight, add_rows
from .light_image import LightImage
from .near import NEAR, add_as_indirect, begin_again, ends_near
from .next_event import light_directly
from .paths import step_paths
from .pixels import Pixels, Region
from .rays import Lit, Rays
from .records import VERTEX
from .start import start_paths
from .tree import split, thin_out


class PhotonMaps(NamedTuple):
    """Both maps of a pass, None where the plan has none, and the radii to ask them with.

    The borders are those of the surfaces, for discs near them; ``shadows``: what spares shadow
    rays, None when they are all traced; ``crowd``: where discs of caustics are smaller.
    ``caustic_radii``: (pixel footprints, least, most [m]); ``global_radius`` [m];
    ``patches``: a ``PATCH`` table of the global map. ``counted``: the maps to ask how many
    photons there are, None when no layer tells it. ``focus``: what crowded places send out,
    None without, with discs of ``focus_radii``, as those of caustics. ``connected``: caustics
    by the light image, or None.
    """

    caustic: PhotonMap | None
    global_: PhotonMap | None
    caustic_radii: tuple[float, float, float]
    global_radius: float
    caustic_borders: BorderGrid
    global_borders: BorderGrid
    emitted: int
    stored: int
    rays: int
    patches: NDArray[np.void]
    shadows: ShadowMap | None = None
    crowd: Crowd | None = None
    counted: DensityMaps | None = None
    focus: PhotonMap | None = None
    focus_radii: tuple[float, float, float] = (0.0, 0.0, 0.0)
    connected: LightImage | None = None


class Chunk(NamedTuple):
    """What a chunk brings: its paths, one ``SAMPLE`` row each, rays traced.

    ``gathered``: those of the rays on gather paths. ``first_hits``: one ``FIRST_HIT`` row
    each, ``kinds`` one (6, 3) of ``KIND_LAYERS``, ``aovs`` one (A, 4), None when no layer asks
    for them.
    """

    pixels: Pixels
    samples: NDArray[np.void]
    rays: int
    gathered: int = 0
    first_hits: NDArray[np.void] | None = None
    kinds: NDArray[np.float64] | None = None
    aovs: NDArray[np.float64] | None = None


def trace_chunk(
    prepared: Prepared,
    settings: Settings,
    region: Region,
    pixels: Pixels,
    maps: PhotonMaps,
) -> Chunk:
    """Follow the paths of ``pixels`` of ``region`` with the photons of ``maps``."""
    samples = np.zeros(pixels.paths, SAMPLE)
    rays = Rays(prepared, pixels.paths)
    kinds = KindLight(samples) if settings.light_kinds else None
    lit = trace_camera(prepared, settings, region, pixels, rays, samples, kinds)
    if kinds:
        samples = kinds.samples
    rays.traced += light_directly(prepared, settings, lit, maps.shadows, samples, kinds)
    ends = wide_only(lit)
    gathered, connected = 0, np.zeros(0)
    if maps.connected is not None:
        connected, light = maps.connected.at(pixels.ids)
        samples["caustics"] += light
    if len(ends.vertices):
        gathered = _gather(prepared, settings, ends, maps, samples, kinds, connected)
        rays.traced += gathered
    first_hits = aovs = None
    if prepared.first_hits is not None:
        first_hits, aovs, traced = trace_first_hits(prepared, settings, region, pixels)
        rays.traced += traced
        if maps.counted is not None:
            slots = ends.vertices["slot"]
            at = kinds.pixel[slots] if kinds else slots
            count_photons(prepared, maps, maps.counted, ends.vertices, at, first_hits)
    by_kind = None
    if kinds:
        samples, by_kind = kinds.finished()
    return Chunk(pixels, samples, rays.traced, gathered, first_hits, by_kind, aovs)


def _gather(
    prepared: Prepared,
    settings: Settings,
    ends: Lit,
    maps: PhotonMaps,
    samples: NDArray[np.void],
    kinds: KindLight | None,
    connected: NDArray[np.float64],
    level: int = 0,
    sent: int = 0,
) -> int:
    """Light by photons, at ``ends`` and where gather rays from there end; rays traced.

    ``connected``: see ``gather_caustics``. ``level``: gathers so far, ``sent``: rays from a
    place in the first of them.
    """
    if maps.caustic is not None:
        asked = (prepared.camera, maps.caustic, maps.caustic_borders, maps.caustic_radii)
        gather_caustics(
            ends.lobes, *asked, maps.crowd, False, connected, ends.vertices,
            len(ends.vertices), samples, np.zeros(SIGHT),
        )  # fmt: skip
        if kinds:
            kinds.add_photons(ends, *asked, samples["caustics"])
    if maps.focus is not None:
        asked = (prepared.camera, maps.focus, maps.caustic_borders, maps.focus_radii)
        # The same kernel as for caustics, where there are any: one fewer to compile.
        crowd = maps.crowd or Crowd(maps.focus, 0.0, maps.focus_radii)
        gather_caustics(
            ends.lobes, *asked, crowd, True, np.zeros(0), ends.vertices, len(ends.vertices),
            samples, np.zeros(SIGHT),
        )  # fmt: skip
        if kinds:
            kinds.add_photons(ends, *asked, samples["indirect"])
    rays = Rays(prepared, len(ends.vertices) * settings.rays_each)
    count = send_gather(prepared, settings, ends, rays)
    rows = samples
    if kinds:
        # Each ray adds to a row of its own.
        rows = np.zeros(count, SAMPLE)
        slots, directions = (rays.paths[name][:count].copy() for name in ("slot", "direction"))
        rays.paths["slot"][:count] = np.arange(count)
    far = follow(prepared, settings, rays, count, True, rows)
    traced = rays.traced
    if maps.global_ is not None:
        near = ends_near(far.vertices, NEAR * maps.global_radius, level)
        gather_indirect(
            far.lobes, maps.global_, maps.global_borders, maps.global_radius, far.vertices,
            gather_order(maps.global_, far.vertices, near), rows, np.zeros(SIGHT),
            maps.patches,
        )  # fmt: skip
        if near.any():
            # The few that are near are copied; the room is needed anew.
            close = Lit(far.vertices[near], far.lobes)
            sent = sent or settings.rays_each
            traced += _gather_near(prepared, settings, close, maps, rows, level, sent)
    if kinds:
        at = np.zeros(len(samples), np.int32)
        at[ends.vertices["slot"]] = np.arange(len(ends.vertices))
        kinds.add(ends, at[slots], directions, rows["direct"].copy(), False)
        kinds.add(ends, at[slots], directions, rows["indirect"].copy(), True)
        add_rows(samples, slots, rows, ("direct", "indirect", "shrink"))
    return traced


def _gather_near(
    prepared: Prepared,
    settings: Settings,
    near: Lit,
    maps: PhotonMaps,
    rows: NDArray[np.void],
    level: int,
    sent: int,
) -> int:
    """Light of ``near``, gathered anew, into the indirect layer of ``rows``; rays traced."""
    slots = near.vertices["slot"].copy()
    begin_again(near.vertices, sent)
    light = np.zeros(len(slots), SAMPLE)
    if (settings.gather_rays, settings.light_samples) != (1, 1):
        settings = replace(settings, gather_rays=1, light_samples=1)
    rays = light_directly(prepared, settings, near, maps.shadows, light, None)
    none = np.zeros(0)
    rays += _gather(prepared, settings, near, maps, light, None, none, level + 1, sent)
    add_as_indirect(light, slots, rows)
    return rays


def wide_only(lit: Lit) -> Lit:
    """The vertices at which photons are gathered."""
    narrow = lit.vertices["part"] == NARROW
    return Lit(lit.vertices[~narrow], lit.lobes) if narrow.any() else lit


def trace_first_hits(
    prepared: Prepared, settings: Settings, region: Region, pixels: Pixels
) -> tuple[NDArray[np.void], NDArray[np.float64], int]:
    """What the paths of ``pixels`` meet at once: (``FIRST_HIT`` rows, AOVs, rays)."""
    rows = np.zeros(pixels.paths, FIRST_HIT)
    aovs = np.zeros((pixels.paths, len(settings.aovs), 4))
    if settings.first_hit == (DENSITY_LAYER,) and not settings.aovs:
        return rows, aovs, 0
    rays = Rays(prepared, pixels.paths)
    start_paths(
        prepared.camera, prepared.camera_media, region.x0, region.y0, region.width,
        region.image_width, settings.seed, pixels.ids, pixels.numbers, rays.origins,
        rays.directions, rays.paths,
    )  # fmt: skip
    deep = any(layer in END_LAYERS for layer in settings.first_hit)
    count = pixels.paths
    while count:
        rays.traced += count
        hits = prepared.intersector.nearest(rays.origins[:count], rays.directions[:count])
        count = step_first_hits(
            prepared.mesh, prepared.materials, rays.lobes, prepared.shading, prepared.lights,
            prepared.camera, prepared.first_hits, settings.transparent, deep,
            settings.camera_depth, settings.min_throughput, len(prepared.lobes), hits.face,
            hits.u, hits.v, rays.hits, count, rays.origins, rays.directions, rays.paths, rows,
            aovs,
        )  # fmt: skip
    rows["seen_emission"] = rows["emission"]
    return rows, aovs, rays.traced


def trace_camera(
    prepared: Prepared,
    settings: Settings,
    region: Region,
    pixels: Pixels,
    rays: Rays,
    samples: NDArray[np.void],
    kinds: KindLight | None = None,
) -> Lit:
    """Camera chains of ``pixels``: emission and first hits into ``samples``, their ends."""
    start_paths(
        prepared.camera, prepared.camera_media, region.x0, region.y0, region.width,
        region.image_width, settings.seed, pixels.ids, pixels.numbers, rays.origins,
        rays.directions, rays.paths,
    )  # fmt: skip
    lit = follow(prepared, settings, rays, pixels.paths, False, samples, kinds)
    if kinds:
        kinds.end_camera()
    return lit


def trace_gather(
    prepared: Prepared, settings: Settings, lit: Lit, samples: NDArray[np.void]
) -> tuple[Lit, int]:
    """Final-gather rays from wide vertices: their half of direct light; (ends, rays)."""
    rays = Rays(prepared, len(lit.vertices) * settings.rays_each)
    count = send_gather(prepared, settings, lit, rays)
    return follow(prepared, settings, rays, count, True, samples), rays.traced


def send_gather(prepared: Prepared, settings: Settings, lit: Lit, rays: Rays) -> int:
    """Gather rays of ``lit`` into the buffers of ``rays``; how many there are."""
    count: int = start_gather(
        settings.rays_each, settings.lights_each, prepared.guide, prepared.materials,
        lit.lobes, lit.vertices, len(lit.vertices), rays.origins, rays.directions, rays.paths,
    )  # fmt: skip
    return count


def follow(
    prepared: Prepared,
    settings: Settings,
    rays: Rays,
    count: int,
    gather: bool,
    samples: NDArray[np.void],
    kinds: KindLight | None = None,
) -> Lit:
    """Follow ``count`` chains to their ends."""
    name = "gather ends" if gather else "ends"
    stopped = 0
    own = len(prepared.lobes)
    tables, filled = [prepared.lobes], own
    splits = settings.split_depth > 0 and not gather and bool(prepared.glass.any())
    while count:
        rays.traced += count
        hits = prepared.intersector.nearest(rays.origins[:count], rays.directions[:count])
        if splits:
            old = count
            hits, count = split(prepared, settings, rays, hits, count)
            if kinds:
                kinds.add_branches(rays.paths[old:count])
                samples = kinds.samples
        vertices = ROOM.take(name, stopped + count, VERTEX, kept=stopped)[stopped:]
        if kinds:
            kinds.begin(rays.paths[:count])
        count, lit, used = step_paths(
            prepared.mesh, prepared.materials, rays.lobes, prepared.shading, prepared.lights,
            prepared.camera, gather, settings.transparent, settings.camera_depth,
            settings.min_throughput, own, hits.face, hits.u, hits.v, rays.hits, count,
            rays.origins, rays.directions, rays.paths, vertices, samples,
        )  # fmt: skip
        if kinds:
            kinds.end(rays.paths[:count])
        if not lit:
            continue
        vertices = vertices[: thin_out(vertices[:lit]) if splits else lit]
        if used > own:
            # The lobes worked out in this step move behind those of the steps before.
            start = vertices["lobe_start"]
            start[start >= own] += filled - own
            tables.append(rays.lobes[own:used].copy())
            filled += used - own
        stopped += len(vertices)
    lobes = tables[0] if len(tables) == 1 else np.concatenate(tables)
    return Lit(ROOM.take(name, stopped, VERTEX), lobes)
