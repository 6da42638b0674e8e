"""The plan in the panel, and the question why there is no caustic."""

from __future__ import annotations

from typing import Any

import pytest

from tests.blender.support import (
    SQUARE,
    add_camera,
    add_cube,
    add_light,
    add_mesh,
    new_material,
)


@pytest.fixture
def cube(bpy: Any) -> Any:
    """A glass cube over a floor, in the light of a lamp, and active."""
    if bpy is None:
        return None
    from photon_map.addon.insight import forget

    forget()
    add_camera(bpy)
    grey = new_material(bpy, "Grey", "ShaderNodeBsdfDiffuse")
    add_mesh(bpy, "Floor", SQUARE, grey).location = (0, 0, -3)
    add_light(bpy, "POINT", energy=10.0).location = (0, 0, 4)
    glass = new_material(bpy, "Glass", "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.5)
    obj = add_cube(bpy, "Cube", glass)
    bpy.context.view_layer.objects.active = obj
    return obj


def answer(bpy: Any, obj: Any) -> str:
    assert bpy.ops.photon_map.why_no_caustic() == {"FINISHED"}
    return str(obj.photon_map.answer)


def test_nothing_stands_in_the_way(bpy: Any, cube: Any) -> None:
    from photon_map.addon.operators import NOTHING_FOUND

    assert answer(bpy, cube) == NOTHING_FOUND


def test_causes_are_named_until_they_are_gone(bpy: Any, cube: Any) -> None:
    cube.photon_map.casts_caustics = False
    bpy.context.scene.photon_map.photon_depth = 2
    assert [line.split(":")[0] for line in answer(bpy, cube).splitlines()] == [
        "Switched off",
        "Depth too low",
    ]
    cube.photon_map.casts_caustics = True
    bpy.context.scene.photon_map.photon_depth = 32
    cube.active_material.node_tree.nodes["Glass BSDF"].inputs["Roughness"].default_value = 0.9
    assert answer(bpy, cube).startswith("Roughness too high: material 'Glass' has a rough")
    cube.hide_render = True
    assert answer(bpy, cube).startswith("Not rendered: it is disabled for renders")


def test_the_question_needs_an_object_with_a_surface(bpy: Any, cube: Any) -> None:
    bpy.context.view_layer.objects.active = bpy.data.objects["Light"]
    assert not bpy.ops.photon_map.why_no_caustic.poll()


def test_a_scene_that_cannot_be_exported_is_an_error(bpy: Any, cube: Any) -> None:
    bpy.context.scene.camera = None
    with pytest.raises(RuntimeError, match="Photon Map: .*no camera"):
        bpy.ops.photon_map.plan()


def test_the_plan_is_kept_with_its_reasons(bpy: Any, cube: Any) -> None:
    from photon_map.addon.insight import insight_of

    assert insight_of(bpy.context.scene) is None
    bpy.context.scene.render.use_motion_blur = True
    bpy.ops.photon_map.plan()
    found = insight_of(bpy.context.scene)
    assert ("caustics", True, "1 casters (Cube)") in found.stages
    assert any("motion blur" in warning for warning in found.warnings)
    assert found.result == ""


def test_a_render_leaves_its_plan_and_its_end(bpy: Any, core: Any) -> None:
    from photon_map.addon.insight import insight_of

    core.warnings = ("the plan warns",)
    bpy.ops.render.render()
    found = insight_of(bpy.context.scene)
    assert "the plan warns" in found.warnings
    assert found.result == "4 passes, 1.0 s, relative error 50.00 %, 1.5 million rays"


def test_another_file_is_another_scene(bpy: Any, cube: Any) -> None:
    from photon_map.addon import insight

    bpy.ops.photon_map.plan()
    assert insight._LATEST
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert not insight._LATEST
