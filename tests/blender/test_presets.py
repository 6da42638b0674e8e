"""The presets that Blender executes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.blender.support import ROOT

PRESETS = {
    path.stem: path for path in (ROOT / "addon/presets/photon_map/sampling").glob("*.py")
}


def chosen(bpy: Any, name: str) -> dict[str, Any]:
    """Execute a preset; the values it leaves."""
    from photon_map.addon.ui.presets import SETTINGS

    bpy.utils.execfile(str(PRESETS[name]))
    return {key: getattr(bpy.context.scene.photon_map, key) for key in SETTINGS}


def test_blender_finds_them(bpy: Any) -> None:
    folders = bpy.utils.preset_paths("photon_map/sampling")
    assert str(PRESETS["Default"].parent) in [str(Path(folder)) for folder in folders]
    assert set(PRESETS) == {"Preview", "Default", "Caustics", "Final"}


def test_each_sets_everything(bpy: Any) -> None:
    from photon_map.addon.ui.presets import SETTINGS

    for name, path in PRESETS.items():
        lines = path.read_text("utf-8").splitlines()
        assigned = {
            line.split(" = ")[0].removeprefix("settings.")
            for line in lines
            if line.startswith("settings.")
        }
        assert assigned == set(SETTINGS), name


def test_default_is_the_default(bpy: Any) -> None:
    own = bpy.context.scene.photon_map
    before = {key: getattr(own, key) for key in chosen_names()}
    chosen(bpy, "Final")
    assert chosen(bpy, "Default") == before


def chosen_names() -> tuple[str, ...]:
    from photon_map.addon.ui.presets import SETTINGS

    return tuple(SETTINGS)


def test_values_are_accepted_by_the_core(bpy: Any) -> None:
    from photon_map.addon.export.settings import export_settings

    for name in PRESETS:
        chosen(bpy, name)
        settings = export_settings(bpy.context.scene, {})
        assert settings.passes == bpy.context.scene.photon_map.passes
    quick, best = chosen(bpy, "Preview"), chosen(bpy, "Final")
    assert quick["passes"] < best["passes"]
    assert quick["error_goal"] > best["error_goal"] > 0
