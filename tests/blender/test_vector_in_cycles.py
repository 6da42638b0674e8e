"""The Vector pass beside that of Cycles: bodies that move, turn and bend, and a camera."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blender.support import (
    SQUARE,
    add_camera,
    add_cube,
    add_light,
    add_mesh,
    headless_render,
    link,
    new_material,
    read_exr,
    save_exr,
)

FRAME = 5


def animate(owner: Any, path: str, first: Any, last: Any) -> None:
    """Keys at frames 1 and 9, evenly between them."""
    for frame, value in ((1, first), (9, last)):
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)


def build(bpy: Any) -> None:
    """Before a still floor: a cube that goes and turns, a sheet that bends, an instance."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 60, 40
    bpy.context.preferences.edit.keyframe_new_interpolation_type = "LINEAR"
    camera = add_camera(bpy, (0.0, -0.2, 6.0))
    animate(camera, "location", (0.0, -0.2, 6.0), (0.4, 0.0, 5.6))
    camera.data.shift_x = 0.05
    brown = new_material(bpy, "Brown", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.3, 0.1, 1))
    add_mesh(bpy, "Floor", SQUARE, brown).scale = (2.5, 1.5, 1)
    cube = add_cube(bpy, "Cube", brown)
    cube.scale = (0.5, 0.5, 0.5)
    animate(cube, "location", (-1.6, 0.2, 0.6), (-0.8, 0.8, 0.8))
    animate(cube, "rotation_euler", (0, 0, 0), (0.3, 0.2, 1.6))
    sheet = add_mesh(bpy, "Sheet", SQUARE, brown)
    sheet.location, sheet.scale = (1.2, 0.6, 0.7), (0.6, 0.5, 1)
    sheet.shape_key_add(name="Basis")
    bent = sheet.shape_key_add(name="Bent")
    for k, point in enumerate(bent.data):
        point.co.x += 0.5 * k
    animate(bent, "value", 0.0, 1.0)
    empty = link(bpy, bpy.data.objects.new("Empty", None))
    group = bpy.data.collections.new("Group")
    child = bpy.data.objects.new("Child", add_mesh(bpy, "Shape", SQUARE, brown).data)
    bpy.data.objects["Shape"].hide_render = True
    group.objects.link(child)
    child.scale = (0.3, 0.3, 1)
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    animate(empty, "location", (0.2, -0.8, 0.5), (0.9, -0.5, 0.5))
    add_light(bpy, "SUN", energy=2.0)
    layer = bpy.context.view_layer
    layer.use_pass_vector = layer.use_pass_cryptomatte_object = True
    scene.frame_set(FRAME)


def rendered(bpy: Any, engine: str, folder: Path) -> dict[str, np.ndarray]:
    """Passes of a picture of frame ``FRAME``."""
    bpy.context.scene.render.engine = engine
    save_exr(bpy, folder / f"{engine}.exr")
    headless_render(bpy)
    return {k.split(".")[1]: v for k, v in read_exr(folder / f"{engine}.exr").items()}


def spread(field: np.ndarray, owner: np.ndarray) -> np.ndarray:
    """How much ``field`` differs at most (h, w) among the neighbours of one ``owner``."""
    most = np.zeros(owner.shape)
    for y in (-1, 0, 1):
        for x in (-1, 0, 1):
            moved = np.roll(field, (y, x), (0, 1)), np.roll(owner, (y, x), (0, 1))
            step = np.abs(field - moved[0]).max(axis=2)
            most = np.maximum(most, np.where(moved[1] == owner, step, 0.0))
    return most


def test_vectors_are_those_of_cycles(bpy: Any, tmp_path: Path) -> None:
    import addon_utils

    build(bpy)
    addon_utils.enable("cycles")
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.use_denoising = 64, False
    scene.photon_map.passes = 4
    cycles, ours = (rendered(bpy, name, tmp_path) for name in ("CYCLES", "PHOTONMAP"))
    ranks = [image["CryptoObject00"] for image in (cycles, ours)]
    alone = (ranks[0][..., 1] > 0.999) & (ranks[1][..., 1] > 0.999)
    alone &= ranks[0][..., 0] == ranks[1][..., 0]
    assert len(np.unique(ranks[0][..., 0][alone])) == 4
    gap = np.abs(cycles["Vector"] - ours["Vector"]).max(axis=2)
    assert np.abs(cycles["Vector"]).max() > 2.0  # pixels
    # Cycles' is the mean over the pixel and its filter, ours that of one place in there: they
    # differ by no more than the field does among the pixels around, and not to one side.
    around = spread(cycles["Vector"], ranks[0][..., 0])
    # (The filter is 1.5 pixels wide.)
    assert (gap <= 1.5 * around + 0.01)[alone].all()
    for number in np.unique(ranks[0][..., 0][alone]):
        one = alone & (ranks[0][..., 0] == number)
        assert np.ptp(cycles["Vector"][one], axis=0).max() > 0.0
        assert ours["Vector"][one].mean(axis=0) == pytest.approx(
            cycles["Vector"][one].mean(axis=0), abs=0.03
        )
    assert scene.frame_current == FRAME


def test_nothing_moves_in_a_still_picture(bpy: Any, tmp_path: Path) -> None:
    build(bpy)
    for owner in (*bpy.data.objects, *bpy.data.shape_keys):
        owner.animation_data_clear()
    ours = rendered(bpy, "PHOTONMAP", tmp_path)
    np.testing.assert_array_equal(ours["Vector"], 0.0)


def test_other_bodies_count_as_at_rest(bpy: Any, tmp_path: Path) -> None:
    """An object that is not there in the frame before has moved from nowhere."""
    build(bpy)
    for owner in (*bpy.data.objects, *bpy.data.shape_keys):
        owner.animation_data_clear()
    cube = bpy.data.objects["Cube"]
    for frame, hidden in ((FRAME - 1, True), (FRAME, False)):
        cube.hide_render = hidden
        cube.keyframe_insert("hide_render", frame=frame)
    bpy.context.scene.frame_set(FRAME)
    ours = rendered(bpy, "PHOTONMAP", tmp_path)
    assert len(np.unique(ours["CryptoObject00"][..., 0])) >= 4
    assert ours["Vector"] == pytest.approx(0.0, abs=1e-4)
