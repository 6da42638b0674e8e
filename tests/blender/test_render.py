"""Whole renders: Blender's scene through the real core into Blender's image."""

from __future__ import annotations

import math
import threading
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

#: Names of passes before Blender 5.0, and since then.
SHORT = {"Diffuse": "Diff", "Glossy": "Gloss", "Transmission": "Trans"}
WAYS = {"Direct": "Dir", "Indirect": "Ind", "Color": "Col"}
OLD = {f"{a}{b}": f"{kind} {way}" for kind, a in SHORT.items() for way, b in WAYS.items()}
OLD |= {"Env": "Environment", "Emit": "Emission"}


@pytest.fixture
def small(bpy: Any) -> Any:
    """A small image of few passes, and a camera 5 m above the origin that looks down."""
    if bpy is None:
        return None
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    scene.photon_map.passes = 4
    scene.photon_map.pixel_filter = "BOX"
    scene.photon_map.photons_automatic = False
    scene.photon_map.photons_global = 4096
    scene.photon_map.photons_caustic = 4096
    return add_camera(bpy)


def combined(bpy: Any, folder: Path) -> np.ndarray:
    save_exr(bpy, folder / "a.exr")
    headless_render(bpy)
    return read_exr(folder / "a.exr")["ViewLayer.Combined"]


def floor(bpy: Any, albedo: float = 0.5) -> Any:
    color = (albedo, albedo, albedo, 1.0)
    material = new_material(bpy, "Floor", "ShaderNodeBsdfDiffuse", Color=color)
    obj = add_mesh(bpy, "Floor", SQUARE, material)
    obj.scale = (10.0, 10.0, 1.0)
    return obj


def test_a_lamp_over_a_floor_is_as_bright_as_it_should_be(
    bpy: Any, small: Any, tmp_path: Path
) -> None:
    """Sun of E W/m^2 on albedo a: radiance E a / pi, with flat ground and no noise."""
    floor(bpy)
    add_light(bpy, "SUN", energy=2.0)
    image = combined(bpy, tmp_path)
    assert image[..., :3] == pytest.approx(2.0 * 0.5 / math.pi, rel=1e-4)
    assert (image[..., 3] == 1.0).all()


def test_a_point_lamp_falls_off_with_the_square(bpy: Any, small: Any, tmp_path: Path) -> None:
    """E = I cos / r^2 with I = P / (4 pi), in every pixel: the camera's geometry is right."""
    floor(bpy)
    lamp = add_light(bpy, "POINT", energy=100.0, shadow_soft_size=0.0)
    lamp.location = (0.5, 0.25, 2.0)
    bpy.context.scene.photon_map.passes = 256
    image = combined(bpy, tmp_path)[..., 0]
    # 36 mm sensor, 50 mm lens, 5 m away: the width of the picture on the floor.
    width = 5.0 * 36.0 / 50.0
    columns, rows = np.meshgrid(np.arange(32) + 0.5, np.arange(24) + 0.5)
    x = (columns / 32 - 0.5) * width
    y = (rows - 12) / 32 * width
    squared = (x - 0.5) ** 2 + (y - 0.25) ** 2 + 4.0
    expected = 0.5 / math.pi * 100.0 / (4 * math.pi) * 2.0 / squared**1.5
    # Averages over pixels of 0.11 m differ from the value at the centre by less than 0.2 %.
    assert image == pytest.approx(expected, rel=0.01)


