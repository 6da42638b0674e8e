"""The photon view without a window: what it traces, picks, says, draws and forgets."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from types import FunctionType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.blender.support import SQUARE, add_camera, add_light, add_mesh, new_material


@pytest.fixture
def look(bpy: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A mirror over a floor under a lamp, and the state of the view."""
    if bpy is None:
        yield None
        return
    from photon_map.addon.photon_view import LOOK

    node = "ShaderNodeBsdfDiffuse"
    floor = add_mesh(bpy, "Floor", SQUARE, new_material(bpy, "Floor", node))
    floor.scale = (3, 3, 1)
    glossy = new_material(bpy, "Mirror", "ShaderNodeBsdfGlossy", Roughness=0.0)
    mirror = add_mesh(bpy, "Mirror", SQUARE, glossy)
    mirror.location, mirror.rotation_euler = (-3.0, 0.0, 1.0), (0.0, 1.9, 0.0)
    add_light(bpy, "POINT", energy=50.0).location = (0.5, 0.0, 2.0)
    add_camera(bpy, (0.0, 0.0, 6.0))
    scene = bpy.context.scene
    scene.render.engine = "PHOTONMAP"
    scene.render.resolution_x, scene.render.resolution_y = 32, 24
    scene.photon_map.photons_automatic = False
    scene.photon_map.photons_caustic = scene.photon_map.photons_global = 2000
    bpy.context.view_layer.update()
    yield LOOK
    LOOK.clear()
    wait_until(lambda: not tasks())


def tasks() -> list[threading.Thread]:
    return [t for t in threading.enumerate() if t.name == "photon_map_photons"]


def wait_until(done: Any) -> None:
    limit = time.monotonic() + 300
    while not done():
        assert time.monotonic() < limit
        time.sleep(0.01)


def fetch(look: Any) -> None:
    """What the timer does once the thread is through."""
    wait_until(lambda: not tasks())
    assert look.look() is None


class Layout:
    """Takes what panels draw; properties must exist."""

    def __init__(self) -> None:
        self.words: list[str] = []

    def __getattr__(self, name: str) -> Any:
        return lambda *args, **kwargs: self

    def label(self, text: str = "", **_: Any) -> None:
        self.words.append(text)

    def prop(self, owner: Any, name: str, **_: Any) -> None:
        assert owner.bl_rna.properties[name].description


def words_of(bpy: Any, panel: Any, **changes: Any) -> str:
    """What ``panel`` says."""
    context = {
        "scene": bpy.context.scene,
        "window_manager": bpy.context.window_manager,
        "preferences": bpy.context.preferences,
        "region": SimpleNamespace(width=2000),
    }

    class Holder:
        layout = Layout()

        def __getattr__(self, name: str) -> Any:
            found = getattr(panel, name)
            return found.__get__(self) if isinstance(found, FunctionType) else found

    holder = Holder()
    panel.draw(holder, SimpleNamespace(**(context | changes)))
    return " | ".join(holder.layout.words)


def test_photons_are_traced_and_drawn(bpy: Any, look: Any) -> None:
    from photon_map.addon.photon_view.cloud import cloud_of
    from photon_map.addon.photon_view.panel import PHOTONMAP_VIEW3D_PT_photons as Panel

    own = bpy.context.window_manager.photon_map_photons
    assert not look.is_on(bpy.context.scene)
    assert bpy.ops.photon_map.toggle_photons() == {"FINISHED"}
    assert look.is_on(bpy.context.scene) and cloud_of(own) is None
    assert "Tracing photons" in words_of(bpy, Panel)
    fetch(look)
    view = look.viewed.view
    caustic = int(view.caustic.sum())
    assert 0 < caustic < len(view.caustic)
    assert f"{caustic} caustic and {len(view.caustic) - caustic}" in words_of(bpy, Panel)
    whole = cloud_of(own)
    assert whole.points.shape == (len(view.caustic), 3)
    assert np.isfinite(whole.points).all() and len(whole.words) == 6
    own.kind, own.colour = "CAUSTIC", "caster"
    some = cloud_of(own)
    assert len(some.points) == len(some.shades) == caustic
    assert [text for text, _ in some.words] == [f"Mirror: {caustic}"]
    assert some.shades.dtype == np.float32 and (some.shades[:, 3] == 1).all()
    own.property_unset("kind")
    own.property_unset("colour")
    assert bpy.ops.photon_map.toggle_photons() == {"FINISHED"}
    assert look.viewed is None and not look.is_on(bpy.context.scene)


