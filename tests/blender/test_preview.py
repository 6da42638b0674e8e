"""Previews of data: Blender's own little scenes, rendered by the engine."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from tests.blender.support import new_material


def preview(bpy: Any, owner: Any) -> np.ndarray:
    """The picture (h, w, 4) that Blender's job makes for ``owner``."""
    bpy.context.scene.render.engine = "PHOTONMAP"
    with bpy.context.temp_override(id=owner):
        bpy.ops.ed.lib_id_generate_preview()
    limit = time.monotonic() + 200
    pixels = np.zeros(0)
    while not pixels.any():
        assert time.monotonic() < limit
        time.sleep(0.1)
        width, height = owner.preview.image_size
        pixels = np.array(owner.preview.image_pixels_float[:]).reshape(height, width, 4)
    return pixels


def test_a_material_is_a_ball(bpy: Any, capfd: Any) -> None:
    """Red, lit from the left, before nothing: the floor is for mirrors and glass."""
    from photon_map.addon.preview import WAITING

    red = new_material(bpy, "Red", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.05, 0.04, 1))
    pixels = preview(bpy, red)
    height, width, _ = pixels.shape
    assert pixels[height // 2, width // 2, 3] == pytest.approx(1.0)
    assert pixels[2, 2, 3] == 0.0
    assert 0.4 < pixels[..., 3].mean() < 0.65
    ball = pixels[pixels[..., 3] > 0.99]
    assert ball[:, 0].mean() > 2 * ball[:, 1].mean()
    halves = pixels[:, : width // 2], pixels[:, width // 2 :]
    left, right = (half[half[..., 3] > 0.99][:, 0].mean() for half in halves)
    assert left > 1.15 * right
    assert not WAITING.is_set()
    assert "not supported" not in "".join(capfd.readouterr()), "nobody can mend Blender's scene"


def test_a_world_and_a_lamp_have_pictures_too(bpy: Any) -> None:
    world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.3, 0.8, 1)
    blue = preview(bpy, world)
    assert (blue[..., 3] == 1.0).all()
    assert blue[..., 2].mean() > blue[..., 0].mean() + 0.3
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.color = 5.0, (1.0, 0.4, 0.2)
    lit = preview(bpy, lamp)
    assert lit[..., 0].mean() > lit[..., 2].mean() + 0.05
