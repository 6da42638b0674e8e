"""The rendered viewport without a window: its camera, its worker, its pictures."""

from __future__ import annotations

import threading
import time
import weakref
from concurrent.futures import CancelledError
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.blender.support import add_camera, add_cube


def context_of(bpy: Any, camera: Any, width: int = 40, height: int = 30) -> Any:
    """A 3D view that sees what ``camera`` sees."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    window = camera.calc_matrix_camera(depsgraph, x=width, y=height)
    return SimpleNamespace(
        region_data=SimpleNamespace(
            view_matrix=camera.matrix_world.inverted(),
            window_matrix=window,
            view_perspective="PERSP",
        ),
        region=SimpleNamespace(width=width, height=height),
        space_data=SimpleNamespace(use_render_border=False),
    )


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_a_view_is_the_camera_with_its_matrices(bpy: Any, kind: str) -> None:
    from photon_map.addon.export.camera import export_camera
    from photon_map.addon.export.view import view_camera

    camera = add_camera(bpy, (1.0, 2.0, 5.0))
    camera.rotation_euler = (0.3, 0.2, 0.1)
    data = camera.data
    data.type, data.ortho_scale = kind, 7.0
    data.lens, data.shift_x, data.shift_y = 35.0, 0.1, -0.2
    data.clip_start, data.clip_end = 0.5, 50.0
    bpy.context.view_layer.update()
    scene = bpy.context.scene
    got = view_camera(context_of(bpy, camera), scene)
    expected = export_camera(camera, scene, (40, 30))
    np.testing.assert_allclose(got.matrix, expected.matrix, atol=1e-5)
    names = ["kind", "width", "height"]
    assert [getattr(got, n) for n in names] == [getattr(expected, n) for n in names]
    numbers = ["shift_x", "shift_y", "clip_start", "clip_end"]
    numbers += ["lens"] if kind == "PERSP" else ["ortho_scale"]
    for name in numbers:
        assert getattr(got, name) == pytest.approx(getattr(expected, name), rel=1e-4), name


def test_an_orthographic_view_sees_what_lies_behind_its_origin(bpy: Any) -> None:
    from photon_map.addon.export.view import camera_of

    near, far = -100.0, 100.0
    window = np.diag([2 / 8.0, 2 / 6.0, -2 / (far - near), 1.0])
    window[2, 3] = -(far + near) / (far - near)
    got = camera_of(np.eye(4), window, 40, 30)
    assert (got.kind, got.ortho_scale) == ("ORTHOGRAPHIC", 8.0)
    assert got.matrix[2, 3] == pytest.approx(100.0, rel=1e-5)
    assert got.clip_end - got.clip_start == pytest.approx(200.0)
    assert 0 < got.clip_start < 1e-3


@pytest.fixture
def viewport(bpy: Any, core: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A viewport whose textures are plain arrays, and a cube before it."""
    if bpy is None:
        yield None
        return
    from photon_map.addon import viewport as module

    add_cube(bpy, "Cube")
    bpy.context.scene.photon_map.viewport_passes = 3
    bpy.context.view_layer.update()
    drawn: list[Any] = []
    monkeypatch.setattr(module, "upload", lambda pixels: pixels)
    monkeypatch.setattr(module, "draw_texture", lambda *seen: drawn.append(seen))
    context = context_of(bpy, bpy.context.scene.camera)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    found = SimpleNamespace(
        render=module.ViewportRender(), context=context, depsgraph=depsgraph, drawn=drawn
    )
    yield found
    found.render.close()
    wait_until(lambda: not workers())


def workers() -> list[threading.Thread]:
    return [t for t in threading.enumerate() if t.name == "photon_map_viewport"]


def wait_until(done: Any) -> None:
    limit = time.monotonic() + 20
    while not done():
        assert time.monotonic() < limit
        time.sleep(0.01)


def draw(viewport: Any) -> str:
    return str(viewport.render.draw(viewport.context, viewport.depsgraph))


def test_the_last_picture_is_the_whole_one(bpy: Any, core: Any, viewport: Any) -> None:
    viewport.render.update(viewport.context, viewport.depsgraph)
    wait_until(lambda: not workers())
    assert viewport.render.has_news()
    assert draw(viewport) == "Pass 3/3 | Error 50.0 %"
    assert not viewport.render.has_news()
    pixels, place, size = viewport.drawn[-1]
    assert pixels.shape == (30, 40, 4)
    assert (place, size) == ((0, 0, 1, 1), (40, 30))
    assert core.closed == 2  # a coarse picture came before


