"""What a viewport remembers of an export, so that the next one converts only what changed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import bpy

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .mesh import MeshArrays

#: Raised whenever Blender may have changed data without telling who: everything is read anew.
_EPOCH = [0]


class _Kept(NamedTuple):
    """A converted mesh, and by what it is known to be the same."""

    arrays: MeshArrays | None
    size: tuple[int, int]


class ExportMemory:
    """Meshes of objects and pixels of images, as long as Blender does not say they changed."""

    def __init__(self) -> None:
        self._meshes: dict[tuple[int, int], _Kept] = {}
        self._pixels: dict[int, NDArray[np.float32]] = {}
        self._epoch = _EPOCH[0]
        self.converted = 0

    def forget_changes(self, depsgraph: Any) -> None:
        """Drop what an update of ``depsgraph`` changed."""
        if self._epoch != _EPOCH[0] or depsgraph.id_type_updated("COLLECTION"):
            self._meshes.clear()
            self._pixels.clear()
            self._epoch = _EPOCH[0]
        if depsgraph.id_type_updated("IMAGE"):
            self._pixels.clear()
        changed = {
            update.id.original.session_uid
            for update in depsgraph.updates
            if update.is_updated_geometry
        }
        for key in [key for key in self._meshes if changed.intersection(key)]:
            del self._meshes[key]

    def mesh(self, obj: Any) -> MeshArrays | None:
        """The arrays of an evaluated object that is no instance, None when unknown."""
        kept = self._meshes.get(_key(obj))
        return kept.arrays if kept is not None and kept.size == _size(obj) else None

    def keep_mesh(self, obj: Any, arrays: MeshArrays | None) -> None:
        """Remember the arrays of ``obj``."""
        self.converted += 1
        self._meshes[_key(obj)] = _Kept(arrays, _size(obj))

    def pixels(self, image: Any) -> NDArray[np.float32] | None:
        """A copy of the pixels of an image, None when unknown."""
        found = self._pixels.get(image.session_uid)
        return None if found is None else found.copy()

    def keep_pixels(self, image: Any, pixels: NDArray[np.float32]) -> None:
        """Remember the pixels of ``image``."""
        self._pixels[image.session_uid] = pixels.copy()


def _key(obj: Any) -> tuple[int, int]:
    """Object and data: modifiers and shape keys make something else of shared data."""
    return obj.original.session_uid, obj.original.data.session_uid


def _size(obj: Any) -> tuple[int, int]:
    return len(obj.data.vertices), len(obj.data.polygons)


@bpy.app.handlers.persistent
def _anything_changed(*_: Any) -> None:
    _EPOCH[0] += 1


_HANDLERS = ("load_post", "undo_post", "redo_post")


def register() -> None:
    """Start anew after a file was loaded or a step undone."""
    for name in _HANDLERS:
        getattr(bpy.app.handlers, name).append(_anything_changed)


def unregister() -> None:
    """Leave nothing behind."""
    for name in _HANDLERS:
        getattr(bpy.app.handlers, name).remove(_anything_changed)
