"""Embree in batches: what it answers, and that it refuses what it must."""

from __future__ import annotations

import gc
import sys
from concurrent.futures import CancelledError
from threading import Event

import numpy as np
import pytest

from photon_map.core.geometry.intersector import Intersector, check_version, device
from photon_map.core.geometry.mesh import centre_of, centred_mesh
from photon_map.core.scene.builder import SceneBuilder, diffuse
from photon_map.tests import scenes


def intersector(stop=None):
    b = SceneBuilder("square")
    b.add_mesh("square", *scenes.plane(1.0), b.add_material("m", [diffuse(0.5)]))
    scene = b.build()
    return Intersector(centred_mesh(scene, centre_of(scene)), stop)


RAYS = (
    np.array([[0.5, 0.25, 1], [3, 0, 1], [0, 0.1, -2]], np.float32),
    np.array([[0, 0, -1], [0, 0, -1], [0, 0, 4]], np.float32),
)


def test_nearest_and_free():
    square = intersector()
    hits = square.nearest(*RAYS)
    assert (hits.face >= 0).tolist() == [True, False, True]
    # Lengths count in the direction's own length.
    lengths = np.array([0.5, 9, 0.5001], np.float32)
    assert square.is_free(*RAYS, lengths).tolist() == [True, True, False]


def test_a_scene_without_faces_is_never_hit():
    scene = SceneBuilder("void").build()
    void = Intersector(centred_mesh(scene, centre_of(scene)))
    assert (void.nearest(*RAYS).face == -1).all()
    assert void.is_free(*RAYS, np.ones(3, np.float32)).all()


def test_a_stopped_intersector_raises():
    stop = Event()
    square = intersector(stop)
    stop.set()
    with pytest.raises(CancelledError):
        square.nearest(*RAYS)
    with pytest.raises(CancelledError):
        square.is_free(*RAYS, np.ones(3, np.float32))


def test_old_embreex_is_refused():
    with pytest.raises(ImportError, match="4.4"):
        check_version("2.17.7.post6")
    check_version("4.4.0.post1")


def left_in_a_cycle():
    """References to the device while two scenes are there, which nobody has afterwards."""
    embree = [intersector()._scene for _ in range(2)]
    devices = [gc.get_referents(scene)[0] for scene in embree]
    embree.append(embree)
    return all(other is device() for other in devices), sys.getrefcount(device()) - 2


def test_all_scenes_have_one_device_that_outlives_them():
    """One of its own is freed before a scene that is in a cycle: that crashed Blender."""
    gc.collect()  # scenes that other tests left in cycles would go below, between the counts
    same, count = left_in_a_cycle()
    gc.collect()
    left = sys.getrefcount(device())
    assert same
    # The cache's, the call's, and one that nobody gives back.
    assert left == count - 2 >= 3
