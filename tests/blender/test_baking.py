"""Baking by the operator, and final renders that take the maps beside the file."""

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
    new_material,
)


@pytest.fixture
def saved(bpy: Any, tmp_path: Path) -> Path:
    """A mirror cube over a floor in a file of its own, with few photons."""
    if bpy is None:
        return tmp_path
    add_camera(bpy)
    add_mesh(bpy, "Floor", SQUARE, new_material(bpy, "Grey", "ShaderNodeBsdfDiffuse"))
    add_light(bpy, "POINT", energy=10.0).location = (0, 0, 4)
    metal = new_material(bpy, "Metal", "ShaderNodeBsdfGlossy", Roughness=0.0)
    add_cube(bpy, "Cube", metal).location = (1, 1, 2)
    scene = bpy.context.scene
    scene.render.engine = "PHOTONMAP"
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.photon_map.passes = 2
    scene.photon_map.photons_automatic = False
    scene.photon_map.photons_caustic = scene.photon_map.photons_global = 500
    scene.photon_map_baking.passes = 3
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "flight.blend"))
    return tmp_path / "flight.pmap"


def stages(bpy: Any) -> dict[str, tuple[bool, str]]:
    from photon_map.addon.insight import insight_of

    bpy.ops.render.render()
    found = insight_of(bpy.context.scene)
    return {name: (on, reason) for name, on, reason in found.stages}


def test_a_bake_serves_every_camera_until_something_changes(bpy: Any, saved: Path) -> None:
    assert "photon maps" not in stages(bpy)
    assert bpy.ops.photon_map.bake() == {"FINISHED"}
    assert saved.is_file()
    bpy.context.scene.camera.location.x += 0.3
    assert stages(bpy)["photon maps"] == (True, "4 passes from 'flight.pmap'")
    bpy.context.scene.photon_map_baking.stale = "IGNORE"
    assert "photon maps" not in stages(bpy)
    bpy.data.objects["Cube"].location.x += 0.3
    bpy.context.scene.photon_map_baking.stale = "TRACE"
    on, reason = stages(bpy)["photon maps"]
    assert not on and "object 'Cube' has changed" in reason
    bpy.context.scene.photon_map_baking.stale = "REFUSE"
    with pytest.raises(RuntimeError, match="object 'Cube' has changed"):
        bpy.ops.render.render()
    bpy.context.scene.photon_map_baking.stale = "REBUILD"
    assert stages(bpy)["photon maps"][0]
    bpy.context.scene.photon_map_baking.stale = "REFUSE"
    assert stages(bpy)["photon maps"][0]


def test_a_file_that_was_never_saved_has_no_place_for_maps(bpy: Any) -> None:
    add_camera(bpy)
    bpy.context.scene.render.engine = "PHOTONMAP"
    with pytest.raises(RuntimeError, match="save the file first"):
        bpy.ops.photon_map.bake()


def test_what_cannot_be_exported_is_said(bpy: Any, saved: Path) -> None:
    bpy.context.scene.camera = None
    with pytest.raises(RuntimeError, match="camera"):
        bpy.ops.photon_map.bake()
    assert not saved.exists()
