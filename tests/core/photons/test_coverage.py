"""The share of a gather disc that lies on surfaces, against closed forms and by chance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import integrate

from photon_map.core.geometry.borders import Borders
from photon_map.core.geometry.intersector import Intersector
from photon_map.core.photons.coverage import (
    HALF_AREA,
    LEAST_SHARE,
    MOST_IN_CELL,
    border_grid,
    look_around,
    share_beyond,
)
from photon_map.core.photons.sight import SIGHT
from photon_map.tests import scenes
from photon_map.tests.meshes import all_borders, joined, mesh_of

UP = (0.0, 0.0, 1.0)


def coverage(*query):
    """The share of the disc of a query that nothing parts."""
    parted, share, half = look_around(*query, np.zeros(SIGHT))
    assert not parted
    # A disc of half the area has the same height, within which these tests stay.
    *place, radius = query
    assert half == pytest.approx(look_around(*place, radius * HALF_AREA, np.zeros(SIGHT))[1])
    return share


def grid_of(mesh, radius):
    return border_grid(all_borders(mesh, radius), radius)


def quads(*corners):
    """Rectangles (x0, y0, x1, y1) in z = 0."""
    return [scenes.quad((a, b, 0), (c, b, 0), (c, d, 0), (a, d, 0)) for a, b, c, d in corners]


def chord(distance: float) -> float:
    """Share of the kernel beyond a whole line, by quadrature."""

    def slice_(x: float) -> float:  # of 2 / pi (1 - x^2 - y^2) over y
        h = math.sqrt(1 - x * x)
        return 2 / math.pi * ((1 - x * x) * 2 * h - 2 * h**3 / 3)

    return float(integrate.quad(slice_, distance, 1)[0])


@pytest.mark.parametrize("distance", [0.0, 1e-9, 0.1, 0.5, 0.9, 0.999])
@pytest.mark.parametrize("turn", [0.0, 1.0, 4.0])
def test_a_long_line_hides_a_segment_of_the_disc(distance, turn):
    c, s = math.cos(turn), math.sin(turn)
    ends = [(c * distance - s * y, s * distance + c * y) for y in (-3.0, 3.0)]
    assert share_beyond(*ends[0], *ends[1]) == pytest.approx(chord(distance), abs=1e-8)
    back = -chord(distance) if distance > 1e-6 else chord(distance)
    if distance != 1e-9:
        assert share_beyond(*ends[1], *ends[0]) == pytest.approx(back, abs=1e-8)


def test_pieces_of_a_line_add_up():
    y = np.sort(np.random.default_rng(1).uniform(-1.2, 1.2, 20))
    parts = [share_beyond(0.4, a, 0.4, b) for a, b in zip(y, y[1:], strict=False)]
    assert sum(parts) == pytest.approx(share_beyond(0.4, y[0], 0.4, y[-1]), abs=1e-12)
    assert share_beyond(0.4, 0.1, 0.4, 0.1) == 0 and share_beyond(1.0, -1, 1.0, 1) == 0


@pytest.mark.parametrize("outside", [True, False])
@pytest.mark.parametrize("radius", [0.05, 0.4, 0.9])
def test_edges_and_corners_of_a_room(outside, radius):
    """Half a disc at an edge, a quarter in a corner; the other walls do not count."""
    grid = grid_of(mesh_of(*scenes.box((-1, -1, -1), (1, 1, 1))), radius)
    ng = UP if outside else (0.0, 0.0, -1.0)
    for p, share in (((0, 0, 1), 1.0), ((1, 0, 1), 0.5), ((1 - 1e-9, 1 - 1e-9, 1), 0.25)):
        assert coverage(grid, p, ng, outside, radius) == pytest.approx(share, abs=1e-6)
    beside = (1 - 0.3 * radius, 0.0, 1.0)
    assert coverage(grid, beside, ng, outside, radius) == pytest.approx(
        1 - chord(0.3), abs=1e-6
    )


def by_chance(mesh, p, radius: float, count: int = 40_000) -> float:
    """Mean of the kernel's samples that a ray from above finds on a surface."""
    rng = np.random.default_rng(7)
    # 1 - (1 - r^2)^2 is the kernel's distribution in r.
    r = radius * np.sqrt(1 - np.sqrt(1 - rng.random(count)))
    turn = 2 * np.pi * rng.random(count)
    origin = np.stack([p[0] + r * np.cos(turn), p[1] + r * np.sin(turn), np.ones(count)], 1)
    down = np.broadcast_to(np.float32((0, 0, -1)), (count, 3))
    hits = Intersector(mesh).nearest(origin.astype(np.float32), np.ascontiguousarray(down))
    return float((hits.face >= 0).mean())


def star(points: int = 9):
    """A fan of triangles to a rim with spikes."""
    turn = 2 * np.pi * np.arange(2 * points) / (2 * points)
    reach = np.where(np.arange(2 * points) % 2, 0.35, 1.0)
    rim = np.stack([reach * np.cos(turn), reach * np.sin(turn), 0 * turn], axis=1)
    k = np.arange(2 * points)
    faces = np.stack([0 * k, 1 + k, 1 + (k + 1) % (2 * points)], axis=1)
    return np.concatenate([np.zeros((1, 3)), rim]), faces


def turned(mesh):
    return mesh[0], mesh[1][:, ::-1]


