"""Which faces of glass are moved out of another body's plane, and which are not."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core.geometry.mesh import centre_of, centred_mesh
from photon_map.core.geometry.touching import overlapped
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse
from photon_map.tests import scenes

#: Half as much again as a face is moved, relative to the largest coordinate.
NEAR = 6e-6


def moves(*bodies, turn=None):
    """How far the vertices of each body ``(mesh, is glass)`` move, in scene order."""
    b = SceneBuilder("touching")
    rows = [b.add_material("grey", [diffuse(0.5)]), b.add_material("glass", [dielectric(1.5)])]
    turn = np.eye(3) if turn is None else turn
    for k, ((points, faces), glass) in enumerate(bodies):
        b.add_mesh(f"o{k}", points @ turn.T, faces, rows[glass])
    scene = b.build()
    mesh = centred_mesh(scene, centre_of(scene))
    found = overlapped(mesh, scene.face_object, scene.materials["ior"] > 0)
    np.testing.assert_array_equal(found.faces, mesh.faces)
    away = (found.vertices.astype(float) - mesh.vertices) @ turn
    cuts = np.cumsum([len(points) for (points, _), _ in bodies])[:-1]
    return np.split(away, cuts), float(np.abs(mesh.vertices).max())


def turned(angle=0.7):
    axis = np.array([0.3, 0.5, 0.8])
    axis /= np.linalg.norm(axis)
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def grid(count, half=0.8, z=0.0, up=1):
    """A square in z = ``z`` of 2 * count^2 faces."""
    axis = np.linspace(-half, half, count + 1)
    x, y = np.meshgrid(axis, axis)
    points = np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], axis=1)
    i, j = (m.ravel() for m in np.meshgrid(np.arange(count), np.arange(count)))
    k = j * (count + 1) + i
    n = count + 1
    faces = np.concatenate(
        [np.stack([k, k + 1, k + n + 1], 1), np.stack([k, k + n + 1, k + n], 1)]
    )
    return points, faces[:, ::up]


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.2])
def test_the_underside_of_a_slab_sinks_into_the_table(angle):
    slab = scenes.box((-0.5, -0.5, 0), (0.5, 0.5, 0.3))
    (table, glass), largest = moves(
        (scenes.plane(1.0), 0), (slab, 1), turn=turned(angle) if angle else None
    )
    assert (table == 0).all()
    bottom = slab[0][:, 2] == 0
    assert (glass[~bottom] == 0).all()
    assert (glass[bottom][:, 2] < -2e-6 * largest * 0.5).all()
    assert np.abs(glass).max() < NEAR * largest


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_a_fine_underside_stays_flat(angle):
    """Float32 leaves no two of its faces in one plane, once turned."""
    (table, glass), largest = moves(
        (scenes.plane(1.0), 0), (grid(60, up=-1), 1), turn=turned(angle) if angle else None
    )
    assert (table == 0).all()
    assert (glass[:, 2] < -2e-6 * largest * 0.5).all()
    # Float32's steps, and the tilt that they give to small faces.
    assert np.ptp(glass[:, 2]) < 5e-7 * largest
    assert np.abs(glass[:, :2]).max() < 5e-7 * largest


def test_glass_and_water_in_one_wall_overlap():
    water = scenes.box((-0.5, -0.5, 0), (0.5, 0.5, 0.3))
    cup = scenes.box((0.5, -0.5, 0), (0.7, 0.5, 0.3))
    (wet, dry), _ = moves((water, 1), (cup, 1))
    assert (wet[water[0][:, 0] == 0.5][:, 0] > 0).all()
    assert (dry[cup[0][:, 0] == 0.5][:, 0] < 0).all()
    assert (wet[:, 1:] == 0).all() and (dry[:, 1:] == 0).all()


def test_what_touches_nothing_stays():
    slab = scenes.box((-0.5, -0.5, 0), (0.5, 0.5, 0.3))
    far = scenes.quad((2, 2, 0), (3, 2, 0), (3, 3, 0), (2, 3, 0))
    beside = scenes.quad((0.5, -0.5, 0), (1, -0.5, 0), (1, 0.5, 0), (0.5, 0.5, 0))
    above = scenes.plane(1.0, -1e-3)
    across = scenes.quad((0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1))
    for other in (far, beside, above, across):
        assert all((m == 0).all() for m in moves((other, 0), (slab, 1))[0])


def test_only_glass_moves():
    slab = scenes.box((-0.5, -0.5, 0), (0.5, 0.5, 0.3))
    assert all((m == 0).all() for m in moves((scenes.plane(1.0), 0), (slab, 0))[0])
    ball = scenes.sphere((0, 0, 2), 0.5)
    found = moves((scenes.plane(1.0), 0), (slab, 0), (ball, 1))[0]
    assert all((m == 0).all() for m in found)


def test_many_tiles_of_glass_on_many_tiles():
    """One plane, 400 bodies: each tile finds the ones below it."""
    at = np.linspace(-1, 1, 11)[:-1]
    tiles, boxes = [], []
    for x in at:
        for y in at:
            tiles.append((scenes.quad((x, y, 0), (x + 0.2, y, 0), (x + 0.2, y + 0.2, 0),
                                      (x, y + 0.2, 0)), 0))  # fmt: skip
            boxes.append((scenes.box((x + 0.05, y + 0.05, 0), (x + 0.15, y + 0.15, 0.1)), 1))
    found, _ = moves(*tiles, *boxes)
    assert all((m == 0).all() for m in found[:100])
    for move, ((points, _), _) in zip(found[100:], boxes, strict=True):
        assert ((move[:, 2] < 0) == (points[:, 2] == 0)).all()
