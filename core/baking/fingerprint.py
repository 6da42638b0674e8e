"""What photons depend on, one digest a thing, so that a change can be named.

The camera is not among them: photons know nothing of it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from ..scene.scene import Scene
from ..settings import Settings

#: Raised when photons come out otherwise for the same scene: a bake of another is foreign.
TRACING_VERSION = 3

#: Objects that are told apart by name; those beyond share one digest.
_MOST_OBJECTS = 4096
#: Fields that say where a row's parts lie or what a user calls it, not what it is.
_PLACES = ("lobe_start", "closure_start", "index")


def fingerprint(scene: Scene, settings: Settings) -> dict[str, str]:
    """Digests of everything that the photons of ``scene`` depend on, by name.

    Photon counts and the seed are left out: a bake says which ones it has.
    """
    digests = dict(_objects(scene))
    for k, name in enumerate(scene.material_names):
        digests[_unused(f"material '{name}'", digests)] = _material(scene, k)
    for k, name in enumerate(scene.light_names):
        label = _unused(f"lamp '{name}'", digests)
        digests[label] = _digest(scene.lights[k : k + 1], scene.light_photons[k : k + 1])
    digests["the world"] = _digest(
        scene.world, scene.world_map, scene.world_rotation, scene.world_visibility
    )
    digests["the pictures"] = _digest(
        scene.textures, scene.images, scene.texels8, scene.texels32
    )
    digests["the colour space"] = _digest(scene.luminance)
    digests["the photons' depth"] = str(settings.photon_depth)
    return digests


def changes(stored: Mapping[str, str], current: Mapping[str, str]) -> list[str]:
    """What differs, in words: "lamp 'Key' has changed", in a fixed order."""
    found = [f"{name} is new" for name in current if name not in stored]
    found += [f"{name} is gone" for name in stored if name not in current]
    found += [
        f"{name} has changed"
        for name, digest in current.items()
        if stored.get(name, digest) != digest
    ]
    return found


def _objects(scene: Scene) -> Iterator[tuple[str, str]]:
    """Faces, normals, materials, coordinates and switches of each object."""
    order = np.argsort(scene.face_object, kind="stable")
    edges = np.searchsorted(scene.face_object[order], np.arange(len(scene.object_names) + 1))
    labels: dict[str, str] = {}
    for k, name in enumerate(scene.object_names[:_MOST_OBJECTS]):
        faces = order[edges[k] : edges[k + 1]]
        labels[_unused(f"object '{name}'", labels)] = _digest(
            *_faces(scene, faces), scene.object_visibility[k : k + 1]
        )
    yield from labels.items()
    if len(scene.object_names) > _MOST_OBJECTS:
        rest = order[edges[_MOST_OBJECTS] :]
        seen = scene.object_visibility[_MOST_OBJECTS:]
        yield "one of the many other objects", _digest(*_faces(scene, rest), seen)


def _faces(scene: Scene, faces: NDArray[np.int64]) -> Iterator[NDArray]:
    """What is known of ``faces`` (n,)."""
    yield scene.vertices[scene.faces[faces]]
    yield scene.corner_normals[faces]
    yield scene.face_material[faces]
    yield scene.uvs[:, faces]


def _material(scene: Scene, k: int) -> str:
    row = scene.materials[k]
    own = [row[name] for name in row.dtype.names if name not in _PLACES]
    lobes = scene.lobes[row["lobe_start"] : row["lobe_start"] + row["lobe_count"]]
    first = row["closure_start"]
    closures = scene.closures[first : first + row["closure_count"]]
    return _digest(*(np.asarray(value) for value in own), lobes, closures)


def _unused(label: str, taken: Mapping[str, str]) -> str:
    """``label``, with a number behind it where another thing has the same name."""
    found, number = label, 2
    while found in taken:
        found = f"{label} ({number})"
        number += 1
    return found


def _digest(*arrays: NDArray) -> str:
    """Hash of shapes and values; padding between the fields of a table is nobody's."""
    digest = hashlib.sha256()
    for array in arrays:
        for leaf in _leaves(array):
            digest.update(repr((leaf.dtype.str, leaf.shape)).encode())
            digest.update(np.ascontiguousarray(leaf).tobytes())
    return digest.hexdigest()[:32]


def _leaves(array: NDArray) -> Iterator[NDArray]:
    if array.dtype.names is None:
        yield array
        return
    for name in array.dtype.names:
        yield from _leaves(array[name])
