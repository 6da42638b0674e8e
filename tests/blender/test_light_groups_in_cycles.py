"""The light of light groups, beside that of Cycles."""

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
    new_material,
    read_exr,
    save_exr,
)


def build(bpy: Any) -> None:
    """A floor and a cube under two lamps, a glowing face and a sky, in three groups."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 24, 16
    add_camera(bpy, (0.0, 0.0, 6.0))
    grey = new_material(bpy, "Grey", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.5, 0.4, 1))
    add_mesh(bpy, "Floor", SQUARE, grey).scale = (3, 3, 1)
    add_cube(bpy, "Cube", grey).location = (0.0, 0.0, 0.5)
    glow = new_material(bpy, "Glow", "ShaderNodeEmission", Strength=3.0, Color=(1, 0.5, 0.2, 1))
    plate = add_mesh(bpy, "Plate", SQUARE, glow)
    plate.location, plate.scale = (1.5, 0.0, 1.0), (0.3, 0.3, 1)
    key, fill = (add_light(bpy, "POINT", energy=power) for power in (60.0, 30.0))
    key.location, fill.location = (1.0, 1.0, 3.0), (-1.5, -1.0, 2.0)
    key.data.shadow_soft_size = fill.data.shadow_soft_size = 0.1
    world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    scene.world = world
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.2, 0.3, 1)
    for name in ("Key", "Rest"):
        bpy.ops.scene.view_layer_add_lightgroup(name=name)
    key.lightgroup = "Key"
    fill.lightgroup = plate.lightgroup = world.lightgroup = "Rest"


def rendered(bpy: Any, engine: str, folder: Path) -> dict[str, np.ndarray]:
    bpy.context.scene.render.engine = engine
    save_exr(bpy, folder / f"{engine}.exr")
    headless_render(bpy)
    return {k.split(".")[1]: v for k, v in read_exr(folder / f"{engine}.exr").items()}


def test_light_groups_are_those_of_cycles(bpy: Any, tmp_path: Path) -> None:
    if bpy is None:
        return
    import addon_utils

    build(bpy)
    addon_utils.enable("cycles")
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.use_denoising = 512, False
    scene.cycles.use_adaptive_sampling, scene.photon_map.passes = False, 64
    theirs = rendered(bpy, "CYCLES", tmp_path)
    ours = rendered(bpy, "PHOTONMAP", tmp_path)
    assert {"Caustics_Key", "Caustics_Rest"} <= set(ours)
    groups = [ours[f"Combined_{name}"][..., :3] for name in ("Key", "Rest")]
    np.testing.assert_allclose(sum(groups), ours["Combined"][..., :3], rtol=1e-4, atol=1e-6)
    for name, found in zip(("Key", "Rest"), groups, strict=True):
        expected = theirs[f"Combined_{name}"][..., :3]
        assert found.mean(axis=(0, 1)) == pytest.approx(expected.mean(axis=(0, 1)), rel=0.02)
        blocks = [image.reshape(4, 4, 4, 6, 3).mean(axis=(1, 3)) for image in (found, expected)]
        assert blocks[0] == pytest.approx(blocks[1], rel=0.1, abs=0.02 * expected.mean())
