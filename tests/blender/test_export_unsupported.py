"""What is not rendered is said, with names; what Blender leaves out is left out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.blender.support import (
    SQUARE,
    add_camera,
    add_cube,
    add_light,
    add_mesh,
    export,
    link,
    new_material,
)


def warnings(bpy: Any) -> str:
    return "\n".join(export(bpy).warnings)


def test_a_plain_scene_has_no_warning(bpy: Any) -> None:
    add_camera(bpy)
    add_cube(bpy, "Glass", new_material(bpy, "Glass", "ShaderNodeBsdfGlass"))
    add_light(bpy, "SPOT").scale = (2.0, 2.0, 2.0)
    assert warnings(bpy) == ""


def test_glass_that_is_no_closed_body(bpy: Any) -> None:
    add_camera(bpy)
    glass = new_material(bpy, "Glass", "ShaderNodeBsdfGlass")
    add_mesh(bpy, "Pane", SQUARE, glass)
    add_mesh(bpy, "Paper", SQUARE, new_material(bpy, "White", "ShaderNodeBsdfDiffuse"))
    corners, faces = [list(v) for v in SQUARE[0]], SQUARE[1]
    split = corners + [[x, y, 0.0] for x, y, _ in corners]  # two sheets on the same corners
    add_mesh(bpy, "Unwelded", (split, [*faces, (7, 6, 5, 4)]), glass)
    assert warnings(bpy).endswith("inside of it: object 'Pane'")


def test_switches_of_the_scene_and_its_view_layer(bpy: Any) -> None:
    add_camera(bpy)
    bpy.context.scene.render.use_motion_blur = True
    bpy.context.view_layer.use_sky = False
    text = warnings(bpy)
    assert "motion blur" in text
    assert "leaves out Environment is" in text


def test_light_linking(bpy: Any) -> None:
    add_camera(bpy)
    lamp = add_light(bpy, "POINT", "Lamp")
    lamp.light_linking.receiver_collection = bpy.data.collections.new("Lit")
    assert "light linking is ignored: object 'Lamp'" in warnings(bpy)


def test_a_portal_emits_nothing(bpy: Any) -> None:
    add_camera(bpy)
    lamp = add_light(bpy, "AREA", "Window")
    if not hasattr(lamp.data, "cycles"):
        pytest.skip("this Blender has no Cycles")
    lamp.data.cycles.is_portal = True
    got = export(bpy)
    assert got.scene.light_names == ()
    assert "portals are left out, they emit nothing: light 'Window'" in got.warnings


def test_stereo_is_refused(bpy: Any) -> None:
    """Only one eye was rendered, and the other was empty."""
    add_camera(bpy)
    bpy.context.scene.render.use_multiview = True
    with pytest.raises(RuntimeError, match="stereoscopic"):
        export(bpy)


def test_a_volume_without_a_surface_is_not_a_black_box(bpy: Any) -> None:
    add_camera(bpy)
    fog = new_material(bpy, "Fog")
    tree = fog.node_tree
    scatter = tree.nodes.new("ShaderNodeVolumeScatter")
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(scatter.outputs[0], output.inputs["Volume"])
    cube = add_cube(bpy, "Cube", fog, new_material(bpy, "White", "ShaderNodeBsdfDiffuse"))
    cube.data.polygons[0].material_index = 1
    got = export(bpy)
    assert len(got.scene.faces) == 2
    assert "material 'Fog': volume is not supported yet" in "".join(got.warnings)


def test_a_missing_library(bpy: Any, tmp_path: Path) -> None:
    add_camera(bpy)
    cube = add_cube(bpy, "Cube")
    library, user = tmp_path / "library.blend", tmp_path / "user.blend"
    bpy.data.libraries.write(str(library), {cube})
    bpy.data.objects.remove(cube)
    with bpy.data.libraries.load(str(library), link=True) as (source, wanted):
        wanted.objects = source.objects
    link(bpy, wanted.objects[0])
    bpy.ops.wm.save_as_mainfile(filepath=str(user))
    library.unlink()
    bpy.ops.wm.open_mainfile(filepath=str(user))
    text = warnings(bpy)
    assert "library.blend' is missing" in text
    assert "linked data is missing: 'Cube'" in text
