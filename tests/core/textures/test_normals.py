"""Bent normals: closed forms, and that no direction is lost to them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from photon_map.core.geometry.mesh import Mesh
from photon_map.core.scene.closures import closure
from photon_map.core.scene.tables import MATERIAL, ClosureKind, ImageKind
from photon_map.core.textures.normals import shading_normal, within_hemisphere
from photon_map.core.textures.shading import ShadingTables
from tests.core.textures.test_sampling import tables

UP = (0.0, 0.0, 1.0)
DOWN = (0.0, 0.0, -1.0)
CORNERS = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]


def one_face(corners: Sequence[Sequence[float]] = CORNERS) -> Mesh:
    return Mesh(
        vertices=np.array(corners, np.float32),
        faces=np.array([[0, 1, 2]], np.int32),
        normals=np.zeros((1, 3, 3), np.float32),
        smooth=np.zeros(1, np.bool_),
        material=np.zeros(1, np.int32),
        visible=np.full(1, 31, np.int32),
    )


def material(**values: float) -> np.void:
    row = np.zeros(1, MATERIAL)
    row["normal_texture"] = row["bump_texture"] = -1
    row["normal_strength"] = row["bump_strength"] = row["bump_distance"] = 1.0
    for key, value in values.items():
        row[key] = value
    return row[0]


def shading_of(
    pixels: np.ndarray, uvs: Sequence[Sequence[float]] | None = None, **use: object
) -> ShadingTables:
    got = tables(pixels, ImageKind.FLOATS, **use)
    return got if uvs is None else got._replace(uvs=np.array([[uvs]], np.float32))


def tilted(x: float, y: float) -> np.ndarray:
    """A normal map of one texel that says (x, y, z)."""
    z = math.sqrt(1 - x * x - y * y)
    return np.array([[[(x + 1) / 2, (y + 1) / 2, (z + 1) / 2, 1.0]]])


def bent(
    shading: ShadingTables,
    row: np.void,
    ng: tuple[float, float, float] = UP,
    mesh: Mesh | None = None,
    wo: tuple[float, float, float] | None = None,
) -> np.ndarray:
    mesh = one_face() if mesh is None else mesh
    return np.array(shading_normal(shading, mesh, row, 0, 0.25, 0.25, ng, ng, wo or ng))


def test_a_normal_map_in_the_axes_of_its_coordinates() -> None:
    got = bent(shading_of(tilted(0.3, 0.2)), material(normal_texture=0))
    assert got == pytest.approx([0.3, 0.2, math.sqrt(1 - 0.13)], abs=1e-6)


@pytest.mark.parametrize(
    ("uvs", "u_axis", "v_axis"),
    [
        ([[0, 0], [1, 0], [0, 1]], (1, 0), (0, 1)),
        ([[0, 0], [0, 1], [1, 0]], (0, 1), (1, 0)),  # mirrored: u along y
        ([[1, 0], [0, 0], [1, 1]], (-1, 0), (0, 1)),  # mirrored: u against x
        ([[0, 0], [0, 1], [-1, 0]], (0, -1), (1, 0)),  # turned by 90 degrees
        ([[0, 0], [5, 0], [0, 9]], (1, 0), (0, 1)),  # scaled: directions only
    ],
)
def test_a_normal_map_follows_its_coordinates(
    uvs: list, u_axis: tuple[int, int], v_axis: tuple[int, int]
) -> None:
    got = bent(shading_of(tilted(0.3, 0.2), uvs), material(normal_texture=0))
    expected = 0.3 * np.array(u_axis) + 0.2 * np.array(v_axis)
    assert got[:2] == pytest.approx(expected, abs=1e-6)
    assert got[2] > 0


def test_the_back_has_the_same_normal_turned_round() -> None:
    shading, row = shading_of(tilted(0.3, 0.2)), material(normal_texture=0)
    assert bent(shading, row, DOWN) == pytest.approx(-bent(shading, row), abs=1e-9)


def test_strength_flattens_and_exaggerates() -> None:
    pixels = tilted(0.3, 0.2)
    flat = bent(shading_of(pixels), material(normal_texture=0, normal_strength=0.0))
    assert flat == pytest.approx(UP, abs=1e-9)
    half = bent(shading_of(pixels), material(normal_texture=0, normal_strength=0.5))
    z = 0.5 + 0.5 * math.sqrt(1 - 0.13)
    assert half == pytest.approx(np.array([0.15, 0.1, z]) / np.linalg.norm([0.15, 0.1, z]))
    double = bent(shading_of(pixels), material(normal_texture=0, normal_strength=2.0))
    assert double[0] / double[2] == pytest.approx(0.6 / math.sqrt(1 - 0.13), rel=1e-6)


#: Heights 0 and 1 side by side: over the middle texel borders the slope is 2 per width.
RAMP = np.array([[[0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0]]])


def test_a_slope_tilts_the_normal_by_its_angle() -> None:
    """Height 2 s over a triangle of 2 m per unit of s: the slope is 1 a metre."""
    for distance in (0.5, -0.5):
        row = material(bump_texture=0, bump_distance=distance)
        uvs = [[0.25, 0], [1.25, 0], [0.25, 1]]
        got = bent(shading_of(RAMP, uvs), row)
        assert got == pytest.approx(np.array([-distance, 0, 1]) / math.hypot(1, distance))
        assert bent(shading_of(RAMP, uvs), row, DOWN) == pytest.approx(-got)


def test_bump_strength_mixes_with_the_plain_normal() -> None:
    uvs = [[0.25, 0], [1.25, 0], [0.25, 1]]
    full, none, half = (
        bent(
            shading_of(RAMP, uvs), material(bump_texture=0, bump_distance=0.5, bump_strength=s)
        )
        for s in (1.0, 0.0, 0.5)
    )
    assert none == pytest.approx(UP)
    middle = (full + np.array(UP)) / 2
    assert half == pytest.approx(middle / np.linalg.norm(middle))


@pytest.mark.parametrize(
    "uvs", [[[0, 0]] * 3, [[0, 0], [1, 1], [2, 2]], [[0, 0], [math.nan, 0], [0, math.inf]]]
)
def test_coordinates_that_span_nothing_leave_the_normal(uvs: list) -> None:
    both = material(normal_texture=0, bump_texture=0)
    got = bent(shading_of(tilted(0.3, 0.2), uvs), both)
    assert got == pytest.approx(UP, abs=1e-6)


def test_no_coordinates_at_all_leave_the_normal() -> None:
    both = material(normal_texture=0, bump_texture=0)
    got = bent(shading_of(tilted(0.3, 0.2), uv=3), both)
    assert got == pytest.approx(UP, abs=1e-9)


def test_a_diffuse_surface_may_be_steeper_than_a_mirror() -> None:
    uvs, row = [[0.25, 0], [1.25, 0], [0.25, 1]], material(bump_texture=0, bump_distance=3.0)
    mirror = bent(shading_of(RAMP, uvs), row)
    # Least sine 0.01: a mirror seen from above cannot lean by much more than 45 degrees.
    assert mirror[2] == pytest.approx(math.cos(math.acos(0.01) / 2))
    row["closure_count"] = 1
    shading = shading_of(RAMP, uvs)._replace(closures=np.array([closure(ClosureKind.DIFFUSE)]))
    assert bent(shading, row) == pytest.approx(np.array([-3, 0, 1]) / math.sqrt(10))
    away = direction(0.2, 0.0)
    assert bent(shading, row, wo=away) @ np.array(away) > 0


ANGLES = st.floats(0, 2 * math.pi)
COSINES = st.floats(1e-6, 1.0)


def direction(cosine: float, angle: float) -> tuple[float, float, float]:
    sine = math.sqrt(max(0.0, 1 - cosine * cosine))
    return sine * math.cos(angle), sine * math.sin(angle), cosine


@settings(max_examples=500, deadline=None, derandomize=True)
@given(COSINES, ANGLES, st.floats(-1, 1), ANGLES)
def test_mirror_rays_stay_above_the_surface(
    cos_wo: float, angle_wo: float, cos_n: float, angle_n: float
) -> None:
    wo, n = direction(cos_wo, angle_wo), direction(cos_n, angle_n)
    got = np.array(within_hemisphere(UP, n, wo))
    assert np.linalg.norm(got) == pytest.approx(1.0, abs=1e-9)
    cosine = got @ wo
    assert cosine > 0
    assert got[2] > 0
    reflected = 2 * cosine * got - wo
    assert reflected[2] >= min(0.9 * cos_wo, 0.01) - 1e-9


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    st.lists(st.floats(-10, 10), min_size=6, max_size=6),
    st.lists(st.floats(0, 1), min_size=6, max_size=6),
    COSINES,
    ANGLES,
    st.floats(0, 10),
)
def test_any_picture_on_any_coordinates_gives_a_unit_normal_to_the_viewers_side(
    uvs: list[float], colors: list[float], cosine: float, angle: float, strength: float
) -> None:
    pixels = np.ones((1, 2, 4))
    pixels[0, :, :3] = np.reshape(colors, (2, 3))
    shading = shading_of(pixels, np.reshape(uvs, (3, 2)).tolist())
    row = material(
        normal_texture=0, bump_texture=0, normal_strength=strength, bump_strength=strength
    )
    wo = direction(cosine, angle)
    got = bent(shading, row, wo=wo)
    assert np.linalg.norm(got) == pytest.approx(1.0, abs=1e-6)
    assert got @ np.array(wo) > 0
    assert got[2] > 0
