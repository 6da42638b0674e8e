"""Discs of caustics are smaller where light is focused, and still right."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import Settings
from photon_map.core.camera_pass.caustics import ENOUGH, LEAST_DISC, crowded_radius
from photon_map.core.photons.gather import gather_irradiance
from photon_map.core.photons.photon_map import Crowd, PhotonMap, build_photon_map
from photon_map.core.photons.sight import SIGHT
from photon_map.core.photons.trace import PHOTON, Walk
from photon_map.core.prepared import prepare
from photon_map.tests import scenes
from photon_map.tests.statistics import same_means

RADIUS = 0.1
#: Pixel footprints, least and most: they leave no choice.
RADII = (2.0, RADIUS, RADIUS)
ORIGIN, UP = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)


@pytest.fixture(scope="module")
def camera():
    return prepare(scenes.cornell_glass(4), Settings()).camera


def map_of(places) -> PhotonMap:
    """Photons of 1 W at ``places`` (N, 2) of the floor."""
    table = np.zeros(len(places), PHOTON)
    table["position"][:, :2] = places
    table["normal"] = table["direction"] = UP
    table["flux"] = 1.0
    return build_photon_map([Walk(table, np.arange(len(table)), 0)], RADIUS)


def even(random, density):
    """Photons on 1 m^2 around the origin, one to a cell: as even as those of Sobol points."""
    side = int(np.sqrt(density))
    cells = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)
    return (cells + random.random(cells.shape)) / side - 0.5


def radius_at(camera, crowd, factor=1.0, radii=RADII):
    told = Crowd(crowd, factor, RADII)
    return crowded_radius(camera, radii, told, ORIGIN, UP, 1.0, np.zeros(SIGHT))


@pytest.mark.parametrize("density", [200, 400, 2000])
def test_even_light_is_the_same_in_smaller_discs(camera, density, rng):
    # 6, 13 and 63 photons in the disc: around the number from which on it is smaller.
    found = []
    for _ in range(3000):
        radius = radius_at(camera, map_of(even(rng, density)))
        own = map_of(even(rng, density))
        e, _, _ = gather_irradiance(own, ORIGIN, UP, radius, np.zeros(SIGHT))
        found.append(e[0])
    side = int(np.sqrt(density))
    same_means(np.mean(found), np.var(found) / len(found), float(side * side))


def test_few_photons_keep_their_disc(camera):
    assert radius_at(camera, map_of(np.zeros((ENOUGH, 2)))) == RADIUS
    assert radius_at(camera, map_of(np.zeros((0, 2)))) == RADIUS


def test_the_disc_shall_hold_enough(camera):
    crowd = map_of(np.zeros((4 * ENOUGH, 2)))
    assert radius_at(camera, crowd) == pytest.approx(RADIUS / 2)
    # A pass with four times as many photons.
    assert radius_at(camera, crowd, factor=4.0) == pytest.approx(RADIUS / 4)


def test_it_is_never_larger_than_that_of_the_pass(camera):
    crowd = map_of(np.zeros((4 * ENOUGH, 2)))
    late = (2.0, 0.03, 0.03)
    assert radius_at(camera, crowd, radii=late) == 0.03


def test_it_has_an_end(camera):
    crowd = map_of(np.zeros((100, 2)))
    assert radius_at(camera, crowd, factor=1e9) == pytest.approx(LEAST_DISC * RADIUS)


def test_a_focus_does_not_bleed_into_the_dark_beside_it(camera, rng):
    spot = map_of(0.05 + 0.005 * rng.random((500, 2)))
    assert gather_irradiance(spot, ORIGIN, UP, RADIUS, np.zeros(SIGHT))[0][0] > 1000
    radius = radius_at(camera, spot)
    assert gather_irradiance(spot, ORIGIN, UP, radius, np.zeros(SIGHT))[2] == 0
