"""Where surfaces run into each other without a common edge."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.geometry.borders import CROSSING
from photon_map.core.geometry.crossings import crossings
from photon_map.core.geometry.intersector import Intersector
from photon_map.tests import scenes
from photon_map.tests.meshes import joined, surfaces_of

RADIUS = 0.1


def grid(count, half=1.0):
    """A square of ``count`` x ``count`` cells at z = 0."""
    side = np.linspace(-half, half, count + 1)
    points = np.array([(x, y, 0.0) for y in side for x in side])
    corner = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    a, b, c, d = corner, corner + 1, corner + count + 2, corner + count + 1
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def met(*parts, on=0, radius=RADIUS):
    """Crossings on part ``on``."""
    mesh = joined(*parts)
    counts = [len(faces) for _, faces in parts]
    holds = np.repeat(np.arange(len(parts)) == on, counts)
    return crossings(surfaces_of(mesh, counts), holds, Intersector(mesh), radius)


def length(found):
    return float(np.linalg.norm(found.ends[:, 1] - found.ends[:, 0], axis=1).sum())


def covered(found, points, room=1e-4):
    """Share of ``points`` (N, 3) that lie within ``room`` of some piece."""
    a, b = found.ends[:, 0], found.ends[:, 1]
    along = b - a
    t = ((points[:, None] - a) * along).sum(axis=2) / (along * along).sum(axis=1)
    near = a + np.clip(t, 0, 1)[..., None] * along
    return float((np.linalg.norm(points[:, None] - near, axis=2) < room).any(axis=1).mean())


def foot(x0, y0, x1, y1, count=50):
    """Points on the sides of a rectangle at z = 0."""
    t = (np.arange(count) + 0.5) / count
    x, y = x0 + (x1 - x0) * t, y0 + (y1 - y0) * t
    sides = [(x, y0 + 0 * t), (x, y1 + 0 * t), (x0 + 0 * t, y), (x1 + 0 * t, y)]
    return np.concatenate([np.column_stack([a, b, 0 * t]) for a, b in sides])


# On the floor, above it by what float32 may make of that, sunk into it, a millimetre over it.
@pytest.mark.parametrize("low", [0.0, 1e-7, -1e-7, 1e-6, -1e-5, -0.1, 1e-3])
@pytest.mark.parametrize("turned", [False, True])
def test_a_box_on_a_floor_parts_it_at_its_foot(low, turned):
    points, faces = scenes.box((-0.2, -0.3, low), (0.3, 0.2, 0.5))
    box = points, faces[:, ::-1] if turned else faces
    found = met(scenes.plane(1.0), box)
    assert length(found) == pytest.approx(2.0, rel=1e-4)
    assert covered(found, foot(-0.2, -0.3, 0.3, 0.2)) == 1.0
    assert (found.parts & CROSSING).all() and np.isinf(found.gap).all()
    # The box goes on below the floor only where it is sunk.
    below = length(met(scenes.plane(1.0), box, on=1))
    assert below == pytest.approx(2.0 if low == -0.1 else 0.0, abs=1e-3)


def test_a_box_that_hovers_is_no_crossing():
    assert len(met(scenes.plane(1.0), scenes.box((-0.2, -0.3, 0.02), (0.3, 0.2, 0.5))).gap) == 0


@pytest.mark.parametrize("low", [0.0, -0.3])
@pytest.mark.parametrize("half", [(0.5, 0.5), (0.5, 0.25), (0.5, 0.3)])
def test_the_floor_may_have_edges_and_corners_where_the_box_stands(low, half):
    x, y = half
    found = met(grid(4), scenes.box((-x, -y, low), (x, y, 0.5)))
    assert covered(found, foot(-x, -y, x, y)) == 1.0
    # Twice at most: from the faces on both sides.
    assert length(found) <= 2 * 4 * (x + y) + 1e-6


def test_a_fine_ball_in_a_floor_has_its_circle():
    # Low enough that its surface is steeper than 45 degrees there.
    found = met(scenes.plane(2.0, -0.3), scenes.sphere((0, 0, 0), 1.0, 5))
    angle, radius = np.linspace(0, 2 * np.pi, 1000), 0.91**0.5
    circle = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle - 0.3])
    assert covered(found, circle, room=1e-3) == 1.0, "no gaps"
    off = np.linalg.norm(found.ends[..., :2], axis=2) - radius
    assert np.abs(off).max() < 2e-3
    flat = met(scenes.plane(2.0, -0.9), scenes.sphere((0, 0, 0), 1.0, 5))
    assert len(flat.gap) == 0, "surfaces that meet in less than 45 degrees count as one"


def test_the_corners_of_a_room_and_of_a_box_are_none():
    assert len(met(scenes.box((-1, -1, -1), (1, 1, 1))).gap) == 0
    corner = [
        scenes.quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)),
        scenes.quad((0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)),
    ]
    assert len(met(*corner).gap) == len(met(*corner, on=1).gap) == 0


def test_an_edge_runs_through_many_sheets():
    sheets = [scenes.plane(1.0, z) for z in np.linspace(0.1, 0.9, 9)]
    for sheet in range(1, 10):
        found = met(scenes.box((-0.2, -0.2, 0.0), (0.2, 0.2, 1.0)), *sheets, on=sheet)
        assert length(found) == pytest.approx(1.6)


def test_scale_does_not_matter():
    for scale in (1e-4, 1.0, 1e4):
        points, faces = scenes.box((-0.2, -0.3, -0.1), (0.3, 0.2, 0.5))
        floor, quads = scenes.plane(1.0)
        found = met((floor * scale, quads), (points * scale, faces), radius=0.1 * scale)
        assert length(found) == pytest.approx(2.0 * scale, rel=1e-4)


def test_parts_of_one_object_are_bodies_of_their_own_and_neighbours_are_not():
    mesh = joined(scenes.plane(1.0), scenes.box((-0.2, -0.3, 0.0), (0.3, 0.2, 0.5)))
    assert len(np.unique(surfaces_of(mesh).body)) == 2
    ball = joined(scenes.sphere((0, 0, 0), 1.0, 1))
    assert len(np.unique(surfaces_of(ball).body)) == 1
    assert len(np.unique(surfaces_of(ball, [40, 40]).body)) == 2


def test_crossings_of_random_boxes_lie_on_the_surfaces_of_both():
    rng = np.random.default_rng(5)
    for _ in range(5):
        parts = []
        for _ in range(5):
            turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
            size = rng.uniform(0.2, 0.5, 3)
            parts.append((turn, rng.uniform(-0.3, 0.3, 3), size))
        meshes = []
        for turn, middle, size in parts:
            points, faces = scenes.box(-size, size)
            meshes.append((points @ turn.T + middle, faces))
        for k in range(5):
            found = met(*meshes, on=k)
            assert len(found.gap) and np.isfinite(found.ends).all()
            # Largest distance from the middle in half sizes: 1 on the surface of a box. What
            # is within 2 % of the radius counts as touching.
            at = [
                np.abs((found.ends - middle) @ turn / size).max(axis=2)
                for turn, middle, size in parts
            ]
            room = 0.02 * RADIUS / 0.2
            assert np.abs(at[k] - 1).max() < room
            others = [np.abs(a - 1).max(axis=1) for j, a in enumerate(at) if j != k]
            assert np.min(others, axis=0).max() < room
