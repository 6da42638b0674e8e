"""A scene and its settings in one ``.npz`` file: rendered later, without Blender.

Arrays are stored as they are; names, camera and settings as JSON text. Nothing is pickled,
so opening a stranger's file can never run code. A round trip keeps every bit.
"""

from __future__ import annotations

import json
import os
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..file_replace import replacing
from ..settings import LightGroup, Settings
from .camera_data import CameraData
from .scene import Scene, SceneError
from .tables import AOV, CLOSURE, IMAGE, LIGHT, LOBE, MATERIAL, TEXTURE

FORMAT = "photon_map scene"
FORMAT_VERSION = 4

_NAMES = ("object_names", "object_assets", "material_names", "light_names", "aov_names")
_ARRAYS = tuple(f.name for f in fields(Scene) if f.name not in ("name", "camera", *_NAMES))

_ROWS = {
    "materials": MATERIAL, "lobes": LOBE, "lights": LIGHT, "closures": CLOSURE,
    "textures": TEXTURE, "images": IMAGE, "aovs": AOV,
    "world_aovs": AOV,
}  # fmt: skip

#: What NumPy, zipfile and json raise on a file that is not what it says (OSError: a seek to a
#: place before its start).
_BROKEN = (
    zipfile.BadZipFile, zlib.error, EOFError, KeyError, MemoryError, NotImplementedError,
    OSError, RuntimeError, TypeError, ValueError,
)  # fmt: skip


def save_scene(path: str | os.PathLike[str], scene: Scene, settings: Settings) -> None:
    """Write ``scene`` and ``settings`` to ``path``; the file appears whole or not at all.

    Raises ``OSError`` when the folder cannot be written.
    """
    header: dict[str, Any] = {
        "format": FORMAT,
        "version": FORMAT_VERSION,
        "name": scene.name,
        **{key: getattr(scene, key) for key in _NAMES},
        # Files of one machine are nothing to another.
        "settings": asdict(replace(settings, photon_maps="")),
    }
    # Any: newer NumPy has a keyword of its own among the arrays' names.
    arrays: dict[str, Any] = {key: getattr(scene, key) for key in _ARRAYS}
    if scene.camera is not None:
        header["camera"] = {
            f.name: getattr(scene.camera, f.name)
            for f in fields(CameraData)
            if f.name != "matrix"
        }
        arrays["camera_matrix"] = np.asarray(scene.camera.matrix, dtype=np.float64)
    text = json.dumps(header, default=lambda number: number.item())
    arrays["header"] = np.frombuffer(text.encode(), dtype=np.uint8)
    with replacing(path) as part, open(part, "wb") as stream:
        np.savez_compressed(stream, **arrays)


def load_scene(path: str | os.PathLike[str]) -> tuple[Scene, Settings]:
    """Read what ``save_scene`` wrote.

    Raises ``SceneError`` when the file is damaged, of another program or of a newer version
    of this one, and ``OSError`` when it cannot be opened.
    """
    name = os.fspath(path)
    with open(path, "rb") as stream:
        if not zipfile.is_zipfile(stream):
            raise SceneError(f"'{name}' is not a scene file: it is no .npz archive")
        try:
            stream.seek(0)
            with np.load(stream, allow_pickle=False) as archive:
                header = _read_header(archive)
                return _read_scene(archive, header), _read_settings(header["settings"])
        except SceneError as error:
            raise SceneError(f"'{name}': {error}") from error
        except _BROKEN as error:
            raise SceneError(f"'{name}' is damaged: {error or type(error).__name__}") from error


def _read_header(archive: Mapping[str, NDArray]) -> dict[str, Any]:
    if "header" not in archive:
        raise SceneError("not a scene file of Photon Map")
    header = json.loads(archive["header"].tobytes().decode())
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise SceneError("not a scene file of Photon Map")
    version = header["version"]
    if version != FORMAT_VERSION:
        raise SceneError(
            f"scene file of version {version}, this Photon Map reads version "
            f"{FORMAT_VERSION}; save the scene again with this one"
        )
    return header


def _read_scene(archive: Mapping[str, NDArray], header: dict[str, Any]) -> Scene:
    camera = header.get("camera")
    tables: dict[str, Any] = {key: _aligned(archive[key], _ROWS.get(key)) for key in _ARRAYS}
    names: dict[str, Any] = {key: tuple(map(_string, header[key])) for key in _NAMES}
    return Scene(
        name=_string(header["name"]),
        camera=camera and CameraData(**camera, matrix=archive["camera_matrix"]),
        **tables,
        **names,
    )


def _aligned(array: NDArray, row: np.dtype[np.void] | None) -> NDArray:
    """``array`` as rows that kernels know to be aligned, which files do not tell.

    For others each kernel would be compiled once more.
    """
    return array.view(row) if row is not None and array.dtype == row else array


def _read_settings(stored: dict[str, Any]) -> Settings:
    region, first_hit = stored.pop("region"), stored.pop("first_hit", ())
    aovs = tuple(map(_string, stored.pop("aovs", ())))
    stored.pop("photon_maps", None)
    groups = tuple(_light_group(*group) for group in stored.pop("light_groups", ()))
    return Settings(
        **stored,
        region=None if region is None else tuple(region),
        first_hit=tuple(map(_string, first_hit)),
        light_groups=groups,
        aovs=aovs,
    )


def _light_group(name: object, lights: Any, objects: Any, world: object) -> LightGroup:
    names = (tuple(map(_string, lights)), tuple(map(_string, objects)))
    return LightGroup(_string(name), *names, bool(world))


def _string(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r} stands where a name should")
    return value
