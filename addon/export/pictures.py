"""Image Texture nodes to rows of the texture table, with their coordinates and mapping."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.builder import SceneBuilder
from ...core.scene.tables import Extension
from ..report import ExportLog
from .images import ImageTable
from .memory import ExportMemory
from .nodes import Placed, default_of, origin_of

if TYPE_CHECKING:
    from .values import ValueReader

#: The UV map that Blender has set active for rendering.
ACTIVE_UV = ""


class PictureTable:
    """Gives each use of an image its row in ``builder``, and each UV map its number."""

    def __init__(
        self, builder: SceneBuilder, log: ExportLog, memory: ExportMemory | None = None
    ) -> None:
        self.builder = builder
        self.log = log
        self.images = ImageTable(builder.pictures, log, memory)
        self._sets: dict[str, int] = {}

    @property
    def uv_names(self) -> tuple[str, ...]:
        """UV maps in use so far, in the order of the scene's sets; ``ACTIVE_UV`` for one."""
        return tuple(self._sets)

    def show_active(self) -> int:
        """Number of the UV map active for rendering, for a layer that shows it."""
        return self._sets.setdefault(ACTIVE_UV, len(self._sets))

    def texture(
        self, reader: ValueReader, node: Placed, flip_green: bool = False
    ) -> tuple[int, NDArray[np.float64]]:
        """Row of an Image Texture node, and the mean colour and alpha (4,) of its image."""
        item = node.item
        image = self.images.image(item, reader.owner, flip_green)
        uv, matrix = self._coordinates(reader, node)
        if item.projection != "FLAT":
            self.log.warn(
                f"{reader.owner}: the {item.projection.lower()} projection of '{node.label}' "
                "is not supported yet, it is flat"
            )
        if item.interpolation == "Cubic":
            self.log.warn_group("cubic interpolation is rendered linear in", reader.owner)
        alpha = next(output for output in item.outputs if output.name == "Alpha")
        texture = self.builder.pictures.add_texture(
            image.row,
            uv=self._sets.setdefault(uv, len(self._sets)),
            to_image=matrix[:2, [0, 1, 3]],
            extension=Extension[item.extension],
            closest=item.interpolation == "Closest",
            unassociate=image.is_associated and alpha.is_linked,
        )
        return texture, image.mean

    def _coordinates(
        self, reader: ValueReader, node: Placed
    ) -> tuple[str, NDArray[np.float64]]:
        """Name of the UV map of a texture node, and the matrix (4, 4) from it to the image."""
        matrix = np.eye(4)
        socket = node.input("Vector")
        while socket is not None:
            reader.note(socket)
            source = origin_of(socket)
            if not source.item.is_output:
                if source.item.node.type == "MAPPING":  # it maps its own value, a constant
                    matrix[:3, 3] += matrix[:3, :3] @ np.array(default_of(source)[:3])
                    matrix[:3, :3] = 0.0
                break
            kind = source.item.node.type
            if kind == "MAPPING":
                matrix = matrix @ mapping_matrix(reader, source.node)
                socket = source.node.input("Vector")
                continue
            if kind == "UVMAP":
                if source.item.node.from_instancer:
                    reader.warn_unread(source.node, socket)
                return source.item.node.uv_map, matrix
            if kind != "TEX_COORD" or source.item.name != "UV":
                self.log.warn(
                    f"{reader.owner}: '{source.item.name}' of node '{source.node.label}' is "
                    "not supported yet as coordinates; the active UV map is used",
                    key=(reader.owner, source.item.node.name),
                )
            return ACTIVE_UV, matrix
        return ACTIVE_UV, matrix


def mapping_matrix(reader: ValueReader, node: Placed) -> NDArray[np.float64]:
    """What a Mapping node does to a point, (4, 4); its inputs are constants."""

    def vector(name: str, default: float) -> NDArray[np.float64]:
        socket = node.input(name)
        if socket is None:
            return np.full(3, default)
        value: Any = reader.value(socket)
        return np.full(3, value) if isinstance(value, float) else np.array(value[:3])

    location, scale = vector("Location", 0.0), vector("Scale", 1.0)
    turn = rotation_matrix(vector("Rotation", 0.0))
    kind = node.item.vector_type
    matrix = np.eye(4)
    if kind == "TEXTURE":  # the inverse of POINT; a scale of 0 counts as none, as in Blender
        inverse = np.divide(1.0, scale, out=np.zeros(3), where=scale != 0)
        matrix[:3, :3] = inverse[:, None] * turn.T
        matrix[:3, 3] = -matrix[:3, :3] @ location
        return matrix
    if kind == "NORMAL":
        scale = np.divide(1.0, scale, out=np.zeros(3), where=scale != 0)
    matrix[:3, :3] = turn * scale
    if kind == "POINT":
        matrix[:3, 3] = location
    return matrix


def rotation_matrix(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Rotation (3, 3) about x, then y, then z [rad]."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x
