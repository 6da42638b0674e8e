from __future__ import annotations

import io
import json
import math
import os
import zipfile
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from numba import typeof

from photon_map.core.scene import dump
from photon_map.core.scene.builder import SceneBuilder, dielectric, diffuse
from photon_map.core.scene.camera_data import CameraData
from photon_map.core.scene.closures import closure
from photon_map.core.scene.dump import load_scene, save_scene
from photon_map.core.scene.scene import Scene, SceneError
from photon_map.core.scene.tables import ClosureKind, Extension, ImageKind
from photon_map.core.settings import Settings

SETTINGS = Settings(
    passes=7, seconds=0.1, alpha=1 / 3, pixel_filter="GAUSSIAN", region=(1, 2, 30, 4), seed=5
)


def full_scene() -> Scene:
    """Every table filled, with numbers that text would round and names that are not ASCII."""
    generator = np.random.default_rng(1)
    builder = SceneBuilder("Szene \u00fc \udce4 '\"")
    pictures = builder.pictures
    first = pictures.add_image(generator.integers(0, 256, (3, 2, 4)), ImageKind.SRGB_BYTES)
    second = pictures.add_image(generator.normal(size=(1, 5, 4)), ImageKind.FLOATS)
    texture = pictures.add_texture(first, 1, generator.normal(size=(2, 3)), Extension.CLIP)
    colors = closure(ClosureKind.PRINCIPLED, color=(1.0, texture), roughness=0.3)
    rows = [
        builder.add_material("glass \u2728", [dielectric(1.52), diffuse(0.1)]),
        builder.add_material("", [diffuse(1 / 3)], emission=math.pi),
        builder.add_material(
            "picture",
            closures=[colors],
            normal_texture=pictures.add_texture(second, closest=True, unassociate=True),
        ),
    ]
    vertices = generator.normal(size=(9, 3)) * [1e-9, 1.0, 1e9]
    normals = generator.normal(size=(3, 3, 3)).astype(np.float32)
    faces = np.arange(9).reshape(3, 3)
    builder.add_mesh(
        "object", vertices, faces, rows, normals, generator.normal(size=(2, 3, 3, 2))
    )
    builder.add_point_light("lamp", generator.normal(size=3), 1e-30, radius=1e-6)
    builder.add_sun_light("sun", np.eye(4), (1, 2, 3), angle=0.1)
    builder.set_world((0.1, 0.2, 0.3))
    matrix = np.eye(4)
    matrix[:3, 3] = generator.normal(size=3)
    builder.set_camera(
        CameraData(
            width=33, height=21, matrix=matrix, lens=1 / 3, shift_x=-0.0, blades=5,
            sensor_fit="VERTICAL", lens_radius=1e-3, focus_distance=math.e,
        )
    )  # fmt: skip
    return builder.build()


def leaves(array: np.ndarray) -> list[np.ndarray]:
    """The plain arrays that a table is made of: padding between fields is nobody's."""
    if array.dtype.names is None:
        return [array]
    return [leaf for name in array.dtype.names for leaf in leaves(array[name])]


def assert_same_bits(first: Scene, second: Scene) -> None:
    for field in fields(Scene):
        a, b = getattr(first, field.name), getattr(second, field.name)
        if isinstance(a, np.ndarray):
            assert (a.dtype, a.shape) == (b.dtype, b.shape), field.name
            for x, y in zip(leaves(a), leaves(b), strict=True):
                assert x.tobytes() == y.tobytes(), field.name
        elif field.name != "camera":
            assert a == b, field.name
    assert (first.camera is None) == (second.camera is None)
    if first.camera is not None and second.camera is not None:
        for field in fields(CameraData):
            a, b = getattr(first.camera, field.name), getattr(second.camera, field.name)
            assert np.asarray(a).tobytes() == np.asarray(b).tobytes(), field.name


@pytest.mark.parametrize("scene", [full_scene(), SceneBuilder("empty").build()])
def test_a_round_trip_keeps_every_bit(scene: Scene, tmp_path: Path):
    path = tmp_path / "scene.npz"
    save_scene(path, scene, SETTINGS)
    loaded, settings = load_scene(path)
    assert_same_bits(scene, loaded)
    assert settings == SETTINGS
    assert isinstance(settings.region, tuple)


def test_the_comparison_above_sees_one_bit(tmp_path: Path):
    scene = full_scene()
    vertices = scene.vertices.copy()
    vertices[0, 0] = np.nextafter(vertices[0, 0], 1.0)
    with pytest.raises(AssertionError, match="vertices"):
        assert_same_bits(scene, replace(scene, vertices=vertices))


def test_a_loaded_scene_is_read_only(tmp_path: Path):
    save_scene(tmp_path / "s.npz", full_scene(), SETTINGS)
    scene, _ = load_scene(tmp_path / "s.npz")
    with pytest.raises(ValueError, match="read-only"):
        scene.vertices[0, 0] = 0.0


