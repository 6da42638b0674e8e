"""Objects that cast or show no caustics, and lamps with more photons of their own."""

from __future__ import annotations

import numpy as np
import pytest

from photon_map.core import CameraData, Plan, Scene, SceneBuilder, SceneError, Settings, render
from photon_map.core.scene.builder import diffuse
from photon_map.core.scene.builder import mirror as shiny_lobe
from photon_map.core.scene.tables import Visibility

SIZE = 16


def mirror_over_floor(
    mirror: Visibility = Visibility.ALL,
    floor: Visibility = Visibility.ALL,
    photons: float = 1.0,
    second: bool = False,
) -> Scene:
    """A lamp whose light reaches the floor (z = 0) also by a mirror that stands on it."""
    b = SceneBuilder("mirror")
    grey = b.add_material("grey", [diffuse(0.5)])
    shiny = b.add_material("shiny", [shiny_lobe(0.9)])
    square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    faces = [[0, 1, 2], [0, 2, 3]]
    b.add_mesh("floor", 2 * square, faces, grey, visibility=floor)
    b.add_mesh("mirror", square[:, [2, 0, 1]] + [1.5, 0, 1], faces, shiny, visibility=mirror)
    if second:
        b.add_mesh("other", square[:, [2, 0, 1]] - [1.5, 0, -1], faces, shiny)
    b.add_point_light("lamp", (0, 0, 1.5), 10.0, photons=photons)
    above = np.diag([1.0, 1.0, 1.0, 1.0])
    above[2, 3] = 4.0
    b.set_camera(CameraData(width=SIZE, height=SIZE, matrix=above))
    return b.build()


def layers(scene: Scene, **chosen: int) -> dict[str, np.ndarray]:
    settings = Settings(passes=4, photons_caustic=20_000, photons_global=0, **chosen)
    *_, last = render(scene, settings)
    return {name: last.film.resolve(name) for name in ("direct", "caustics")}


def test_an_object_that_casts_none_leaves_the_others_alone() -> None:
    one = layers(mirror_over_floor())["caustics"]
    both = layers(mirror_over_floor(second=True))["caustics"]
    left = layers(mirror_over_floor(Visibility.ALL | Visibility.CASTS_NONE, second=True))
    assert one.sum() > 0
    # The scene is symmetric, so the other mirror's caustic is the first one's image; both
    # mirrors together have that light too which goes from one to the other.
    mirrored = one[:, ::-1].mean()
    assert left["caustics"].mean() == pytest.approx(mirrored, rel=0.05)
    assert both.mean() > 1.9 * mirrored


def test_without_casters_the_stage_is_off_and_says_why() -> None:
    scene = mirror_over_floor(Visibility.ALL | Visibility.CASTS_NONE)
    stage = next(s for s in Plan.of(scene, Settings()).stages if s.name == "caustics")
    assert not stage.on
    assert stage.reason == "casting is switched off for all 1 casters"
    assert layers(scene)["caustics"].max() == 0.0


def test_an_object_that_shows_none_keeps_its_direct_light() -> None:
    shown = layers(mirror_over_floor())
    hidden = layers(mirror_over_floor(floor=Visibility.ALL | Visibility.SHOWS_NONE))
    assert shown["caustics"].max() > 0.0
    assert hidden["caustics"].max() == 0.0
    np.testing.assert_array_equal(shown["direct"], hidden["direct"])


def with_a_second_lamp(photons: float) -> Scene:
    """Two equal lamps, the first with ``photons`` times its number of photons."""
    b = SceneBuilder("lamps")
    shiny = b.add_material("m", [shiny_lobe(0.9)])
    grey = b.add_material("d", [diffuse(0.5)])
    square = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    b.add_mesh("mirror", square, [[0, 1, 2], [0, 2, 3]], shiny)
    b.add_mesh("ceiling", np.add(square, [0, 0, 3]), [[0, 1, 2], [0, 2, 3]], grey)
    b.add_point_light("first", (-0.5, 0, 1), 1.0, photons=photons)
    b.add_point_light("second", (0.5, 0, 1), 1.0)
    b.set_camera(CameraData(width=SIZE, height=SIZE))
    return b.build()


def test_a_lamp_gets_more_photons_and_no_more_light() -> None:
    from photon_map.core.prepared import prepare

    settings = Settings()
    even = prepare(with_a_second_lamp(1.0), settings).aim.light_cdf
    much = prepare(with_a_second_lamp(9.0), settings).aim.light_cdf
    assert even[0] == pytest.approx(0.5, abs=1e-6)
    # A tenth is shared out evenly, whatever the factors say.
    assert much[0] == pytest.approx(0.05 + 0.9 * 0.9, abs=1e-6)
    light = layers(mirror_over_floor())["caustics"].mean()
    assert layers(mirror_over_floor(photons=7.0))["caustics"].mean() == pytest.approx(
        light, rel=1e-6
    )


@pytest.mark.parametrize("bad", [0.0, -1.0, float("nan")])
def test_a_lamp_without_photons_is_refused(bad: float) -> None:
    with pytest.raises(SceneError, match="light_photons"):
        with_a_second_lamp(bad)
