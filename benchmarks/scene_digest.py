"""A fingerprint of what a scene shows, so that a reference of another scene is refused.

The .blend file's own bytes will not do: each save changes them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np

_LIGHT = ("type", "energy", "color", "shape", "size", "size_y", "shadow_soft_size", "spot_size")
_CAMERA = ("type", "lens", "sensor_width", "sensor_height", "sensor_fit", "shift_x", "shift_y")
_SOCKETS = ("VALUE", "RGBA", "VECTOR")
_LENS = ("use_dof", "aperture_fstop", "focus_distance")


def scene_digest(scene: bpy.types.Scene) -> str:
    """Hash over transforms, meshes, lamps, camera and shader inputs; size left out."""
    digest = hashlib.sha256()
    for thing in sorted(scene.objects, key=lambda each: each.name):
        for line in (*_object_lines(thing), *_material_lines(thing)):
            digest.update(line.encode())
    return digest.hexdigest()[:16]


def _object_lines(thing: bpy.types.Object) -> Iterator[str]:
    yield f"{thing.name} {thing.type} {thing.visible_camera} {thing.hide_render}"
    yield _text([value for row in thing.matrix_world for value in row])
    data = thing.data
    if thing.type == "MESH":
        places = np.empty(3 * len(data.vertices), np.float32)
        data.vertices.foreach_get("co", places)
        corners = np.empty(len(data.loops), np.int32)
        data.loops.foreach_get("vertex_index", corners)
        yield _text(places) + hashlib.sha256(corners.tobytes()).hexdigest()
    elif thing.type == "LIGHT":
        yield _properties(data, _LIGHT)
    elif thing.type == "CAMERA":
        yield _properties(data, _CAMERA) + _properties(data.dof, _LENS)


def _material_lines(thing: bpy.types.Object) -> Iterator[str]:
    for slot in thing.material_slots:
        if slot.material is None or slot.material.node_tree is None:
            continue
        for node in slot.material.node_tree.nodes:
            for socket in node.inputs:
                if socket.type in _SOCKETS:
                    value = np.ravel(socket.default_value)
                    yield f"{node.type} {socket.name} {_text(value)}"


def _properties(owner: bpy.types.bpy_struct, names: tuple[str, ...]) -> str:
    lines = []
    for name in names:
        value: Any = getattr(owner, name, None)
        is_number = isinstance(value, float) or hasattr(value, "foreach_get")
        lines.append(f"{name} {_text(np.ravel(value)) if is_number else value}")
    return "; ".join(lines)


def _text(values: object) -> str:
    """Five decimals: more would tell apart releases of Blender, not scenes."""
    rounded = np.round(np.asarray(values, dtype=np.float64), 5) + 0.0
    return " ".join(f"{value:.5f}" for value in rounded)