def test_passes_add_up_to_combined(bpy: Any, small: Any, tmp_path: Path) -> None:
    floor(bpy)
    glass = new_material(bpy, "Glass", "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.5)
    add_cube(bpy, "Cube", glass).location = (0.5, 0.0, 1.5)
    glow = new_material(bpy, "Glow", "ShaderNodeEmission", Strength=5.0)
    lamp = add_mesh(bpy, "Lamp", SQUARE, glow)
    lamp.location, lamp.scale = (-1.2, 0.0, 1.5), (0.3, 0.3, 1.0)
    layer = bpy.context.view_layer
    kinds = [(kind, f"use_pass_{kind.lower()}") for kind in SHORT]
    for _, toggle in kinds:
        for way in ("direct", "indirect", "color"):
            setattr(layer, f"{toggle}_{way}", True)
    for toggle in ("z", "normal", "emit", "environment"):
        setattr(layer, f"use_pass_{toggle}", True)
    save_exr(bpy, tmp_path / "a.exr")
    headless_render(bpy)
    image = {name.split(".")[1]: data for name, data in read_exr(tmp_path / "a.exr").items()}
    if bpy.app.version < (5, 0, 0):
        image |= {new: image[old] for old, new in OLD.items() if old in image}
    total = image["Emission"] + image["Environment"]
    for kind, _ in kinds:
        light = image[f"{kind} Direct"] + image[f"{kind} Indirect"]
        total = total + light * image[f"{kind} Color"]
    assert total == pytest.approx(image["Combined"][..., :3], rel=1e-3, abs=1e-6)
    for name in ("Diffuse Direct", "Diffuse Indirect", "Emission", "Caustics"):
        assert image[name].max() > 0, name
    assert (image["Transmission Direct"] == 0).all(), "glass has two faces"
    assert image["Transmission Indirect"].max() > 0
    assert image["Depth"].min() == pytest.approx(2.5, abs=0.02), "the top of the cube"
    corner = image["Normal"][0, 0]
    assert corner == pytest.approx([0.0, 0.0, 1.0], abs=1e-5)
    assert image["Depth"][0, 0, 0] == pytest.approx(5.0, abs=1e-4), "along the axis"


def test_an_empty_scene_shows_the_world(
    bpy: Any, small: Any, tmp_path: Path, capfd: Any
) -> None:
    world = bpy.data.worlds.new("W")
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    bpy.context.scene.world = world
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    image = combined(bpy, tmp_path)
    assert image[..., :3] == pytest.approx(np.broadcast_to([0.1, 0.2, 0.3], (24, 32, 3)))
    assert (image[..., 3] == 1.0).all()
    assert "no faces" in "".join(capfd.readouterr())


def test_a_scene_without_light_is_black_and_says_so(
    bpy: Any, small: Any, tmp_path: Path, capfd: Any
) -> None:
    floor(bpy)
    image = combined(bpy, tmp_path)
    assert not image[..., :3].any()
    assert (image[..., 3] == 1.0).all()
    assert "no light" in "".join(capfd.readouterr())


def test_without_camera_there_is_an_error_and_no_image(bpy: Any, tmp_path: Path) -> None:
    floor(bpy)
    save_exr(bpy, tmp_path / "a.exr")
    with pytest.raises(RuntimeError, match="(?i)no camera"):
        bpy.ops.render.render(write_still=True)
    assert list(tmp_path.iterdir()) == []


def test_film_transparent(bpy: Any, small: Any, tmp_path: Path) -> None:
    world = bpy.data.worlds.new("W")
    bpy.context.scene.world = world
    bpy.context.scene.render.film_transparent = True
    add_cube(bpy, "Cube", new_material(bpy, "M", "ShaderNodeBsdfDiffuse")).scale = [0.3] * 3
    image = combined(bpy, tmp_path)
    assert not image[0, 0].any()
    assert image[12, 16, 3] == 1.0


def test_a_border_shows_the_same_picture(bpy: Any, small: Any, tmp_path: Path) -> None:
    floor(bpy)
    lamp = add_light(bpy, "POINT", energy=100.0, shadow_soft_size=0.0)
    lamp.location = (0.5, 0.25, 2.0)
    bpy.context.scene.photon_map.passes = 64
    whole = combined(bpy, tmp_path)
    render = bpy.context.scene.render
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_min_y = 0.25, 0.5
    render.border_max_x, render.border_max_y = 0.75, 1.0
    part = combined(bpy, tmp_path)
    assert part.shape == (12, 16, 4)
    assert part == pytest.approx(whole[12:, 8:24], rel=0.02)


def test_two_renders_give_the_same_bits_and_leave_no_thread(
    bpy: Any, small: Any, tmp_path: Path
) -> None:
    floor(bpy)
    add_light(bpy, "AREA", energy=50.0).location = (0.0, 1.0, 3.0)
    add_cube(bpy, "Cube", new_material(bpy, "M", "ShaderNodeBsdfGlass", Roughness=0.0))
    before = threading.active_count()
    bpy.context.scene.render.threads_mode = "FIXED"
    bpy.context.scene.render.threads = 1
    first = combined(bpy, tmp_path)
    bpy.context.scene.render.threads = 2
    second = combined(bpy, tmp_path)
    assert first.any()
    assert np.array_equal(first, second)
    assert threading.active_count() == before


def test_the_noise_of_an_animation_stands_still(bpy: Any, small: Any, tmp_path: Path) -> None:
    """Frames in which nothing moves are the same; a seed with keys makes others of them."""
    floor(bpy)
    add_light(bpy, "AREA", energy=50.0).location = (0.0, 1.0, 3.0)
    scene = bpy.context.scene

    def frame(number: int) -> np.ndarray:
        scene.frame_set(number)
        return combined(bpy, tmp_path)

    first = frame(1)
    assert first.any() and np.array_equal(first, frame(17))
    for number in (1, 17):
        scene.photon_map.seed = number
        assert scene.photon_map.keyframe_insert("seed", frame=number)
    assert not np.array_equal(frame(1), frame(17))


def test_a_cancelled_render_leaves_no_thread(
    bpy: Any, small: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from photon_map.addon import final

    floor(bpy)
    add_light(bpy, "SUN")
    bpy.context.scene.photon_map.passes = 1_000_000
    calls = iter(range(1000))
    monkeypatch.setattr(final, "stopped", lambda engine: next(calls) > 12)
    before = threading.active_count()
    image = combined(bpy, tmp_path)
    assert image[..., :3].min() > 0.1
    assert threading.active_count() == before
