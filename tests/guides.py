"""Guides for tests, and a surface of all kinds of lobes that they meet."""

from __future__ import annotations

import numpy as np

from photon_map.core.camera_pass.guide import BINS, Guide, zone_of
from photon_map.core.geometry.vector import basis
from photon_map.core.guide_zones import FLOOR, find_zones
from photon_map.core.sampling.warps import sample_disk
from photon_map.core.scene.lobes import diffuse, ggx, translucent

MIXED = [diffuse((0.5, 0.3, 0.2)), ggx(0.3, 0.7), translucent(0.2)]


def random_guide(places: np.ndarray, side: np.ndarray, seed: int = 5) -> Guide:
    """Zones of ``places``, guided by histograms that know nothing."""
    guide = find_zones(places, side).guide
    density = np.random.default_rng(seed).lognormal(0.0, 1.0, guide.density.shape)
    density = FLOOR + (1 - FLOOR) * density / density.mean(axis=(1, 2), keepdims=True)
    return guide.with_density(density)


def turned_away(
    guide: Guide, places: np.ndarray, normals: np.ndarray, lamp: np.ndarray
) -> Guide:
    """``guide`` with the floor alone in all bins within 60 degrees of the way to ``lamp``.

    ``places``, ``normals`` (n, 3): those that the zones were made of.
    """
    density = guide.density.copy()
    middles = (np.arange(BINS) + 0.5) / BINS
    disc = np.array([[sample_disk(u, v) for v in middles] for u in middles])
    height = np.sqrt(1.0 - (disc**2).sum(axis=2))
    zones = [zone_of(guide, tuple(p), tuple(n)) for p, n in zip(places, normals, strict=True)]
    for zone, first in zip(*np.unique(zones, return_index=True), strict=True):
        n = normals[first]
        t, s = basis(tuple(n))
        directions = disc @ np.array([t, s]) + height[:, :, None] * n
        way = lamp - 0.5 * (guide.low[zone] + guide.high[zone])
        near = directions @ (way / np.linalg.norm(way)) > 0.5
        density[zone][near] = FLOOR
        far = density[zone][~near]
        density[zone][~near] *= (BINS**2 - FLOOR * near.sum()) / far.sum()
    return guide.with_density(density)
