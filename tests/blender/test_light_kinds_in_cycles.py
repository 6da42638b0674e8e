"""Diffuse, glossy and transmission passes, direct and indirect, beside those of Cycles."""

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

SHORT = {"Diffuse": "Diff", "Glossy": "Gloss", "Transmission": "Trans"}
WAYS = {"Direct": "Dir", "Indirect": "Ind", "Color": "Col"}
OLD = {f"{a}{b}": f"{kind} {way}" for kind, a in SHORT.items() for way, b in WAYS.items()}
OLD |= {"IndexOB": "Object Index", "Env": "Environment", "Emit": "Emission"}


def mixture(bpy: Any) -> Any:
    """A mirror and smooth glass, half of each."""
    material = new_material(
        bpy, "Mixture", "ShaderNodeBsdfGlossy", Color=(0.9, 0.6, 0.4, 1), Roughness=0.0
    )
    tree = material.node_tree
    glass = tree.nodes.new("ShaderNodeBsdfGlass")
    glass.inputs["Roughness"].default_value = 0.0
    mix = tree.nodes.new("ShaderNodeMixShader")
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    first = output.inputs["Surface"].links[0].from_socket
    tree.links.new(first, mix.inputs[1])
    tree.links.new(glass.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    return material


def build(bpy: Any) -> list[str]:
    """Five cubes on a floor, a lamp, a sky; the cubes' names, whose indices are 1, 2, ..."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 75, 21
    add_camera(bpy, (0.0, 0.0, 8.0))
    floor = new_material(bpy, "Floor", "ShaderNodeBsdfDiffuse", Color=(0.5, 0.4, 0.3, 1))
    add_mesh(bpy, "Floor", SQUARE, floor).scale = (4, 3, 1)
    cubes = {
        "Diffuse": new_material(bpy, "D", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.3, 0.2, 1)),
        "Glossy": new_material(
            bpy, "G", "ShaderNodeBsdfGlossy", Color=(0.8, 0.7, 0.4, 1), Roughness=0.4
        ),
        "Frosted": new_material(
            bpy, "F", "ShaderNodeBsdfGlass", Color=(0.8, 0.9, 1, 1), Roughness=0.5, IOR=1.45
        ),
        "Mixture": mixture(bpy),
        "Plastic": new_material(
            bpy, "P", "ShaderNodeBsdfPrincipled", Base_Color=(0.2, 0.5, 0.7, 1), Roughness=0.5
        ),
    }
    # Several scatterings within one surface: Cycles loses 1.2 % of this cube in a white furnace
    # and 6 % of the lamp's light through it, where we lose less than 0.01 % of the former.
    tree = cubes["Frosted"].node_tree
    glass = next(node for node in tree.nodes if node.type == "BSDF_GLASS")
    glass.distribution = "GGX"
    for k, (name, material) in enumerate(cubes.items()):
        cube = add_cube(bpy, name, material)
        cube.location, cube.rotation_euler = (1.1 * (k - 2), 0.0, 0.8), (0.5, 0.4, 0.2)
        cube.scale, cube.pass_index = (0.3, 0.3, 0.3), k + 1
    lamp = add_light(bpy, "AREA", energy=120.0)
    lamp.location, lamp.data.size = (0.0, -1.0, 4.0), 1.5
    world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    scene.world = world
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.6, 1)
    for kind in SHORT:
        for way in WAYS:
            toggle = f"use_pass_{kind}_{way}".lower()
            setattr(bpy.context.view_layer, toggle, True)
    for toggle in ("object_index", "emit", "environment"):
        setattr(bpy.context.view_layer, f"use_pass_{toggle}", True)
    return list(cubes)


def rendered(bpy: Any, engine: str, folder: Path) -> dict[str, np.ndarray]:
    """Passes by their names since 5.0."""
    bpy.context.scene.render.engine = engine
    save_exr(bpy, folder / f"{engine}.exr")
    headless_render(bpy)
    passes = {k.split(".")[1]: v for k, v in read_exr(folder / f"{engine}.exr").items()}
    return {OLD.get(name, name): value for name, value in passes.items()}


def light(passes: dict[str, np.ndarray], kind: str, way: str, cube: np.ndarray) -> np.ndarray:
    """Mean light (3,) of one kind on a cube."""
    return (passes[f"{kind} {way}"] * passes[f"{kind} Color"])[cube].mean(axis=0)


@pytest.mark.slow
def test_kinds_of_light_are_those_of_cycles(bpy: Any, tmp_path: Path) -> None:
    if bpy is None:
        return
    import addon_utils

    cubes = build(bpy)
    addon_utils.enable("cycles")
    scene = bpy.context.scene
    cycles = scene.cycles
    cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = 4096, False, False
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 32
    cycles.transmission_bounces, cycles.blur_glossy, cycles.sample_clamp_indirect = 32, 0, 0
    scene.photon_map.passes = 200
    theirs = rendered(bpy, "CYCLES", tmp_path)
    ours = rendered(bpy, "PHOTONMAP", tmp_path)
    total = ours["Emission"] + ours["Environment"]
    for kind in SHORT:
        both = ours[f"{kind} Direct"] + ours[f"{kind} Indirect"]
        total = total + both * ours[f"{kind} Color"]
    np.testing.assert_allclose(total, ours["Combined"][..., :3], rtol=1e-3, atol=1e-5)
    for k, name in enumerate(cubes):
        cube = ours["Object Index"][..., 0] == k + 1
        whole = theirs["Combined"][cube][:, :3].mean()
        for kind in SHORT:
            for way in ("Direct", "Indirect"):
                expected = light(theirs, kind, way, cube)
                found = light(ours, kind, way, cube)
                told = f"{name}: {kind} {way}"
                assert found == pytest.approx(expected, rel=0.05, abs=0.01 * whole), told
