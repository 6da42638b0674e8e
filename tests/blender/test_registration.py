"""The add-on registers, unregisters and leaves nothing behind."""

from __future__ import annotations

import subprocess
import sys
from types import FunctionType, SimpleNamespace
from typing import Any

from tests.blender.support import ROOT

HEAVY = ("numba", "scipy", "embreex", "llvmlite")


def test_the_engine_is_registered_with_its_label(bpy: Any) -> None:
    engines = [
        engine
        for engine in bpy.types.RenderEngine.__subclasses__()
        if getattr(engine, "bl_idname", "") == "PHOTONMAP"
    ]
    assert [engine.bl_label for engine in engines] == ["Photon Map"]
    bpy.context.scene.render.engine = "PHOTONMAP"
    assert bpy.context.scene.render.engine == "PHOTONMAP"


def test_registering_loads_no_heavy_package(bpy: Any) -> None:
    """In a process of its own: the other tests of this file may have rendered.

    Not even NumPy, which takes twice as long as all the rest; Blender's module has it already,
    so it is hidden.
    """
    code = f"""
import os, sys, importlib.util
import bpy
sys.modules["numpy"] = None
spec = importlib.util.spec_from_file_location(
    "photon_map", r"{ROOT}/__init__.py", submodule_search_locations=[r"{ROOT}"])
package = importlib.util.module_from_spec(spec)
sys.modules["photon_map"] = package
spec.loader.exec_module(package)
assert not [name for name in sys.modules if name.startswith("photon_map.")]
package.register()
import photon_map.addon.headless
loaded = [name for name in {HEAVY!r} if name in sys.modules]
print("loaded:", loaded, flush=True)
os._exit(len(loaded))
"""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=100
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_unregister_leaves_nothing(bpy: Any) -> None:
    import photon_map
    from photon_map.addon import is_registered
    from photon_map.addon.ui import stock

    assert any("PHOTONMAP" in panel.COMPAT_ENGINES for panel in stock._panels())
    photon_map.unregister()
    try:
        assert not is_registered()
        assert not hasattr(bpy.types.Scene, "photon_map")
        assert not hasattr(bpy.types.ViewLayer, "photon_map")
        assert not [name for name in dir(bpy.types) if name.startswith("PHOTONMAP_")]
        assert not any("PHOTONMAP" in panel.COMPAT_ENGINES for panel in stock._panels())
    finally:
        photon_map.register()
    assert is_registered()


def test_properties_have_the_defaults_and_ranges_of_the_core(bpy: Any) -> None:
    import math

    from photon_map.addon.export.settings import FIELDS
    from photon_map.core.settings import _RANGES, Settings

    properties = bpy.context.scene.photon_map.bl_rna.properties
    settings = Settings()
    for name in FIELDS:
        entry = properties[name]
        default = getattr(settings, name)
        if entry.type in ("ENUM", "BOOLEAN"):
            assert entry.default == default
            continue
        assert math.isclose(entry.default, default, rel_tol=1e-6), name
        low, high = _RANGES[name]
        assert entry.hard_min >= low - 1e-6, name
        assert entry.hard_max <= high * (1 + 1e-6), name


def test_enum_items_keep_their_numbers(bpy: Any) -> None:
    """Files store the numbers: they may never change."""
    items = bpy.context.scene.photon_map.bl_rna.properties["pixel_filter"].enum_items
    assert {item.identifier: item.value for item in items} == {
        "BOX": 0,
        "GAUSSIAN": 1,
        "BLACKMAN_HARRIS": 2,
    }


def test_stock_panels_are_shown(bpy: Any) -> None:
    """Those the user needs are there; a background Blender has all panel classes."""
    from photon_map.addon.ui import stock

    shown = {p.__name__ for p in stock._panels() if "PHOTONMAP" in p.COMPAT_ENGINES}
    present = {name for name in stock.JOINED if hasattr(bpy.types, name)}
    assert len(present) >= 3
    assert present <= shown
    assert {"RENDER_PT_format", "DATA_PT_camera", "RENDER_PT_color_management"} <= shown
    assert not shown & set(stock.LEFT_OUT)


def test_own_panels_draw(bpy: Any) -> None:
    """Draw each panel onto a layout that checks that the properties exist."""
    from photon_map.addon import ui
    from photon_map.addon.insight import remember
    from photon_map.addon.ui.panel import PhotonMapPanel

    class Layout:
        def __getattr__(self, name: str) -> Any:
            return lambda *args, **kwargs: self

        def prop(self, owner: Any, name: str, **_: Any) -> None:
            assert name in owner.bl_rna.properties, f"{owner} has no {name}"
            own = type(owner).__name__.startswith("PhotonMap")
            assert owner.bl_rna.properties[name].description or not own, name

    class Context:
        engine = "PHOTONMAP"
        scene = bpy.context.scene
        view_layer = bpy.context.view_layer
        light: Any = None
        material: Any = None
        object: Any = None
        world = bpy.data.worlds.new("W")
        preferences = bpy.context.preferences
        region = SimpleNamespace(width=300)

    drawn = set()
    stage = SimpleNamespace(name="caustics", on=True, reason="1 casters (Ball)")
    plan = SimpleNamespace(stages=[stage], warnings=["a warning of the plan"])
    remember(bpy.context.scene, plan, ["a warning of the export"])
    bpy.context.view_layer.use_pass_mist = True
    meshes = bpy.data.objects.new("M", bpy.data.meshes.new("M"))
    for panel in ui.CLASSES:
        if not issubclass(panel, PhotonMapPanel):
            continue

        class Holder:
            """Stands in for a panel, which only Blender can make."""

            layout = Layout()

            def __getattr__(self, name: str, panel: Any = panel) -> Any:
                found = getattr(panel, name)
                return found.__get__(self) if isinstance(found, FunctionType) else found

        for kind in ("POINT", "SPOT", "SUN", "AREA"):
            Context.light = bpy.data.lights.new("L", kind)
            Context.material = bpy.data.materials.new("M")
            for obj in (meshes, bpy.data.objects.new("L", Context.light)):
                Context.object = obj
                if panel.poll(Context):
                    drawn.add(panel)
                    panel.draw(Holder(), Context)
    assert drawn == {panel for panel in ui.CLASSES if issubclass(panel, PhotonMapPanel)}
