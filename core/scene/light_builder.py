"""The lamps and the world of a ``SceneBuilder``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .scene import SceneError
from .tables import LIGHT, LightKind, Visibility


def rgb(color: ArrayLike) -> tuple[float, float, float]:
    """A number or (3,) as three numbers."""
    values = np.broadcast_to(np.asarray(color, dtype=np.float64), (3,))
    return float(values[0]), float(values[1]), float(values[2])


def axes_of(matrix: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit axes (rows: x, y, z) and position of a (4, 4) object-to-world matrix."""
    m = np.asarray(matrix, dtype=np.float64)
    axes = m[:3, :3].T.copy()
    length = np.linalg.norm(axes, axis=1)
    if not np.isfinite(length).all() or (length == 0).any():
        raise SceneError("a light's matrix is not invertible; check its scale")
    return axes / length[:, None], m[:3, 3].copy()


class LightBuilder:
    """Collects lamps and the world."""

    def __init__(self) -> None:
        self._lights: list[Any] = []
        self._light_names: list[str] = []
        self._light_photons: list[float] = []
        self._world = np.zeros(3)
        self._world_map = np.zeros((0, 0, 3), np.float32)
        self._world_rotation = np.eye(3)
        self._world_visibility = Visibility.ALL

    def add_point_light(
        self,
        name: str,
        position: ArrayLike,
        intensity: ArrayLike,
        radius: float = 0.0,
        visibility: Visibility = Visibility.ALL,
        **others: float,
    ) -> None:
        """A point or sphere of ``radius`` with radiant ``intensity`` [W/sr] per channel.

        ``others``, here and below: more fields of ``tables.LIGHT``, such as ``soft``, and
        ``photons``, a factor on how many leave the lamp.
        """
        self._add_light(
            name, LightKind.POINT, np.eye(3), position, intensity, visibility,
            radius=radius, **others,
        )  # fmt: skip

    def add_spot_light(
        self,
        name: str,
        matrix: ArrayLike,
        intensity: ArrayLike,
        half_angle: float,
        blend: float = 0.0,
        radius: float = 0.0,
        visibility: Visibility = Visibility.ALL,
        **others: float,
    ) -> None:
        """A cone of ``half_angle`` [rad] along -Z with axial ``intensity`` [W/sr].

        ``size_x`` and ``size_y`` (1 when not given) stretch the cone across its axis.
        """
        axes, position = axes_of(matrix)
        shape = {"size_x": 1.0, "size_y": 1.0, **others}
        self._add_light(
            name, LightKind.SPOT, axes, position, intensity, visibility,
            radius=radius, cos_outer=float(np.cos(half_angle)), blend=blend, **shape,
        )  # fmt: skip

    def add_sun_light(
        self,
        name: str,
        matrix: ArrayLike,
        irradiance: ArrayLike,
        angle: float = 0.0,
        visibility: Visibility = Visibility.ALL,
        **others: float,
    ) -> None:
        """Light along -Z with ``irradiance`` [W/m^2] on a facing plane, disc of ``angle``."""
        axes, position = axes_of(matrix)
        self._add_light(
            name, LightKind.SUN, axes, position, irradiance, visibility, angle=angle, **others
        )

    def add_area_light(
        self,
        name: str,
        matrix: ArrayLike,
        radiance: ArrayLike,
        size_x: float,
        size_y: float,
        disk: bool = False,
        visibility: Visibility = Visibility.ALL,
        **others: float,
    ) -> None:
        """A one-sided rectangle or ellipse shining along -Z with mean ``radiance``.

        ``spread`` [rad] below pi: slats stand before it and gather its power towards -Z.
        """
        axes, position = axes_of(matrix)
        if not (size_x > 0 and size_y > 0):
            raise SceneError(f"light '{name}': an area light needs a size above 0")
        kind = LightKind.DISK if disk else LightKind.RECTANGLE
        self._add_light(
            name, kind, axes, position, radiance, visibility,
            size_x=size_x, size_y=size_y, **others,
        )  # fmt: skip

    def _add_light(
        self,
        name: str,
        kind: LightKind,
        axes: NDArray[np.float64],
        position: ArrayLike,
        emission: ArrayLike,
        visibility: Visibility,
        photons: float = 1.0,
        **shape: float,
    ) -> None:
        row = np.zeros((), LIGHT)
        values: dict[str, Any] = {
            "kind": int(kind),
            "visibility": int(visibility),
            "shadow": 1,
            "spread": math.pi,
            "position": np.asarray(position, dtype=np.float64),
            "axis_x": axes[0],
            "axis_y": axes[1],
            "axis_z": axes[2],
            "emission": rgb(emission),
            **shape,
        }
        for field_name, value in values.items():
            row[field_name] = value
        self._lights.append(row)
        self._light_names.append(name)
        self._light_photons.append(photons)

    def set_world(
        self,
        radiance: ArrayLike,
        world_map: ArrayLike | None = None,
        rotation: ArrayLike | None = None,
        visibility: Visibility = Visibility.ALL,
    ) -> None:
        """Radiance of the surroundings [W/(m^2 sr)], uniform or times ``world_map`` (h, w, 3).

        ``rotation`` (3, 3) takes a direction to that of the map; see ``Scene``.
        """
        self._world = np.array(rgb(radiance))
        empty = np.zeros((0, 0, 3))
        self._world_map = np.asarray(empty if world_map is None else world_map, np.float32)
        turn = np.eye(3) if rotation is None else rotation
        self._world_rotation = np.array(turn, dtype=np.float64)
        self._world_visibility = visibility

    def light_tables(self) -> dict[str, Any]:
        """The fields of ``Scene`` that were collected here."""
        return {
            "lights": np.array(self._lights, dtype=LIGHT),
            "light_names": tuple(self._light_names),
            "light_photons": np.array(self._light_photons, np.float64),
            "world": self._world.copy(),
            "world_map": np.ascontiguousarray(self._world_map),
            "world_rotation": self._world_rotation.copy(),
            "world_visibility": np.array([int(self._world_visibility)], np.int32),
        }
