"""No cliff between smooth and rough: the mean is the reference's, the noise has no island."""

from __future__ import annotations

import pytest

from photon_map.tests.roughness.judge import farthest, island, roughest_jump
from photon_map.tests.roughness.sweep import ROUGHNESS, SWEEPS, measure

#: Standard errors that the worst point of a sweep may be off, beyond the bias: a level of
#: 1e-4 for one of 13 points, with the seven degrees of freedom of eight seeds.
MOST_Z = 10.0
#: How far the squared error of a point may rise over the least on both of its sides.
MOST_RISE = 3.0
FEW = (0.0, 0.15, 0.25, 0.4, 1.0)


@pytest.mark.parametrize("name", ["metal caster", "glass caster"])
def test_a_rough_caster_throws_the_references_light_without_an_island_of_noise(name):
    points = [measure(SWEEPS[name], r, passes=4, samples=2000, caustic_radius=1.0) for r in FEW]
    assert farthest(points)[1] < MOST_Z
    # 9 and 27 when gather rays ask the photon map at the caster.
    assert island(points).value < MOST_RISE


@pytest.mark.slow
@pytest.mark.parametrize("name", SWEEPS)
def test_nothing_jumps_from_a_mirror_to_the_roughest_surface(name):
    samples = 2000 if SWEEPS[name].reference else 0
    points = [measure(SWEEPS[name], r, passes=16, samples=samples) for r in ROUGHNESS]
    if SWEEPS[name].reference:
        assert farthest(points)[1] < MOST_Z
    assert roughest_jump(points)[1] < MOST_Z
    assert island(points).value < MOST_RISE
