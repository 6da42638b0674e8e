"""The way in from plain Python: files in, images out, errors in words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blender.support import add_camera, add_cube, add_light, new_material


@pytest.fixture
def blend(bpy: Any, tmp_path: Path) -> Any:
    """A file with a white cube in front of the camera, lit by a sun."""
    if bpy is None:
        return None
    add_camera(bpy)
    add_cube(bpy, "Cube", new_material(bpy, "M", "ShaderNodeBsdfDiffuse"))
    add_light(bpy, "SUN", energy=3.0)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 64, 48
    scene.photon_map.passes = 50
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return path


def test_export(bpy: Any, blend: Path) -> None:
    from photon_map.addon import headless

    exported = headless.export_file(blend, overrides={"seed": 3, "passes": None})
    assert exported.scene.object_names == ("Cube",)
    assert exported.scene.light_names == ("Light",)
    assert exported.scene.camera.width == 64
    assert (exported.settings.seed, exported.settings.passes) == (3, 50)
    assert exported.warnings == ()


def test_render_to_png(bpy: Any, blend: Path, tmp_path: Path) -> None:
    from photon_map.addon import headless

    phases: list[str] = []
    out = tmp_path / "new folder" / "image #1.png"
    rendered = headless.render_file(
        blend,
        size=(20, 10),
        overrides={"passes": 3},
        png_path=out,
        on_update=lambda update: phases.append(update.phase),
    )
    assert rendered.update.passes == 3
    assert rendered.update.film.resolve("combined").shape == (10, 20, 4)
    assert rendered.scene.camera.width == 20
    assert rendered.settings.passes == 3
    assert phases[0] == "setup"
    assert phases[-1] == "done"
    assert [path.name for path in out.parent.iterdir()] == ["image #1.png"]
    image = bpy.data.images.load(str(out))
    assert tuple(image.size) == (20, 10)
    pixels = np.array(image.pixels[:]).reshape(10, 20, 4)
    assert pixels[5, 10, 0] > 0.3, "lit"
    assert pixels[0, 0, 0] == 0.0, "black background"


def test_the_caller_may_end_the_render(bpy: Any, blend: Path, tmp_path: Path) -> None:
    from photon_map.addon import headless

    out = tmp_path / "out.png"
    rendered = headless.render_file(
        blend,
        overrides={"passes": 1_000_000},
        png_path=out,
        on_update=lambda update: update.passes >= 2,
    )
    assert 2 <= rendered.update.passes < 1000
    assert out.is_file()
    out.unlink()
    with pytest.raises(headless.HeadlessError, match="before its first pass"):
        headless.render_file(blend, png_path=out, on_update=lambda update: True)
    assert not out.exists()


def test_the_view_transform_of_the_file_counts(bpy: Any, blend: Path, tmp_path: Path) -> None:
    from photon_map.addon import headless

    means = {}
    for exposure in (0.0, -2.0):
        bpy.ops.wm.open_mainfile(filepath=str(blend))
        bpy.context.scene.view_settings.exposure = exposure
        path = tmp_path / f"{exposure}.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        out = tmp_path / f"{exposure}.png"
        headless.render_file(path, size=(8, 8), overrides={"passes": 1}, png_path=out)
        pixels = np.array(bpy.data.images.load(str(out)).pixels[:])
        means[exposure] = pixels.reshape(8, 8, 4)[..., :3].mean()
    assert means[-2.0] < 0.8 * means[0.0]


def test_frame(bpy: Any, blend: Path) -> None:
    from photon_map.addon import headless

    bpy.ops.wm.open_mainfile(filepath=str(blend))
    cube = bpy.data.objects["Cube"]
    for frame, x in ((1, 0.0), (5, 8.0)):
        cube.location.x = x
        cube.keyframe_insert("location", frame=frame)
    bpy.ops.wm.save_mainfile()
    exported = headless.export_file(blend, frame=5)
    assert exported.scene.vertices[:, 0].mean() == pytest.approx(8.0)


def test_a_file_of_another_engine_is_rendered_with_ours(bpy: Any, blend: Path) -> None:
    from photon_map.addon import headless

    bpy.ops.wm.open_mainfile(filepath=str(blend))
    bpy.context.scene.render.engine = "CYCLES"
    bpy.ops.wm.save_mainfile()
    rendered = headless.render_file(blend, size=(4, 4), overrides={"passes": 1})
    assert rendered.update.passes == 1


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.blend", None, "there is no file"),
        (".", None, "is not a file"),
        ("text.blend", b"hello", "cannot open"),
        ("empty.blend", b"", "cannot open"),
        ("cut.blend", b"BLENDER17-01v0500", "cannot open"),
    ],
)
def test_files_that_cannot_be_read(
    bpy: Any, tmp_path: Path, name: str, content: bytes | None, message: str
) -> None:
    from photon_map.addon import headless

    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    out = tmp_path / "out.png"
    with pytest.raises(headless.HeadlessError, match=message) as caught:
        headless.render_file(path, png_path=out)
    assert str(path) in str(caught.value)
    assert not out.exists()


def test_an_error_leaves_an_older_image_alone(bpy: Any, blend: Path, tmp_path: Path) -> None:
    from photon_map.addon import headless

    out = tmp_path / "out.png"
    out.write_bytes(b"older")
    with pytest.raises(headless.HeadlessError, match="camera_depth is 0"):
        headless.render_file(blend, overrides={"camera_depth": 0}, png_path=out)
    assert out.read_bytes() == b"older"


def test_an_unknown_setting_is_an_error(bpy: Any, blend: Path) -> None:
    from photon_map.addon import headless

    with pytest.raises(headless.HeadlessError, match="colour"):
        headless.export_file(blend, overrides={"colour": 3})


def test_no_camera(bpy: Any, tmp_path: Path) -> None:
    from photon_map.addon import headless

    path = tmp_path / "none.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    with pytest.raises(headless.HeadlessError, match="(?i)camera"):
        headless.render_file(path, png_path=tmp_path / "out.png")
    assert not (tmp_path / "out.png").exists()


def test_no_enabled_view_layer(bpy: Any, blend: Path, tmp_path: Path) -> None:
    from photon_map.addon import headless

    bpy.ops.wm.open_mainfile(filepath=str(blend))
    bpy.context.view_layer.use = False
    bpy.ops.wm.save_mainfile()
    with pytest.raises(headless.HeadlessError, match="no view layer"):
        headless.render_file(blend, png_path=tmp_path / "out.png")
    assert not (tmp_path / "out.png").exists()


def test_video_strips_do_not_take_the_place_of_the_scene(
    bpy: Any, blend: Path, tmp_path: Path
) -> None:
    from photon_map.addon import headless

    bpy.ops.wm.open_mainfile(filepath=str(blend))
    editor = bpy.context.scene.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences
    span = {"length": 9} if bpy.app.version >= (5, 0, 0) else {"frame_end": 9}
    strips.new_effect(name="Grey", type="COLOR", channel=1, frame_start=1, **span)
    bpy.ops.wm.save_mainfile()
    out = tmp_path / "out.png"
    rendered = headless.render_file(blend, size=(8, 8), overrides={"passes": 1}, png_path=out)
    assert rendered.update.passes == 1
    assert out.is_file()


def test_the_film_is_that_of_the_png(bpy: Any, blend: Path, tmp_path: Path) -> None:
    """With two view layers: the first one rendered, in both."""
    from photon_map.addon import headless

    bpy.ops.wm.open_mainfile(filepath=str(blend))
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Raw"
    empty = scene.view_layers.new("Empty")
    for child in (scene.collection.objects["Cube"],):
        group = bpy.data.collections.new("Group")
        scene.collection.children.link(group)
        scene.collection.objects.unlink(child)
        group.objects.link(child)
    empty.layer_collection.children["Group"].exclude = True
    bpy.ops.wm.save_mainfile()
    out = tmp_path / "out.png"
    rendered = headless.render_file(blend, size=(8, 8), overrides={"passes": 2}, png_path=out)
    film = rendered.update.film.resolve("combined")[..., 0]
    pixels = np.array(bpy.data.images.load(str(out)).pixels[:]).reshape(8, 8, 4)[..., 0]
    assert film.max() > 0.5
    assert pixels == pytest.approx(np.clip(film, 0, 1), abs=0.01)
    assert any("view layer 'Empty'" in text for text in rendered.warnings)
