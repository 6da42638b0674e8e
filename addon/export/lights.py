"""Lamps in the core's units.

Blender states power in a convention of its own; the factors here were calibrated against
Cycles 4.5 to 5.2 to better than 0.1 % (energy P, colour c, radius r, area A, angle a):

| lamp | ``normalize`` on | off |
|---|---|---|
| point, spot (axis) | I = P c / (4 pi) W/sr | I = P c r^2, or P c / pi when r = 0 |
| sun | E = P c W/m^2 | E = P c pi sin^2(a / 2) |
| area | L = P c / (pi A) W/(m^2 sr) | L = P c / pi |

All times 2^exposure. An object's scale widens area lamps and leaves their power.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.scene.builder import SceneBuilder
from ..report import ExportLog
from .nodes import NodeReader, shader_of
from .trees import tree_of
from .visibility import object_visibility

#: A spread of 0 is parallel light; the core wants some [rad].
_LEAST_SPREAD = 1e-3


def add_light(
    builder: SceneBuilder, obj: Any, matrix: NDArray[np.float64], log: ExportLog
) -> None:
    """Add the lamp of object ``obj`` placed by ``matrix`` (4, 4)."""
    light = obj.data
    name = obj.name
    power = light_power(light, f"light '{name}'", log)
    if not power.any():
        return
    scale = np.linalg.norm(matrix[:3, :3], axis=0)
    if not (np.isfinite(scale).all() and (scale > 0).all()):
        log.warn(f"light '{name}' is left out, because its scale is 0")
        return
    if is_portal(light):
        log.warn_group("portals are left out, they emit nothing", f"light '{name}'")
        return
    seen = object_visibility(obj)
    normalize = getattr(light, "normalize", True)
    others = {
        "soft": bool(getattr(light, "use_soft_falloff", False)),
        "shadow": bool(light.use_shadow),
        "photons": float(light.photon_map.photons),
    }
    if light.type in ("POINT", "SPOT"):
        radius = float(light.shadow_soft_size)
        intensity = power * _point_factor(radius, normalize)
        if light.type == "POINT":
            builder.add_point_light(name, matrix[:3, 3], intensity, radius, seen, **others)
        else:
            half, blend = float(light.spot_size) / 2.0, float(light.spot_blend)
            stretch = {"size_x": scale[0] / scale[2], "size_y": scale[1] / scale[2]}
            builder.add_spot_light(
                name, matrix, intensity, half, blend, radius, seen, **stretch, **others
            )
    elif light.type == "SUN":
        angle = float(light.angle)
        factor = 1.0 if normalize or angle == 0 else math.pi * math.sin(angle / 2.0) ** 2
        builder.add_sun_light(name, matrix, power * factor, angle, seen, **others)
    elif light.type == "AREA":
        round_shape = light.shape in ("DISK", "ELLIPSE")
        size_x = float(light.size * scale[0])
        size_y = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
        size_y = float(size_y * scale[1])
        area = size_x * size_y * (math.pi / 4.0 if round_shape else 1.0)
        if area <= 0:
            log.warn(f"light '{name}' is left out, because its size is 0")
            return
        radiance = power / (math.pi * (area if normalize else 1.0))
        builder.add_area_light(
            name, matrix, radiance, size_x, size_y, round_shape, seen,
            spread=max(_LEAST_SPREAD, float(light.spread)), **others,
        )  # fmt: skip
    else:
        log.warn(f"light '{name}': type {light.type} is not supported and left out")


def _point_factor(radius: float, normalize: bool) -> float:
    if normalize:
        return 1.0 / (4.0 * math.pi)
    return radius * radius if radius > 0 else 1.0 / math.pi


def light_power(light: Any, owner: str, log: ExportLog) -> NDArray[np.float64]:
    """Energy times colour, temperature, exposure and its node's emission, (3,)."""
    power = np.array(light.color[:3], dtype=np.float64) * float(light.energy)
    if getattr(light, "use_temperature", False):
        power = power * np.array(light.temperature_color[:3], dtype=np.float64)
    power = power * 2.0 ** float(getattr(light, "exposure", 0.0))
    power = power * node_factor(light, owner, log)
    if (power < 0).any():
        log.warn(f"{owner}: negative power is not possible, 0 is used")
    return np.maximum(power, 0.0)


def node_factor(light: Any, owner: str, log: ExportLog) -> NDArray[np.float64]:
    """What the light's nodes multiply its power by, (3,): colour x strength of Emission."""
    tree = tree_of(light)
    output = None if tree is None else tree.get_output_node("CYCLES")
    if output is None:
        return np.ones(3)
    node = shader_of(output.inputs["Surface"])
    if node is None:
        return np.zeros(3)
    if node.type != "EMISSION":
        log.warn(f"{owner}: shader node '{node.name}' is not supported yet and ignored")
        return np.ones(3)
    reader = NodeReader(owner, log)
    return reader.color(node, "Color") * reader.number(node, "Strength", 1.0)


def is_portal(light: Any) -> bool:
    """Whether the area lamp only shows Cycles where the sky is (when Cycles is enabled)."""
    return light.type == "AREA" and bool(
        getattr(getattr(light, "cycles", None), "is_portal", False)
    )
