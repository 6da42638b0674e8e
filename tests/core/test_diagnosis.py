"""Each cause of a missing caustic, set up on a scene that has a caustic without it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from photon_map.core import Finding, Scene, SceneBuilder, Settings, why_no_caustic
from photon_map.core.scene.builder import dielectric, diffuse, mirror
from photon_map.core.scene.closures import principled, rough_glass
from photon_map.core.scene.lobes import ggx
from photon_map.core.scene.tables import Visibility

CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
CUBE = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip
PLATE = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
TWO = [[0, 1, 2], [0, 2, 3]]


def scene_of(
    material: dict[str, Any] | None = None,
    *,
    inside_out: bool = False,
    visibility: Visibility = Visibility.ALL,
    floor: Visibility = Visibility.ALL,
    roof: bool = False,
    lamp: str = "point",
) -> Scene:
    """A cube over a floor, a lamp above it, and perhaps a roof between them."""
    b = SceneBuilder("why")
    grey = b.add_material("grey", [diffuse(0.5)])
    own = b.add_material("own", **(material or {"lobes": [dielectric(1.5)]}))
    faces = CUBE[:, ::-1] if inside_out else CUBE
    b.add_mesh("cube", CORNERS + [0, 0, 2], faces, own, visibility=visibility)
    b.add_mesh("floor", 9 * PLATE, TWO, grey, visibility=floor)
    if roof:
        b.add_mesh("roof", 9 * PLATE + [0, 0, 4], TWO, grey)
    pose = np.eye(4)
    pose[2, 3] = 6.0
    if lamp == "point":
        b.add_point_light("lamp", (0, 0, 6), 1.0)
    elif lamp == "sun":
        b.add_sun_light("sun", pose, 1.0)
    elif lamp == "area":
        b.add_area_light("area", pose, 1.0, 1.0, 1.0)
    elif lamp == "area upwards":
        b.add_area_light("area", np.diag([1, -1, -1, 1]) @ pose @ np.eye(4), 1.0, 1.0, 1.0)
    elif lamp == "spot aside":
        pose[:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
        b.add_spot_light("spot", pose, 1.0, 0.3, 0.1)
    elif lamp == "glow":
        glow = b.add_material("glow", emission=1.0)
        b.add_mesh("glowing", PLATE + [0, 0, 6], TWO, glow)
    elif lamp == "world":
        b.set_world(1.0)
    return b.build()


def causes(scene: Scene, name: str = "cube", **settings: int) -> list[str]:
    return [f.cause for f in why_no_caustic(scene, Settings(**settings), name)]


@pytest.mark.parametrize("lamp", ["point", "sun", "area", "glow", "world"])
def test_nothing_is_wrong_with_a_glass_cube_in_the_light(lamp: str) -> None:
    assert causes(scene_of(lamp=lamp)) == []


def test_a_mirror_needs_no_volume() -> None:
    assert causes(scene_of({"lobes": [mirror(0.9)]}, inside_out=True)) == []


def test_no_caster() -> None:
    (found,) = why_no_caustic(scene_of(), Settings(), "floor")
    assert found == Finding(
        "no caster",
        "material 'grey' neither reflects nor refracts: make it glass, a mirror or a metal",
    )


@pytest.mark.parametrize(
    "material",
    [
        {"lobes": [ggx(0.9, 0.7)]},
        {"closures": [rough_glass(2.4, 0.7)], "ior": 2.4},
        {"closures": [principled(metallic=1.0, roughness=0.7)]},
    ],
)
def test_roughness_too_high(material: dict[str, Any]) -> None:
    (found,) = why_no_caustic(scene_of(material), Settings(), "cube")
    assert found.cause == "roughness too high"
    assert "a roughness of 0.7," in found.words
    assert "less than 0.5" in found.words


@pytest.mark.parametrize(
    "material",
    [
        {"lobes": [ggx(0.5, 0.7), mirror(0.4)]},
        {"closures": [principled(metallic=1.0, roughness=0.4)]},
    ],
)
def test_a_smooth_lobe_beside_a_rough_one_is_enough(material: dict[str, Any]) -> None:
    assert causes(scene_of(material)) == []


def test_normals_flipped() -> None:
    assert causes(scene_of(inside_out=True)) == ["normals flipped"]


def test_depth_too_low() -> None:
    assert causes(scene_of(), photon_depth=2) == ["depth too low"]
    assert causes(scene_of({"lobes": [mirror(0.9)]}), photon_depth=2) == []
    assert causes(scene_of({"lobes": [mirror(0.9)]}), photon_depth=1) == ["depth too low"]


def test_switched_off() -> None:
    off = scene_of(visibility=Visibility.ALL | Visibility.CASTS_NONE)
    assert causes(off) == ["switched off"]
    assert causes(scene_of(), photons_caustic=0) == ["switched off"]


def test_no_receiver() -> None:
    assert causes(scene_of(floor=Visibility.ALL | Visibility.SHOWS_NONE)) == ["no receiver"]


@pytest.mark.parametrize(
    ("lamp", "name"), [("point", "'lamp'"), ("sun", "'sun'"), ("glow", "'glowing'")]
)
def test_light_blocked(lamp: str, name: str) -> None:
    (found,) = why_no_caustic(scene_of(roof=True, lamp=lamp), Settings(), "cube")
    assert found == Finding("light blocked", f"no light reaches it: 'roof' is before {name}")


@pytest.mark.parametrize("lamp", ["spot aside", "area upwards"])
def test_a_lamp_that_shines_elsewhere(lamp: str) -> None:
    assert causes(scene_of(lamp=lamp)) == ["light blocked"]


def test_no_light() -> None:
    assert causes(scene_of(lamp="none")) == ["no light"]


def test_an_object_without_faces() -> None:
    assert causes(scene_of(), name="nobody") == ["not rendered"]


def test_all_causes_are_told() -> None:
    both = scene_of(inside_out=True, visibility=Visibility.ALL | Visibility.CASTS_NONE)
    assert causes(both, photon_depth=2) == ["switched off", "normals flipped", "depth too low"]
