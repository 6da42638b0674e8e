"""Which materials cast caustics, how strongly, and which ones show them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..bsdf.lobe import casting_share, narrow_share
from ..scene.scene import Scene
from ..scene.tables import LOBE, ClosureKind, Fresnel, Model

#: Closures that are mirrors or glass, rough or not.
_GLOSSY_KINDS = (
    ClosureKind.GLOSSY, ClosureKind.METALLIC, ClosureKind.GLASS, ClosureKind.REFRACTION
)  # fmt: skip


def caster_strength(scene: Scene) -> NDArray[np.float64]:
    """About the part of light (M,) of each material that caustic photons follow; 0: none.

    Where a texture decides, the most that it may say is taken.
    """
    strength = np.zeros(len(scene.materials))
    for k, row in enumerate(scene.materials):
        strength[k] = sum(part for part, _ in _lobe_parts(scene, row))
        strength[k] += sum(_cast_by(closure) for closure in _closures(scene, row))
    return strength


def receiver_materials(scene: Scene) -> NDArray[np.bool_]:
    """Which materials (M,) scatter some light widely."""
    found = np.zeros(len(scene.materials), np.bool_)
    for k, row in enumerate(scene.materials):
        wide = any(part > 0 for _, part in _lobe_parts(scene, row))
        found[k] = wide or any(_is_wide(closure) for closure in _closures(scene, row))
    return found


def _lobe_parts(scene: Scene, row: np.void) -> list[tuple[float, float]]:
    """Casting and wide mean weight of each constant lobe of a material."""
    parts = []
    for lobe in scene.lobes[row["lobe_start"] : row["lobe_start"] + row["lobe_count"]]:
        if lobe["model"] == Model.TRANSPARENT:
            continue
        weight = float(lobe["weight"].mean())
        wide = 1.0 - float(narrow_share(lobe))
        parts.append((weight * float(casting_share(lobe)), weight * wide))
    return parts


def _closures(scene: Scene, row: np.void) -> NDArray[np.void]:
    return scene.closures[row["closure_start"] : row["closure_start"] + row["closure_count"]]


def _share_of(roughness: float) -> float:
    """Narrow share of a reflecting microfacet lobe of Blender's ``roughness``."""
    lobe = np.zeros(1, LOBE)
    lobe["model"], lobe["fresnel"] = Model.GGX, Fresnel.SCHLICK
    lobe["roughness"] = roughness * roughness
    return float(narrow_share(lobe[0]))


def _least(param: np.void) -> float:
    """The least that a number may be."""
    return 0.0 if param["texture"] >= 0 else float(param["value"][0])


def _most(param: np.void) -> float:
    """The most that a number, or a colour's mean, may be."""
    return float(param["value"].max())


def _factor(closure: np.void) -> float:
    """The most that the closure's mix factors may leave of it."""
    factor = 1.0
    for k in range(closure["factor_count"]):
        param, invert = closure["factors"][k]["param"], closure["factors"][k]["invert"]
        if param["texture"] < 0:
            value = float(np.clip(param["value"][0], 0.0, 1.0))
            factor *= 1.0 - value if invert else value
    return factor


def _cast_by(closure: np.void) -> float:
    kind = closure["kind"]
    if kind in _GLOSSY_KINDS:
        return _factor(closure) * _most(closure["color"])
    if kind != ClosureKind.PRINCIPLED:
        return 0.0
    metallic = min(1.0, float(closure["metallic"]["value"][0]))
    transmission = min(1.0, float(closure["transmission"]["value"][0]))
    ior = float(closure["ior"])
    f0 = ((ior - 1.0) / (ior + 1.0)) ** 2 * 2.0 * float(closure["specular_level"])
    body = 1.0 - _least(closure["metallic"])
    skin = body * min(1.0, f0) * _share_of(_least(closure["roughness"]))
    coat = 0.04 * float(closure["coat"]) * _share_of(float(closure["coat_roughness"]))
    metal = metallic * _most(closure["color"])
    return _factor(closure) * (metal + skin + body * transmission + coat)


def _is_wide(closure: np.void) -> bool:
    kind = closure["kind"]
    if kind in (ClosureKind.EMISSION, ClosureKind.TRANSPARENT) or _factor(closure) <= 0.0:
        return False
    roughness = closure["roughness"]
    rough = roughness["texture"] >= 0 or _share_of(float(roughness["value"][0])) < 1.0
    if kind in _GLOSSY_KINDS:
        return bool(rough)
    if kind == ClosureKind.PRINCIPLED:
        solid = _least(closure["metallic"]) < 1.0 and _least(closure["transmission"]) < 1.0
        return bool(rough or solid)
    return True