def test_a_picked_place_has_discs_and_paths(bpy: Any, look: Any) -> None:
    from photon_map.addon.photon_view.cloud import cloud_of
    from photon_map.addon.photon_view.panel import lines_of_place

    own = bpy.context.window_manager.photon_map_photons
    bpy.ops.photon_map.toggle_photons()
    fetch(look)
    look.pick(np.array([1.0, 0.5, 3.0]), np.array([0.0, 0.0, -1.0]))
    fetch(look)
    caustic, global_ = look.picked.discs
    assert look.picked.object == "Floor" and len(global_.rows) > 3
    lines = lines_of_place()
    assert lines[0] == "On 'Floor'"
    assert f"Global: {len(global_.rows)} photons, radius {global_.radius:.3g} m" in lines
    assert any(line.endswith("by light Light") for line in lines), lines
    cloud = cloud_of(own)
    assert len(cloud.rings) == 2 and len(cloud.ends) == len(cloud.end_shades) > 6
    away = np.linalg.norm(cloud.rings[1] - (1.0, 0.5, 0.0), axis=1)
    np.testing.assert_allclose(away, global_.radius, rtol=0.02)
    begin = abs(cloud.ends - (0.5, 0.0, 2.0)).max(axis=1).min()
    assert begin < 1e-5, "a path begins at the lamp"
    own.paths = False
    assert len(cloud_of(own).ends) == 0
    own.property_unset("paths")
    look.pick(np.array([50.0, 0.0, 3.0]), np.array([0.0, 0.0, -1.0]))
    fetch(look)
    assert look.picked is None and look.failure == "There is no surface there"


def test_what_stands_in_the_way_is_said(bpy: Any, look: Any) -> None:
    from photon_map.addon.photon_view.operators import PHOTONMAP_OT_trace_photons as Trace
    from photon_map.addon.photon_view.panel import PHOTONMAP_VIEW3D_PT_photons as Panel

    scene, own = bpy.context.scene, bpy.context.window_manager.photon_map_photons
    own.source = "BAKED"
    with pytest.raises(RuntimeError, match="no photon maps are baked beside the file"):
        bpy.ops.photon_map.toggle_photons()
    assert "no photon maps are baked" in words_of(bpy, Panel)
    own.property_unset("source")
    scene.camera = None
    with pytest.raises(RuntimeError, match="has no camera"):
        bpy.ops.photon_map.trace_photons()
    assert words_of(bpy, Panel, scene=None) == "There is no scene"
    scene.render.engine = "BLENDER_WORKBENCH"
    assert words_of(bpy, Panel) == "The render engine is not Photon Map"
    assert not Trace.poll(bpy.context)
    with pytest.raises(RuntimeError, match="not Photon Map"):
        bpy.ops.photon_map.trace_photons()


def test_baked_photons_are_those_of_the_file(bpy: Any, look: Any, tmp_path: Path) -> None:
    own = bpy.context.window_manager.photon_map_photons
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.context.scene.photon_map_baking.passes = 4
    assert bpy.ops.photon_map.bake() == {"FINISHED"}
    bpy.context.scene.photon_map.seed = 77
    own.source, own.number = "BAKED", 5
    bpy.ops.photon_map.toggle_photons()
    fetch(look)
    from photon_map.core.baking.maps_file import MapsFile

    caustic, global_ = MapsFile(tmp_path / "scene.pmap").photons(1)
    assert look.viewed.view.caustic.sum() == len(caustic)
    assert len(look.viewed.view.caustic) == len(caustic) + len(global_)
    bpy.data.objects["Floor"].scale = (2, 2, 1)
    bpy.context.view_layer.update()
    bpy.ops.photon_map.trace_photons()
    fetch(look)
    assert "another scene: object 'Floor' has changed" in look.failure
    for name in ("source", "number"):
        own.property_unset(name)


def test_an_edit_makes_photons_stale_and_an_undo_takes_them_away(bpy: Any, look: Any) -> None:
    bpy.ops.photon_map.toggle_photons()
    fetch(look)
    bpy.context.scene.camera.location.x += 1.0
    bpy.context.view_layer.update()
    assert not look.stale, "photons know nothing of the camera"
    bpy.data.objects["Mirror"].location.x += 1.0
    bpy.context.view_layer.update()
    assert look.stale
    bpy.ops.photon_map.trace_photons()
    assert not look.stale
    fetch(look)
    for handler in bpy.app.handlers.undo_post:
        handler(bpy.context.scene)
    assert look.viewed is None
    bpy.ops.photon_map.toggle_photons()
    bpy.ops.wm.read_homefile(use_empty=True)
    assert look.viewed is None and look.look() is None


def test_unregister_leaves_nothing(bpy: Any, look: Any) -> None:
    import photon_map
    from photon_map.addon.photon_view import _FORGETTING, drawing, panel

    if not hasattr(bpy.types, "VIEW3D_PT_overlay"):
        pytest.fail("Blender has no panel of overlays")
    bpy.ops.photon_map.toggle_photons()
    names = (*_FORGETTING, "depsgraph_update_post")
    counts = [len(getattr(bpy.app.handlers, name)) for name in names]
    drawn = list(bpy.types.VIEW3D_PT_overlay.draw._draw_funcs)
    assert panel.draw_switch in drawn and len(drawing.DRAWER._handles) == 2
    photon_map.unregister()
    try:
        assert look.viewed is None and not drawing.DRAWER._handles
        assert panel.draw_switch not in bpy.types.VIEW3D_PT_overlay.draw._draw_funcs
        assert not hasattr(bpy.types.WindowManager, "photon_map_photons")
        left = [len(getattr(bpy.app.handlers, name)) for name in names]
        assert all(a < b for a, b in zip(left, counts, strict=True))
        wait_until(lambda: not tasks())
        assert look.look() is None and look.viewed is None
    finally:
        photon_map.register()
