"""The camera, the image's size, and the render settings."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from tests.blender.support import add_camera, export, link


def test_lens_sensor_and_shift(bpy: Any) -> None:
    camera = add_camera(bpy, (1.0, 2.0, 3.0))
    camera.rotation_euler = (0.0, 0.0, math.pi / 2)
    data = camera.data
    data.lens, data.sensor_width, data.sensor_height = 35.0, 30.0, 20.0
    data.sensor_fit = "VERTICAL"
    data.shift_x, data.shift_y = 0.1, -0.2
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = 333, 111
    render.resolution_percentage = 50
    render.pixel_aspect_x, render.pixel_aspect_y = 1.0, 2.0
    got = export(bpy).scene.camera
    assert (got.width, got.height) == (166, 55), "Blender rounds down"
    assert (got.lens, got.sensor_width, got.sensor_height) == (35.0, 30.0, 20.0)
    assert got.sensor_fit == "VERTICAL"
    assert (got.shift_x, got.shift_y) == pytest.approx((0.1, -0.2))
    assert (got.pixel_aspect_x, got.pixel_aspect_y) == (1.0, 2.0)
    assert got.lens_radius == 0.0
    assert got.matrix[:3, 3] == pytest.approx([1.0, 2.0, 3.0])
    assert got.matrix[:3, 0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-6)


def test_depth_of_field(bpy: Any) -> None:
    camera = add_camera(bpy)
    dof = camera.data.dof
    dof.use_dof = True
    dof.aperture_fstop = 2.0
    dof.focus_distance = 3.5
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 6, 0.5, 2.0
    got = export(bpy).scene.camera
    assert got.lens_radius == pytest.approx(50e-3 / 4)
    assert got.focus_distance == pytest.approx(3.5)
    assert (got.blades, got.blade_rotation, got.blade_ratio) == (6, 0.5, 2.0)


def test_focus_object_counts_along_the_axis(bpy: Any) -> None:
    camera = add_camera(bpy, (0.0, 0.0, 5.0))
    target = link(bpy, bpy.data.objects.new("Target", None))
    target.location = (3.0, 0.0, 1.0)
    camera.data.dof.use_dof = True
    camera.data.dof.focus_object = target
    assert export(bpy).scene.camera.focus_distance == pytest.approx(4.0)


def test_focus_on_a_bone(bpy: Any) -> None:
    camera = add_camera(bpy, (0.0, 0.0, 5.0))
    bpy.ops.object.armature_add(enter_editmode=True)
    armature = bpy.context.object
    armature.data.edit_bones[0].head = (0.0, 0.0, 2.0)
    armature.data.edit_bones[0].tail = (0.0, 0.0, 3.0)
    name = armature.data.edit_bones[0].name
    bpy.ops.object.mode_set(mode="OBJECT")
    camera.data.dof.focus_object = armature
    camera.data.dof.focus_subtarget = name
    assert export(bpy).scene.camera.focus_distance == pytest.approx(3.0)


def test_animated_values_are_those_of_the_frame(bpy: Any) -> None:
    camera = add_camera(bpy)
    for frame, x, lens in ((1, 0.0, 50.0), (11, 10.0, 100.0)):
        camera.location.x = x
        camera.keyframe_insert("location", frame=frame)
        camera.data.lens = lens
        camera.data.keyframe_insert("lens", frame=frame)
    bpy.context.scene.frame_set(11)
    got = export(bpy).scene.camera
    assert got.lens == 100.0
    assert got.matrix[0, 3] == pytest.approx(10.0)


def test_no_camera_is_an_error(bpy: Any) -> None:
    with pytest.raises(RuntimeError, match="(?i)camera"):
        export(bpy)


def test_a_panoramic_camera_is_an_error_that_names_it(bpy: Any) -> None:
    camera = add_camera(bpy)
    camera.name = "My camera"
    camera.data.type = "PANO"
    with pytest.raises(RuntimeError, match="'My camera' is pano"):
        export(bpy)


def test_orthographic(bpy: Any) -> None:
    camera = add_camera(bpy)
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = 7.5
    camera.data.dof.use_dof = True
    camera.data.dof.aperture_fstop = 4.0
    got = export(bpy).scene.camera
    assert (got.kind, got.ortho_scale) == ("ORTHOGRAPHIC", 7.5)
    # Cycles takes the lens of an orthographic camera as 1 m.
    assert got.lens_radius == pytest.approx(1 / 8)
    assert export(bpy).warnings == ()


def test_clipping(bpy: Any) -> None:
    camera = add_camera(bpy)
    camera.data.clip_start, camera.data.clip_end = 4.5, 5.0
    got = export(bpy)
    assert (got.scene.camera.clip_start, got.scene.camera.clip_end) == (4.5, 5.0)
    assert got.warnings == ()


def test_settings_of_the_scene(bpy: Any) -> None:
    add_camera(bpy)
    scene = bpy.context.scene
    values = {
        "passes": 3,
        "seconds": 4.5,
        "error_goal": 0.25,
        "seed": 9,
        "photons_global": 1000,
        "photons_caustic": 2000,
        "light_samples": 2,
        "gather_rays": 3,
        "camera_depth": 5,
        "photon_depth": 6,
        "min_throughput": 0.5,
        "caustic_radius": 4.0,
        "alpha": 0.75,
        "pixel_filter": "GAUSSIAN",
        "exposure": 1.5,
    }
    scene.photon_map.photons_automatic = False
    scene.render.threads_mode, scene.render.threads = "FIXED", 3
    for name, value in values.items():
        setattr(scene.photon_map, name, value)
    scene.render.filter_size = 2.5
    scene.render.film_transparent = True
    got = export(bpy).settings
    assert {name: getattr(got, name) for name in values} == values
    assert got.filter_width == 2.5
    assert got.threads == 3
    assert got.transparent
    assert got.region is None
    overridden = export(bpy, passes=8, chunk_size=77).settings
    assert (overridden.passes, overridden.chunk_size, overridden.seed) == (8, 77, 9)


def test_threads_and_photons_are_automatic_by_default(bpy: Any) -> None:
    add_camera(bpy)
    got = export(bpy).settings
    assert (got.threads, got.photons_global, got.photons_caustic) == (0, -1, -1)
    assert (got.light_samples, got.gather_rays) == (-1, -1)


def test_a_box_is_one_pixel_wide_unless_asked_otherwise(bpy: Any) -> None:
    add_camera(bpy)
    bpy.context.scene.render.filter_size = 2.5
    bpy.context.scene.photon_map.pixel_filter = "BOX"
    assert export(bpy).settings.filter_width == 1.0
    assert export(bpy, pixel_filter="GAUSSIAN").settings.filter_width == 2.5
    assert export(bpy, filter_width=3.0).settings.filter_width == 3.0
    bpy.context.scene.photon_map.pixel_filter = "GAUSSIAN"
    bpy.context.scene.render.filter_size = 0.0  # Blender allows it
    assert export(bpy).settings.filter_width == 0.01


def test_a_setting_out_of_range_is_an_error(bpy: Any) -> None:
    add_camera(bpy)
    with pytest.raises(RuntimeError, match="passes is 0"):
        export(bpy, passes=0)


def test_settings_survive_saving(bpy: Any, tmp_path: Any) -> None:
    add_camera(bpy)
    bpy.context.scene.photon_map.passes = 5
    bpy.context.scene.photon_map.pixel_filter = "GAUSSIAN"
    path = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert bpy.context.scene.photon_map.passes == 5
    assert bpy.context.scene.photon_map.pixel_filter == "GAUSSIAN"
    assert np.isclose(bpy.context.scene.photon_map.alpha, 2 / 3)
