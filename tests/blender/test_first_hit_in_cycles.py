"""Passes of what the camera sees at once, beside those of Cycles on the same scene."""

from __future__ import annotations

import json
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

NEW = {
    "DiffCol": "Diffuse Color", "GlossCol": "Glossy Color", "TransCol": "Transmission Color",
    "IndexOB": "Object Index", "IndexMA": "Material Index", "Env": "Environment",
}  # fmt: skip


def build(bpy: Any) -> None:
    """A floor with a map, plastic, metal, glass, a veil and a lamp of mesh before a sky."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 48, 36
    add_camera(bpy, (0.0, -0.2, 6.0))
    brown = new_material(bpy, "Brown", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.3, 0.1, 1))
    brown.pass_index = 7
    floor = add_mesh(bpy, "Floor", SQUARE, brown, uv=True)
    floor.scale, floor.pass_index = (3, 2, 1), 3
    node = "ShaderNodeBsdfPrincipled"
    plastic = new_material(bpy, "Plastic", node, Base_Color=(0.2, 0.5, 0.7, 1), Roughness=0.4)
    metal = new_material(
        bpy, "Metal", node, Base_Color=(0.9, 0.5, 0.2, 1), Roughness=0.3, Metallic=1.0
    )
    glass = new_material(
        bpy, "Glass", "ShaderNodeBsdfGlass", Color=(0.9, 0.95, 1, 1), Roughness=0.0, IOR=1.5
    )
    for x, name, material in (
        (-1.4, "Part", plastic),
        (0, "Metal", metal),
        (1.4, "Ice", glass),
    ):
        cube = add_cube(bpy, name, material)
        cube.location, cube.rotation_euler = (x, 0.6, 1.0), (0.4, 0.3, 0.2)
        cube.scale = (0.45, 0.45, 0.45)
    bpy.data.objects["Metal"].parent = bpy.data.objects["Part"]
    bpy.data.objects["Metal"].location = (2.5, 1.0, -0.5)
    bpy.data.objects["Metal"].scale = (1, 1, 1)
    veil = add_mesh(bpy, "Veil", SQUARE, new_material(bpy, "Veil", node, Alpha=0.3))
    veil.location, veil.scale = (-1.2, -0.9, 0.8), (0.6, 0.5, 1)
    glow = new_material(bpy, "Glow", "ShaderNodeEmission", Strength=2.0, Color=(1, 0.5, 0.2, 1))
    lamp = add_mesh(bpy, "Lamp", SQUARE, glow)
    lamp.location, lamp.scale = (1.0, -0.9, 0.8), (0.5, 0.5, 1)
    add_light(bpy, "SUN", energy=2.0).rotation_euler = (0.4, 0.3, 0)
    world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    scene.world = world
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.6, 1)
    mist = world.mist_settings
    mist.start, mist.depth, mist.falloff = 4.0, 3.0, "QUADRATIC"
    layer = bpy.context.view_layer
    for toggle in (
        "z", "mist", "position", "normal", "uv", "object_index", "material_index",
        "diffuse_color", "glossy_color", "transmission_color", "environment",
        "cryptomatte_object", "cryptomatte_material", "cryptomatte_asset",
    ):  # fmt: skip
        setattr(layer, f"use_pass_{toggle}", True)
    layer.photon_map.use_pass_denoising = True


def rendered(bpy: Any, engine: str, folder: Path) -> tuple[dict[str, np.ndarray], dict]:
    """Passes by their names since 5.0, and the file's metadata."""
    import OpenEXR

    bpy.context.scene.render.engine = engine
    save_exr(bpy, folder / f"{engine}.exr")
    headless_render(bpy)
    passes = {k.split(".")[1]: v for k, v in read_exr(folder / f"{engine}.exr").items()}
    with OpenEXR.File(str(folder / f"{engine}.exr")) as file:
        header = dict(file.parts[0].header)
    return {NEW.get(name, name): value for name, value in passes.items()}, header


@pytest.fixture
def both(bpy: Any, tmp_path: Path) -> Any:
    """(Cycles', ours, their metadata) of the scene."""
    if bpy is None:
        return None
    import addon_utils

    build(bpy)
    addon_utils.enable("cycles")
    scene = bpy.context.scene
    bpy.context.view_layer.cycles.denoising_store_passes = True
    scene.cycles.samples, scene.cycles.use_denoising = 512, False
    scene.cycles.use_adaptive_sampling = False
    # 128 paths at least where the picture is even, which has half as many as the mean.
    scene.photon_map.passes = 256
    cycles = rendered(bpy, "CYCLES", tmp_path)
    ours = rendered(bpy, "PHOTONMAP", tmp_path)
    return cycles[0], ours[0], cycles[1], ours[1]


