"""Values of the user's own on surfaces, as layers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core import Settings, SettingsError, aov_layer, render
from photon_map.core.film.film import Film
from photon_map.core.scene.closures import param
from photon_map.core.scene.dump import load_scene, save_scene
from photon_map.core.scene.lobes import diffuse, mirror, transparent
from photon_map.core.scene.tables import Channel, ImageKind, Visibility
from photon_map.tests import scenes

BASE = Settings(
    passes=64, threads=1, photons_global=0, photons_caustic=0, gather_rays=1,
    pixel_filter="BOX", filter_width=1.0, aovs=("tint", "weight", "nobody's"),
)  # fmt: skip
TINT, WEIGHT = param((0.2, 0.4, 0.6)), param(-3.0)


def layers_of(scene, settings=BASE):
    film = list(render(scene, settings))[-1].film
    return [film.resolve(aov_layer(name)) for name in settings.aovs]


def floor(**others):
    b = scenes.floor_scene([diffuse(0.5)])
    b.add_mesh(
        "sheet", *scenes.plane(1.0, 0.5), b.add_material("sheet", **others)
    )  # lies over the floor, which has no value
    return b


def test_a_constant_is_what_it_is_where_it_is():
    scene = floor(lobes=[diffuse(0.1)], aovs={"tint": TINT, "weight": WEIGHT}).build()
    tint, weight, nobodys = layers_of(scene)
    assert tint[4, 4] == pytest.approx([0.2, 0.4, 0.6, 1.0])
    assert weight[4, 4] == pytest.approx([-3.0, -3.0, -3.0, 1.0])
    assert (tint[0, 0] == 0).all()
    assert (nobodys == 0).all()
    swapped = layers_of(scene, replace(BASE, aovs=("weight", "tint")))
    assert (swapped[0] == weight).all()
    assert (swapped[1] == tint).all()


def test_a_veil_adds_to_what_is_behind_it():
    """As in Cycles: 0.3 seen by three quarters behind 1 makes 1.225."""
    b = floor(lobes=[transparent(0.75), diffuse(0.25)], aovs={"weight": param(1.0)})
    behind = b.add_material("behind", [diffuse(0.5)], aovs={"weight": param(0.3)})
    b.add_mesh("behind", *scenes.plane(1.0, 0.25), behind)
    weight = layers_of(b.build())[1]
    assert weight[4, 4] == pytest.approx([1.225] * 3 + [1.75])


def test_what_is_half_opaque_hides_what_is_behind_it():
    b = floor(lobes=[transparent(0.5), diffuse(0.5)], aovs={"weight": param(1.0)})
    behind = b.add_material("behind", [diffuse(0.5)], aovs={"weight": param(0.3)})
    b.add_mesh("behind", *scenes.plane(1.0, 0.25), behind)
    assert layers_of(b.build())[1][4, 4] == pytest.approx([1.0] * 4)


def test_the_world_and_what_is_held_out_have_values_too():
    """As in Cycles, which writes both."""
    b = floor(lobes=[transparent(0.25), diffuse(0.7)], aovs={"weight": param(1.0)})
    b.set_world_aovs({"tint": TINT, "weight": WEIGHT})
    hole = b.add_material("hole", [diffuse(0.5)], aovs={"tint": param(9.0)})
    seen = Visibility.ALL | Visibility.HOLDOUT
    corners = scenes.quad((0.9, -1, 1), (3, -1, 1), (3, 1, 1), (0.9, 1, 1))
    b.add_mesh("hole", *corners, hole, visibility=seen)
    b.set_camera(scenes.camera((0, 0, 4), (0, 0, 0), 8, 8, fov=np.pi / 2, up=(0, 1, 0)))
    tint, weight, _ = layers_of(b.build())
    assert tint[4, 6] == pytest.approx([9.0, 9.0, 9.0, 1.0])
    assert weight[4, 4] == pytest.approx([1.0, 1.0, 1.0, 1.0])
    b.set_camera(scenes.camera((0, 0, -4), (0, 0, -9), 8, 8, up=(0, 1, 0)))
    tint, weight, _ = layers_of(b.build())
    assert tint == pytest.approx(np.broadcast_to(np.float32([0.2, 0.4, 0.6, 1.0]), (8, 8, 4)))
    assert (weight == [-3.0, -3.0, -3.0, 1.0]).all()


def test_mirrors_show_no_values_of_others():
    b = floor(lobes=[mirror(1.0)])
    b.add_mesh("up", *scenes.plane(9.0, 9.0), b.add_material("up", aovs={"tint": TINT}))
    assert (layers_of(b.build())[0] == 0).all()


def test_a_texture_is_looked_up_at_each_place():
    b = floor(lobes=[diffuse(0.5)])
    pixels = np.zeros((2, 2, 4), np.float32)
    pixels[..., 0], pixels[..., 3] = [[0.1, 0.2], [0.3, 0.4]], 1.0
    image = b.pictures.add_image(pixels, ImageKind.FLOATS)
    texture = b.pictures.add_texture(image, closest=True)
    values = {"weight": param(2.0, texture, Channel.RED), "tint": param((1, 2, 3), texture)}
    row = b.add_material("picture", [diffuse(0.5)], aovs=values)
    vertices, faces = scenes.plane(2.0, 0.6)
    uvs = (np.asarray(vertices)[np.asarray(faces)][..., :2] + 2.0) / 4.0
    b.add_mesh("picture", vertices, faces, row, uvs=uvs)
    tint, weight, _ = layers_of(b.build())
    for y, x, red in ((3, 3, 0.1), (3, 4, 0.2), (4, 3, 0.3), (4, 4, 0.4)):
        assert weight[y, x] == pytest.approx([2 * red] * 3 + [1.0], rel=1e-5)
        assert tint[y, x] == pytest.approx([red, 0, 0, 1.0], rel=1e-5)


def test_the_light_stays_as_it_is_and_films_add_up():
    b = floor(lobes=[diffuse(0.1)], aovs={"tint": TINT})
    b.add_point_light("lamp", (0, 0, 3), 5.0)
    scene = b.build()
    bare = list(render(scene, replace(BASE, aovs=())))[-1].film
    film = list(render(scene, BASE))[-1].film
    assert (film.resolve("combined") == bare.resolve("combined")).all()
    assert film.statistics.rays > bare.statistics.rays
    sums = []
    for k in (1.0, 3.0, np.nan):
        sums.append(Film(1, 1, aovs=("a",)))
        sums[-1].add_asked(0, np.zeros(1, np.int32), None, None, np.full((1, 1, 4), k))
        sums[-1]._count += 1
    for other in sums[1:]:
        sums[0].merge(other)
    # What is not finite counts as one that saw nothing.
    assert sums[0].resolve(aov_layer("a"))[0, 0] == pytest.approx([4 / 3] * 4)


def test_files_keep_them(tmp_path):
    scene = floor(lobes=[diffuse(0.1)], aovs={"tint": TINT}).build()
    save_scene(tmp_path / "a.npz", scene, BASE)
    loaded, settings = load_scene(tmp_path / "a.npz")
    assert settings == BASE
    assert loaded.aov_names == ("tint",)
    assert (loaded.aovs == scene.aovs).all()


def test_two_of_one_name_are_refused():
    with pytest.raises(SettingsError, match="two of one name"):
        Settings(aovs=("a", "a"))