def test_numpy_numbers_in_the_camera_are_stored(tmp_path: Path):
    camera = CameraData(width=np.int64(4), height=np.int32(3), lens=np.float32(35.5))
    save_scene(tmp_path / "s.npz", replace(full_scene(), camera=camera), SETTINGS)
    loaded = load_scene(tmp_path / "s.npz")[0].camera
    assert loaded is not None
    assert (loaded.width, loaded.height, loaded.lens) == (4, 3, 35.5)


def test_only_the_file_itself_is_left(tmp_path: Path):
    save_scene(tmp_path / "scene.npz", full_scene(), SETTINGS)
    save_scene(tmp_path / "scene.npz", full_scene(), SETTINGS)
    assert os.listdir(tmp_path) == ["scene.npz"]


def test_a_failure_leaves_the_older_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    path = tmp_path / "scene.npz"
    path.write_bytes(b"older")

    def full_disk(stream: io.BufferedWriter, **arrays: np.ndarray) -> None:
        stream.write(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full_disk)
    with pytest.raises(OSError, match="No space left"):
        save_scene(path, full_scene(), SETTINGS)
    assert path.read_bytes() == b"older"
    assert os.listdir(tmp_path) == ["scene.npz"]


def _rewritten(path: Path, **changes: object) -> Path:
    """A saved scene whose header or arrays are replaced; None takes an array out."""
    save_scene(path, full_scene(), SETTINGS)
    with np.load(path) as archive:
        arrays = dict(archive)
    header = json.loads(arrays["header"].tobytes())
    for key, value in changes.items():
        if key in header:
            header[key] = value
        elif value is None:
            del arrays[key]
        else:
            arrays[key] = np.asarray(value)
    arrays["header"] = np.frombuffer(json.dumps(header).encode(), np.uint8)
    np.savez(path, **arrays)
    return path


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"version": dump.FORMAT_VERSION + 1}, "version 5, this Photon Map reads version 4"),
        ({"format": "something"}, "not a scene file of Photon Map"),
        ({"vertices": None}, "is damaged"),
        ({"lights": np.zeros(2)}, "lights is float64"),
        ({"faces": np.full((3, 3), 99, np.int32)}, "faces points outside"),
        ({"object_names": [1]}, "1 stands where a name should"),
        ({"object_names": 3}, "is damaged"),
        ({"camera": {"width": 3}}, "is damaged"),
        ({"settings": {"region": None, "passes": -1}}, "passes is -1"),
        ({"settings": {"region": None, "colour": 1}}, "colour"),
        ({"settings": {"region": None, "passes": "many"}}, "is damaged"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(
    changes: dict[str, object], message: str, tmp_path: Path
):
    path = _rewritten(tmp_path / "s.npz", **changes)
    with pytest.raises(SceneError, match=message) as caught:
        load_scene(path)
    assert str(path) in str(caught.value)


def test_files_of_others_are_refused(tmp_path: Path):
    path = tmp_path / "s.npz"
    path.write_text("not an archive")
    with pytest.raises(SceneError, match="not a scene file"):
        load_scene(path)
    np.savez(path, vertices=np.zeros(3))
    with pytest.raises(SceneError, match="not a scene file of Photon Map"):
        load_scene(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "hello")
    with pytest.raises(SceneError, match="not a scene file of Photon Map"):
        load_scene(path)
    with pytest.raises(FileNotFoundError):
        load_scene(tmp_path / "missing.npz")


class Trap:
    """Unpickling it would make a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __reduce__(self):
        return os.mkdir, (str(self.folder),)


def test_nothing_is_ever_unpickled(tmp_path: Path):
    trap, path = tmp_path / "sprung", tmp_path / "s.npz"
    header = np.array([Trap(trap)], dtype=object)
    np.savez(path, header=header)
    assert not trap.exists()
    with pytest.raises(SceneError, match="is damaged"):
        load_scene(path)
    assert not trap.exists()
    with np.load(path, allow_pickle=True) as archive:
        archive["header"]
    assert trap.exists(), "the trap does not work, so this test proves nothing"


def test_a_damaged_byte_is_an_error_or_changes_nothing(
    tmp_path: Path, rng: np.random.Generator
):
    path = tmp_path / "s.npz"
    scene = full_scene()
    save_scene(path, scene, SETTINGS)
    whole = path.read_bytes()
    refused = 0
    for place in rng.choice(len(whole), size=150, replace=False):
        broken = bytearray(whole)
        broken[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(broken)
        try:
            loaded, settings = load_scene(path)
        except SceneError:
            refused += 1
        else:
            assert_same_bits(scene, loaded)
            assert settings == SETTINGS
    assert refused > 50
    for length in (0, 1, 100, len(whole) // 2, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(SceneError):
            load_scene(path)


def test_kernels_see_the_same_types_in_a_loaded_scene(tmp_path):
    # Else each of them would be compiled once more for scenes from files.
    scene = full_scene()
    save_scene(tmp_path / "a.npz", scene, SETTINGS)
    loaded, _ = load_scene(tmp_path / "a.npz")
    for key, array in vars(scene).items():
        if isinstance(array, np.ndarray):
            assert typeof(getattr(loaded, key)) == typeof(array), key