def test_a_turned_view_is_rendered_without_an_export(
    bpy: Any, core: Any, viewport: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from photon_map.addon import viewport as module

    viewport.render.update(viewport.context, viewport.depsgraph)
    wait_until(lambda: not workers())
    monkeypatch.delattr(module, "export_scene")
    draw(viewport)
    assert core.closed == 2
    viewport.context.region = SimpleNamespace(width=20, height=10)
    draw(viewport)
    wait_until(lambda: not workers())
    draw(viewport)
    assert viewport.drawn[-1][0].shape == (10, 20, 4)
    assert core.closed == 4


def test_a_border_of_the_view_is_rendered_alone(bpy: Any, core: Any, viewport: Any) -> None:
    space = viewport.context.space_data
    viewport.render.update(viewport.context, viewport.depsgraph)
    space.render_border_min_x, space.render_border_max_x = 0.25, 0.5
    space.render_border_min_y, space.render_border_max_y = 0.1, 0.92
    space.use_render_border = True
    draw(viewport)
    wait_until(lambda: not workers())
    draw(viewport)
    pixels, place, size = viewport.drawn[-1]
    assert pixels.shape == (25, 10, 4)
    assert (place, size) == ((0.25, 0.1, 0.5, 28 / 30), (40, 30))
    space.use_render_border = False
    draw(viewport)
    wait_until(lambda: not workers())
    draw(viewport)
    assert viewport.drawn[-1][0].shape == (30, 40, 4)


def test_the_border_of_a_camera_is_a_part_of_its_frame(bpy: Any) -> None:
    from photon_map.addon.export.view import view_border

    camera = add_camera(bpy)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 40, 20
    bpy.context.view_layer.update()
    context = context_of(bpy, camera, 40, 20)
    # The frame fills the middle half of the view.
    context.region_data.window_matrix[0] *= 0.5
    context.region_data.window_matrix[1] *= 0.5
    context.region_data.view_perspective = "CAMERA"
    assert view_border(context, scene) is None
    render = scene.render
    render.border_min_x, render.border_max_x = 0.25, 0.8
    render.border_min_y, render.border_max_y = 0.0, 0.5
    render.use_border = True
    assert view_border(context, scene) == (15, 5, 26, 10)


def test_an_edit_converts_only_what_changed(bpy: Any, core: Any, viewport: Any) -> None:
    """Blender says in ``depsgraph.updates`` which geometry is another one."""
    add_cube(bpy, "Other")
    bpy.context.view_layer.update()
    memory = viewport.render._memory

    def on_update(_: Any, depsgraph: Any) -> None:
        memory.forget_changes(depsgraph)

    def updated() -> int:
        before = memory.converted
        # The updates are to be seen during the update alone, where engines are called too.
        bpy.app.handlers.depsgraph_update_post.append(on_update)
        bpy.context.view_layer.update()
        bpy.app.handlers.depsgraph_update_post.remove(on_update)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        viewport.render.update(viewport.context, depsgraph)
        wait_until(lambda: not workers())
        assert len(viewport.render._scene.faces) == 24
        return int(memory.converted - before)

    assert updated() == 2
    assert updated() == 0
    bpy.data.objects["Cube"].location.x += 1.0
    assert updated() == 0, "it is placed anew"
    assert viewport.render._scene.vertices[:, 0].max() == pytest.approx(2.0)
    bpy.data.meshes["Other"].vertices[0].co.x -= 9.0
    bpy.data.meshes["Other"].update()
    assert updated() == 1
    assert viewport.render._scene.vertices[:, 0].min() == pytest.approx(-10.0)
    bpy.app.handlers.undo_post[-1](bpy.context.scene)
    assert updated() == 2, "after an undo nothing is sure"


def test_what_takes_long_is_said_behind_the_coarse_picture(bpy: Any, viewport: Any) -> None:
    from photon_map.addon.worker import KeptBox, Picture, Worker

    worker = Worker(None, None, None, KeptBox())
    viewport.render._worker = worker
    assert draw(viewport) == ""
    worker._say("Compiling")
    assert viewport.render.has_news()
    assert draw(viewport) == "Compiling"
    pixels = np.zeros((3, 4, 4), np.float32)
    worker._show(Picture(pixels, "Pass 1/1"))
    assert draw(viewport) == "Pass 1/1"
    worker._say("pilot pass")
    worker._say("Rendering")
    assert viewport.render.has_news()
    assert draw(viewport) == "Pass 1/1 | Rendering"
    assert not viewport.render.has_news()
    assert [seen[0] is pixels for seen in viewport.drawn] == [True, True]
    # The next render says nothing until it has something to show or takes long.
    viewport.render._worker = Worker(None, None, None, KeptBox())
    assert not viewport.render.has_news()
    assert draw(viewport) == "Pass 1/1 | Rendering"


def test_warnings_of_the_export_are_counted_in_the_corner(
    bpy: Any, core: Any, viewport: Any
) -> None:
    from photon_map.addon.insight import insight_of

    bpy.context.scene.render.use_motion_blur = True
    viewport.render.update(viewport.context, bpy.context.evaluated_depsgraph_get())
    wait_until(lambda: not workers())
    said = "Pass 3/3 | Error 50.0 % | 1 warning: see Render Properties"
    assert draw(viewport) == said
    assert not viewport.render.has_news()
    found = insight_of(bpy.context.scene)
    assert found is not None and len(found.warnings) == 1
    assert "motion blur" in found.warnings[0]


def test_a_failure_of_drawing_is_said_once(
    bpy: Any, core: Any, viewport: Any, monkeypatch: pytest.MonkeyPatch, capfd: Any
) -> None:
    from photon_map.addon import viewport as module

    viewport.render.update(viewport.context, viewport.depsgraph)
    wait_until(lambda: not workers())

    def broken(pixels: Any) -> None:
        raise RuntimeError("no texture today")

    monkeypatch.setattr(module, "upload", broken)
    assert [draw(viewport) for _ in range(3)] == ["RuntimeError: no texture today"] * 3
    assert capfd.readouterr().err.count("Traceback") == 1
    assert not viewport.render.has_news() and not workers()


def test_the_timer_ends_the_worker_of_an_engine_that_is_gone(
    bpy: Any, core: Any, viewport: Any
) -> None:
    """Blender frees an engine that Python still holds: then it has no attributes any more."""
    from photon_map.addon.engine import WATCH, watch

    class Engine:
        drawn = 0

        def tag_redraw(self) -> None:
            self.drawn += 1
            if self.drawn >= 2:
                raise ReferenceError("StructRNA of type PhotonMapEngine has been removed")

    engine = Engine()
    look = watch(weakref.ref(engine), viewport.render)
    go_on = threading.Event()
    core.on_pass = lambda number: go_on.wait(20)
    viewport.render.update(viewport.context, viewport.depsgraph)
    viewport.render._failure = "something new to say"
    assert look() == WATCH and engine.drawn == 1 and workers()
    assert look() == WATCH and engine.drawn == 2 and viewport.render._worker is None
    go_on.set()
    wait_until(lambda: not workers())
    assert look() is None
    del engine
    assert look() is None


def test_closing_ends_the_worker(bpy: Any, core: Any, viewport: Any) -> None:
    begun, go_on = threading.Event(), threading.Event()

    def on_pass(number: int) -> None:
        begun.set()
        go_on.wait(20)

    core.on_pass = on_pass
    viewport.render.update(viewport.context, viewport.depsgraph)
    assert begun.wait(20)
    viewport.render.close()
    go_on.set()
    wait_until(lambda: not workers())
    assert core.passes_made == 1
    assert core.closed == 1


def test_an_edit_replaces_the_render(bpy: Any, core: Any, viewport: Any) -> None:
    for _ in range(5):
        viewport.render.update(viewport.context, viewport.depsgraph)
    wait_until(lambda: not workers())
    assert draw(viewport).startswith("Pass 3/3")


def test_errors_are_words_in_the_corner(bpy: Any, core: Any, viewport: Any) -> None:
    core.fail_at = 1
    viewport.render.update(viewport.context, viewport.depsgraph)
    wait_until(lambda: not workers())
    assert draw(viewport) == "Failed: the core broke"
    bpy.context.scene.photon_map.passes = 1
    bpy.data.objects["Cube"].location.x = float("nan")
    viewport.context.region_data = None
    viewport.render.update(viewport.context, viewport.depsgraph)
    assert draw(viewport).startswith("AttributeError")


@pytest.mark.parametrize("wanted", [False, True])
def test_a_worker_that_is_cancelled_says_nothing(
    bpy: Any, core: Any, viewport: Any, capfd: Any, wanted: bool
) -> None:
    """The core's work then ends with an exception, which is a failure otherwise."""

    def on_pass(number: int) -> None:
        if not wanted:
            viewport.render._worker.cancel()
        raise CancelledError

    core.on_pass = on_pass
    viewport.render.update(viewport.context, viewport.depsgraph)
    wait_until(lambda: not workers())
    assert core.closed == 1
    assert draw(viewport).startswith("Failed") == wanted
    assert ("Traceback" in capfd.readouterr().err) == wanted