SHAPES = {
    "L": quads((-1, -1, 0.1, 1), (0.1, -1, 1, 0.0)),
    "frame": quads(
        (-1, -1, 1, -0.3), (-1, 0.4, 1, 1), (-1, -0.3, -0.2, 0.4), (0.5, -0.3, 1, 0.4)
    ),
    "planks": quads(*[(-1, y, 1, y + 0.11) for y in np.arange(-1, 1, 0.12)]),
    "planks turned over": [
        turned(q) if k % 2 else q
        for k, q in enumerate(quads(*[(-1, y, 1, y + 0.11) for y in np.arange(-1, 1, 0.12)]))
    ],
    "star": [star()],
    "T-junctions": quads((-1, -1, 0, 0.3), (-1, 0.3, 0, 1), (0, -1, 1, -0.2), (0, -0.2, 1, 1)),
    "T-junctions at the rim": quads((-1, -1, 0, 1), (0, -0.4, 1, 0.1), (0, 0.1, 1, 0.5)),
}  # fmt: skip


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("radius", [0.15, 0.7])
def test_any_shape_counts_as_points_drawn_by_the_kernel_do(name, radius):
    mesh = joined(*SHAPES[name])
    grid = grid_of(mesh, radius)
    rng = np.random.default_rng(3)
    near = 0
    for _ in range(12):
        corners = mesh.vertices[mesh.faces[rng.integers(len(mesh.faces))]].astype(float)
        p = tuple(rng.dirichlet((1, 1, 1)) @ corners)
        expected = max(LEAST_SHARE, by_chance(mesh, p, radius))
        near += expected < 0.99
        # 5 standard errors of 40 000 samples, and parts at the ends of T-junctions.
        room = 0.0125 + (0.02 if name in ("L", "frame", "T-junctions at the rim") else 0.0)
        # Borders of the side that is hit: each shape is seen from above.
        outside = not (name.endswith("over") and _is_turned(mesh, p))
        assert coverage(grid, p, UP, outside, radius) == pytest.approx(expected, abs=room)
    assert near > 2, "the test would see nothing"


def _is_turned(mesh, p) -> bool:
    ray = np.float32([[p[0], p[1], 1.0]]), np.float32([[0, 0, -1]])
    a, b, c = mesh.vertices[mesh.faces[Intersector(mesh).nearest(*ray).face[0]]]
    return bool(np.cross(b - a, c - a)[2] < 0)


@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-7, 1e-5])
@pytest.mark.parametrize("back", [False, True])
def test_a_sheet_twice_or_back_to_back_counts_as_one(gap, back):
    below = scenes.plane(4.0, -gap)
    once = grid_of(joined(scenes.plane(4.0)), 1.2)
    twice = grid_of(joined(scenes.plane(4.0), turned(below) if back else below), 1.2)
    for p in ((4.0, 0.0, 0.0), (3.6, 3.8, 0.0), (3.0, 0.0, 0.0), (0.0, 0.0, 0.0)):
        share = coverage(once, p, UP, True, 1.2)
        assert coverage(twice, p, UP, True, 1.2) == pytest.approx(share, abs=1e-5)


def test_a_thin_board_does_not_count_its_back():
    grid = grid_of(mesh_of(*scenes.box((-1, -1, -0.02), (1, 1, 0))), 0.3)
    assert coverage(grid, (0.9, 0.0, 0.0), UP, True, 0.3) == pytest.approx(1 - chord(1 / 3))


@pytest.mark.parametrize("height, covered", [(0.0, True), (0.001, True), (0.2, False)])
def test_what_lies_on_a_desk_ends_where_photons_of_the_desk_do_not_count(height, covered):
    """Photons count within 0.3 radii of the tangent plane."""
    grid = grid_of(joined(scenes.plane(0.1, height), scenes.plane(1.0)), 0.3)
    share = coverage(grid, (0.09, 0.0, height), UP, True, 0.3)
    alone = by_chance(joined(scenes.plane(0.1)), (0.09, 0.0), 0.3)
    assert share == pytest.approx(1.0 if covered else alone, abs=0.0125)


def test_an_even_fold_counts_up_to_the_corner_of_a_smooth_one():
    """A ridge of 20 degrees is no border, one of 60 is."""
    for slope, share in ((0.35, 1.0), (2.0, 0.5)):
        z = slope
        left = scenes.quad((0, -1, 0), (0, 1, 0), (-1, 1, -z), (-1, -1, -z))
        right = scenes.quad((0, -1, 0), (1, -1, -z), (1, 1, -z), (0, 1, 0))
        grid = grid_of(joined(left, right), 0.2)
        n = np.array((z, 0, 1)) / math.hypot(z, 1)
        assert coverage(grid, (0, 0, 0), tuple(n), True, 0.2) == pytest.approx(share, abs=1e-6)


def test_a_cell_of_fine_detail_is_left_without():
    ends = np.random.default_rng(2).uniform(0.9, 1.1, (MOST_IN_CELL + 1, 2, 3))
    normal = np.broadcast_to(np.array(UP), (len(ends), 3))
    both = np.zeros(len(ends), np.int8)
    borders = Borders(ends, np.ascontiguousarray(normal), np.full(len(ends), np.inf), both)
    grid = border_grid(borders, 0.5)
    assert np.unique(grid.keys, return_counts=True)[1].max(initial=0) <= MOST_IN_CELL
    assert coverage(grid, (1.0, 1.0, 1.0), UP, True, 0.5) == 1.0
