"""What a disc sees of its surface where others run through it."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.geometry.borders import CROSSING, Borders, short
from photon_map.core.geometry.borders import joined as all_of
from photon_map.core.geometry.crossings import crossings
from photon_map.core.geometry.intersector import Intersector
from photon_map.core.photons.coverage import border_grid, look_around
from photon_map.core.photons.sight import (
    SECTORS,
    SIGHT,
    end_sight,
    is_hidden,
    open_sight,
    sector_of,
    seen_share,
)
from photon_map.tests import scenes
from photon_map.tests.meshes import all_borders, joined, surfaces_of

UP = (0.0, 0.0, 1.0)
RADIUS = 0.1


def grid_of(*parts, radius=RADIUS):
    mesh = joined(*parts)
    surfaces = surfaces_of(mesh, [len(faces) for _, faces in parts])
    holds = np.ones(len(mesh.faces), bool)
    met = short(crossings(surfaces, holds, Intersector(mesh), radius), radius, 10**6)
    return border_grid(all_of(all_borders(mesh, radius), met), radius)


def parted(*query):
    return look_around(*query)[0]


def share_where(seen, p, radius):
    """Share of the kernel about ``p`` where ``seen(x, y)``, by a fine grid."""
    step = (np.arange(600) + 0.5) / 300 - 1
    x, y = np.meshgrid(step, step)
    weight = np.maximum(0, 1 - x * x - y * y)
    return (weight * seen(p[0] + radius * x, p[1] + radius * y)).sum() / weight.sum()


def test_sectors_follow_the_angle_and_their_shares_make_one():
    angle = np.linspace(-np.pi / 2 + 1e-6, 1.5 * np.pi - 1e-6, 1000)
    sectors = [sector_of(float(np.cos(a)), float(np.sin(a))) for a in angle]
    assert (np.diff(sectors) >= 0).all()
    assert sectors[0] == 0 and sectors[-1] == SECTORS - 1
    assert sector_of(0.0, 0.0) == 0
    sight = np.zeros(SIGHT)
    open_sight(sight)
    assert seen_share(sight, 1.0) == pytest.approx(1.0) == seen_share(sight, 0.7)


def test_lines_end_the_sight_exactly_where_photons_are_hidden():
    """The share is that of the very places that are not hidden, whatever the lines."""
    rng = np.random.default_rng(2)
    for _ in range(20):
        sight = np.zeros(SIGHT)
        open_sight(sight)
        for _ in range(rng.integers(1, 6)):
            a, b = rng.uniform(-1.2, 1.2, (2, 2))
            end_sight(sight, *map(float, a), *map(float, b))
        places_ = rng.uniform(-1, 1, (4000, 2))
        d2 = (places_**2).sum(axis=1)
        weight = np.maximum(0, 1 - d2)
        hidden = np.array(
            [is_hidden(sight, (0.3 * x, 0.3 * y, 0.1), UP, 0.3) for x, y in places_.tolist()]
        )
        found = (weight * ~hidden).sum() / weight.sum()
        assert found == pytest.approx(seen_share(sight, 1.0), abs=0.04)


@pytest.mark.parametrize("turn", [0.0, 0.4, 2.0, 3.3, 5.0])
@pytest.mark.parametrize("distance", [1e-6, 0.2, 0.8])
def test_nothing_beyond_a_long_line_is_seen(distance, turn):
    c, s = np.cos(turn), np.sin(turn)
    ends = [(c * distance - s * y, s * distance + c * y) for y in (-3.0, 3.0)]
    sight = np.zeros(SIGHT)
    open_sight(sight)
    end_sight(sight, *map(float, ends[0]), *map(float, ends[1]))
    back = np.zeros(SIGHT)
    open_sight(back)
    end_sight(back, *map(float, ends[1]), *map(float, ends[0]))
    np.testing.assert_allclose(sight, back)
    rng = np.random.default_rng(4)
    points = rng.uniform(-1, 1, (2000, 2))
    beyond = points @ (c, s) > distance
    hidden = np.array([is_hidden(sight, (x, y, 0.0), UP, 1.0) for x, y in points.tolist()])
    inside = (points**2).sum(axis=1) < 1
    # A sector ends at the nearer of its two corners: what is lost lies just before the line.
    assert hidden[beyond & inside].mean() > 0.99
    own = inside & ~beyond
    assert hidden[own].mean() < 0.05
    assert not hidden[own & (points @ (c, s) < distance - 0.13)].any()


def test_a_line_through_the_middle_or_outside_hides_nothing():
    for ends in ((-1.0, 0.0, 1.0, 0.0), (1.0, -1.0, 1.0, 1.0), (0.5, 0.5, 0.5, 0.5)):
        sight = np.zeros(SIGHT)
        open_sight(sight)
        end_sight(sight, *ends)
        assert (sight == 1).all()


@pytest.mark.parametrize("low", [0.0, -0.1, 1e-3])
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("outside", [False, True])
def test_a_disc_beside_a_box_sees_the_floor_that_is_not_behind_it(low, turned, outside):
    points, faces = scenes.box((-0.2, -0.3, low), (0.3, 0.2, 0.5))
    floor, quads = scenes.plane(1.0)
    box = points, faces[:, ::-1] if turned else faces
    grid = grid_of((floor, quads if outside else quads[:, ::-1]), box)
    sight = np.zeros(SIGHT)
    for x, y in ((0.301, 0.0), (0.35, 0.1), (0.0, -0.31), (0.39, 0.0), (-0.21, 0.15)):
        assert parted(grid, (x, y, 0.0), UP, outside, RADIUS, sight)
        sides = [(x > 0.3, lambda u, v: u > 0.3), (x < -0.2, lambda u, v: u < -0.2)]
        sides += [(y < -0.3, lambda u, v: v < -0.3)]
        seen = next(seen for beside, seen in sides if beside)
        expected = share_where(seen, (x, y), RADIUS)
        assert seen_share(sight, 1.0) == pytest.approx(expected, abs=0.02)
    assert not parted(grid, (0.5, 0.5, 0.0), UP, outside, RADIUS, sight)
    assert sight[SECTORS] == 0


def test_beyond_a_thin_wall_nothing_is_seen():
    wall = scenes.box((-0.01, -2, -0.1), (0.01, 2, 1))
    grid = grid_of(scenes.plane(1.0), wall)
    sight = np.zeros(SIGHT)
    assert parted(grid, (0.03, 0.0, 0.0), UP, True, RADIUS, sight)
    for x in np.linspace(-0.06, -0.011, 20):
        for y in np.linspace(-0.05, 0.05, 11):
            assert is_hidden(sight, (x - 0.03, y, 0.0), UP, RADIUS)
    assert not is_hidden(sight, (0.05, 0.02, 0.0), UP, RADIUS)


def test_the_rim_of_the_floor_ends_the_sight_beside_a_wall_too():
    sheet = scenes.quad((0, -2, -0.1), (0, 2, -0.1), (0, 2, 0.5), (0, -2, 0.5))
    grid = grid_of(scenes.plane(1.0), sheet)
    sight = np.zeros(SIGHT)
    p = (0.05, 0.97)
    assert parted(grid, (*p, 0.0), UP, True, RADIUS, sight)
    expected = share_where(lambda x, y: (x > 0) & (y < 1), p, RADIUS)
    assert seen_share(sight, 1.0) == pytest.approx(expected, abs=0.02)


def test_the_pieces_of_crossings_are_short_and_bounded():
    found = grid_of(scenes.plane(1.0), scenes.sphere((0, 0, -0.3), 0.9, 5))
    assert np.linalg.norm(found.ends[:, 1] - found.ends[:, 0], axis=1).max() <= RADIUS * 1.001
    assert (found.parts & CROSSING).astype(bool).sum() > 60
    few = short(Borders(found.ends, found.normal, found.gap, found.parts), RADIUS, 40)
    assert len(few.gap) <= 40


@pytest.mark.parametrize("turned", [False, True])
def test_rooms_side_by_side_part_the_light_and_tables_do_not(turned):
    """The floors of two rooms with a wall between them; two table tops with a gap between."""

    def shut(low, high):
        points, faces = scenes.box(low, high)
        return points, faces[:, ::-1]  # its normals inwards

    rooms = [shut((-1, -1, 0), (-0.01, 1, 1)), shut((0.01, -1, 0), (1, 1, 1))]
    tops = [scenes.box((-1, -1, -0.1), (-0.01, 1, 0)), scenes.box((0.01, -1, -0.1), (1, 1, 0))]
    sight = np.zeros(SIGHT)
    p, outside = (0.03, 0.0, 0.0), True
    if turned:
        rooms = [(points, faces[:, ::-1]) for points, faces in rooms]
        outside = False
    assert parted(grid_of(*rooms), p, UP, outside, RADIUS, sight)
    assert is_hidden(sight, (-0.05, 0.0, 0.0), UP, RADIUS)
    whole, share, _ = look_around(grid_of(*tops), p, UP, True, RADIUS, sight)
    assert not whole and 0.7 < share < 0.95
    # One room alone is not parted: nothing begins behind its wall.
    assert not parted(grid_of(rooms[1]), p, UP, outside, RADIUS, sight)


def test_a_wall_on_an_edge_of_a_floor_that_goes_on_parts_it():
    points = [(x, y, 0) for x in (-1, 0, 1) for y in (-1, 1)] + [(0, -1, 1), (0, 1, 1)]
    quads = [(0, 2, 3, 1), (2, 4, 5, 3), (2, 6, 7, 3)]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    grid = grid_of((np.array(points, float), faces))
    sight = np.zeros(SIGHT)
    assert parted(grid, (0.03, 0.0, 0.0), UP, True, RADIUS, sight)
    assert is_hidden(sight, (-0.05, 0.0, 0.0), UP, RADIUS)
