"""Images, their uses and texture coordinates in a scene's tables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from photon_map.core.scene.builder import SceneBuilder
from photon_map.core.scene.closures import closure
from photon_map.core.scene.image_tables import ImageTables
from photon_map.core.scene.scene import Scene, SceneError
from photon_map.core.scene.tables import ClosureKind, Extension, ImageKind

TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
CORNERS = np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]])


def textured() -> Scene:
    builder = SceneBuilder()
    image = builder.pictures.add_image(np.zeros((2, 3, 4)), ImageKind.FLOATS)
    texture = builder.pictures.add_texture(image)
    row = builder.add_material("m", closures=[closure(ClosureKind.DIFFUSE, color=(1, texture))])
    builder.add_mesh("o", *TRIANGLE, row, uvs=CORNERS)
    return builder.build()


def test_images_of_a_kind_lie_one_behind_the_other() -> None:
    tables = ImageTables()
    sizes = [(2, 3), (1, 1), (4, 2), (3, 3)]
    kinds = [ImageKind.BYTES, ImageKind.FLOATS, ImageKind.SRGB_BYTES, ImageKind.SRGB_FLOATS]
    for k, (size, kind) in enumerate(zip(sizes, kinds, strict=True)):
        assert tables.add_image(np.full((*size, 4), k + 1.0), kind) == k
    arrays = tables.arrays()
    assert arrays["images"]["start"].tolist() == [0, 0, 6, 1]
    assert arrays["images"]["width"].tolist() == [3, 1, 2, 3]
    assert arrays["texels8"][:, 0].tolist() == [1] * 6 + [3] * 8
    assert arrays["texels32"][:, 0].tolist() == [2.0] + [4.0] * 9


def test_equal_uses_share_a_row() -> None:
    tables = ImageTables()
    image = tables.add_image(np.zeros((1, 1, 4)), ImageKind.BYTES)
    assert tables.add_texture(image) == tables.add_texture(image) == 0
    assert tables.add_texture(image, uv=1) == 1
    assert tables.add_texture(image, extension=Extension.CLIP) == 2
    assert tables.add_texture(image, to_image=[[2, 0, 0], [0, 1, 0]]) == 3


def test_texels_that_are_no_numbers_are_black() -> None:
    tables = ImageTables()
    tables.add_image([[[np.nan, np.inf, -np.inf, 1.0]]], ImageKind.FLOATS)
    assert tables.arrays()["texels32"].tolist() == [[0.0, 0.0, 0.0, 1.0]]


@pytest.mark.parametrize("shape", [(2, 2), (2, 2, 3), (0, 2, 4)])
def test_other_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(SceneError, match="height, width, 4"):
        ImageTables().add_image(np.zeros(shape), ImageKind.BYTES)


def test_meshes_of_different_sets_are_filled_up_with_zeros() -> None:
    builder = SceneBuilder()
    row = builder.add_material("m")
    builder.add_mesh("none", *TRIANGLE, row)
    builder.add_mesh("one", *TRIANGLE, row, uvs=CORNERS)
    builder.add_mesh("two", *TRIANGLE, row, uvs=[CORNERS, CORNERS + 5.0])
    uvs = builder.build().uvs
    assert uvs.shape == (2, 3, 3, 2)
    assert not uvs[:, 0].any()
    assert (uvs[0, 1:] == CORNERS).all()
    assert not uvs[1, 1].any()
    assert (uvs[1, 2] == CORNERS + 5.0).all()


def test_dropped_faces_take_their_coordinates_with_them() -> None:
    builder = SceneBuilder()
    row = builder.add_material("m")
    faces = [[0, 0, 1], [0, 1, 2]]
    sets = np.stack([CORNERS[0] + 9.0, CORNERS[0]])
    builder.add_mesh("o", TRIANGLE[0], faces, row, uvs=sets)
    assert builder.dropped_faces == 1
    assert (builder.build().uvs == CORNERS).all()


def test_coordinates_of_another_count_are_refused() -> None:
    builder = SceneBuilder()
    with pytest.raises(SceneError, match="one coordinate per face corner"):
        builder.add_mesh("o", *TRIANGLE, builder.add_material("m"), uvs=np.zeros((2, 3, 2)))


def test_indices_that_kernels_would_follow_out_of_their_tables_are_refused() -> None:
    scene = textured()

    def broken(table: str, field: str, value: float) -> Scene:
        rows = getattr(scene, table).copy()
        rows[field] = value
        return replace(scene, **{table: rows})

    for table, field, value in [
        ("images", "start", 1),
        ("images", "start", -1),
        ("images", "width", 4),
        ("images", "height", 0),
        ("images", "kind", ImageKind.BYTES),
        ("textures", "image", 1),
        ("textures", "image", -1),
        ("textures", "to_image", np.nan),
        ("materials", "normal_texture", 1),
        ("materials", "bump_texture", 7),
        ("closures", "factor_count", 5),
    ]:
        with pytest.raises(SceneError):
            broken(table, field, value)
    rows = scene.closures.copy()
    rows["color"]["texture"] = 3
    with pytest.raises(SceneError, match="a texture that does not exist"):
        replace(scene, closures=rows)