def test_first_hits_are_those_of_cycles(bpy: Any, both: Any) -> None:
    """Pixel by pixel where one surface alone is seen: there both engines have no noise."""
    cycles, ours, _, _ = both
    ranks = [image["CryptoObject00"] for image in (cycles, ours)]
    alone = (ranks[0][..., 1] > 0.999) & (ranks[1][..., 1] > 0.999)
    assert alone.mean() > 0.5
    same = ranks[0][..., 0] == ranks[1][..., 0]
    assert same[alone].all()
    #: Depth and position are those of one random place of the pixel and its filter, which
    #: covers 0.3 m of a steep face; the others are means over 128 and 512 places, which
    #: differ by noise on the edges of the cubes.
    tolerances = {
        "Depth": 0.3, "Position": 0.3, "Mist": 0.01, "Normal": 0.1, "UV": 0.003,
        "Object Index": 0.0, "Material Index": 0.0, "Diffuse Color": 0.02,
        "Glossy Color": 0.02, "Transmission Color": 0.02,
    }  # fmt: skip
    for name, tolerance in tolerances.items():
        gap = np.abs(cycles[name] - ours[name]).max(axis=2)[alone]
        assert gap.max() <= tolerance, f"{name}: {gap.max()}"
        if name not in ("Depth", "Position"):
            assert np.percentile(gap, 90) < 3e-3, name
        assert np.ptp(ours[name][alone]) > 0.1, name
    for name in ("CryptoMaterial00", "CryptoAsset00"):
        assert (cycles[name][..., 0] == ours[name][..., 0])[alone].all(), name
    # Through the veil both sum what shows, and the sky is seen beside the floor.
    for name in ("Mist", "Environment", "Diffuse Color"):
        assert ours[name].mean() == pytest.approx(cycles[name].mean(), rel=0.03), name


def test_coverages_and_manifests_are_those_of_cycles(bpy: Any, both: Any) -> None:
    cycles, ours, theirs, own = both
    for name in ("CryptoObject", "CryptoMaterial", "CryptoAsset"):
        sums = [
            np.sort([image[f"{name}{k:02d}"][..., c] for k in range(3) for c in (1, 3)], axis=0)
            for image in (cycles, ours)
        ]
        # 256 and 64 samples at random places of a pixel: 0.1 is over three deviations.
        assert np.percentile(np.abs(sums[0] - sums[1]), 99) < 0.1
        keys = [
            k for k in own if k.startswith("cryptomatte/") and own[k] == f"ViewLayer.{name}"
        ]
        assert len(keys) == 1
        key = keys[0].removesuffix("/name")
        assert theirs[f"{key}/name"] == own[f"{key}/name"]
        for field in ("hash", "conversion"):
            assert theirs[f"{key}/{field}"] == own[f"{key}/{field}"]
        names = [json.loads(header[f"{key}/manifest"]) for header in (theirs, own)]
        # Cycles writes hashes of which one bit is turned in the picture for some names.
        turned = 1 << 23
        for word, number in names[1].items():
            assert int(names[0][word], 16) | turned == int(number, 16) | turned


def test_denoising_data_show_what_is_seen_through_glass(bpy: Any, both: Any) -> None:
    cycles, ours, _, _ = both
    index = ours["CryptoObject00"]
    floor = (ours["Object Index"][..., 0] == 3) & (index[..., 1] > 0.999)
    floor &= cycles["CryptoObject00"][..., 1] > 0.999
    assert floor.sum() > 100
    assert ours["Denoising Normal"][floor] == pytest.approx(
        cycles["Denoising Normal"][floor], abs=1e-3
    )
    assert ours["Denoising Albedo"][floor] == pytest.approx(
        cycles["Denoising Albedo"][floor], abs=0.01
    )
    # Cycles counts from where the camera begins to see.
    clip = bpy.context.scene.camera.data.clip_start
    assert ours["Denoising Depth"][floor] == pytest.approx(
        cycles["Denoising Depth"][floor] + clip, abs=0.02
    )
    clear = ours["Transmission Color"].min(axis=2) > 0.7
    assert clear.sum() > 20
    albedo = ours["Denoising Albedo"][clear]
    assert albedo.max() > 0.3, "the floor behind the glass"
    assert np.abs(albedo.mean() - cycles["Denoising Albedo"][clear].mean()) < 0.1
