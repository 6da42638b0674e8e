"""The one table that says which layer of the film is which pass in Blender.

There is no Shadow Catcher: such objects are rendered as usual, with a warning.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import bpy

if TYPE_CHECKING:
    from ..core import LightGroup


class RenderPass(NamedTuple):
    """A layer of the film, and the pass it becomes."""

    layer: str  #: name in ``core.film``; "vector" is made from two of them (``motion.py``)
    name: str  #: name in Blender 5.0 and later
    old_name: str  #: name before 5.0
    channels: str  #: one letter per channel
    kind: str  #: Blender's socket type: COLOR, VECTOR or VALUE
    toggle: str  #: property of the view layer, "" = always on; "pm." = our own group
    first: int = 0  #: channel of the layer that the pass begins with


#: As in Cycles (direct + indirect) x colour, summed over diffuse, glossy and transmission,
#: and Emission and Environment make Combined. Caustics are a part of it that Cycles has no
#: pass for.
PASSES: tuple[RenderPass, ...] = (
    RenderPass("combined", "Combined", "Combined", "RGBA", "COLOR", ""),
    RenderPass("distance", "Depth", "Depth", "Z", "VALUE", "use_pass_z"),
    RenderPass("mist", "Mist", "Mist", "Z", "VALUE", "use_pass_mist"),
    RenderPass("position", "Position", "Position", "XYZ", "VECTOR", "use_pass_position"),
    RenderPass("normal", "Normal", "Normal", "XYZ", "VECTOR", "use_pass_normal"),
    RenderPass("vector", "Vector", "Vector", "XYZW", "VECTOR", "use_pass_vector"),
    RenderPass("uv", "UV", "UV", "UVA", "VECTOR", "use_pass_uv"),
    RenderPass(
        "object_index", "Object Index", "IndexOB", "X", "VALUE", "use_pass_object_index"
    ),
    RenderPass(
        "material_index", "Material Index", "IndexMA", "X", "VALUE", "use_pass_material_index"
    ),
    RenderPass(
        "diffuse_direct", "Diffuse Direct", "DiffDir", "RGB", "COLOR", "use_pass_diffuse_direct"
    ),
    RenderPass(
        "diffuse_indirect", "Diffuse Indirect", "DiffInd", "RGB", "COLOR",
        "use_pass_diffuse_indirect",
    ),
    RenderPass(
        "diffuse_color", "Diffuse Color", "DiffCol", "RGB", "COLOR", "use_pass_diffuse_color"
    ),
    RenderPass(
        "glossy_direct", "Glossy Direct", "GlossDir", "RGB", "COLOR", "use_pass_glossy_direct"
    ),
    RenderPass(
        "glossy_indirect", "Glossy Indirect", "GlossInd", "RGB", "COLOR",
        "use_pass_glossy_indirect",
    ),
    RenderPass(
        "glossy_color", "Glossy Color", "GlossCol", "RGB", "COLOR", "use_pass_glossy_color"
    ),
    RenderPass(
        "transmission_direct", "Transmission Direct", "TransDir", "RGB", "COLOR",
        "use_pass_transmission_direct",
    ),
    RenderPass(
        "transmission_indirect", "Transmission Indirect", "TransInd", "RGB", "COLOR",
        "use_pass_transmission_indirect",
    ),
    RenderPass(
        "transmission_color", "Transmission Color", "TransCol", "RGB", "COLOR",
        "use_pass_transmission_color",
    ),
    RenderPass("seen_emission", "Emission", "Emit", "RGB", "COLOR", "use_pass_emit"),
    RenderPass("environment", "Environment", "Env", "RGB", "COLOR", "use_pass_environment"),
    RenderPass("caustics", "Caustics", "Caustics", "RGB", "COLOR", "pm.use_pass_caustics"),
    RenderPass(
        "photon_density", "Photon Density", "Photon Density", "X", "VALUE",
        "pm.use_pass_photon_density",
    ),
    RenderPass("error", "Error", "Error", "X", "VALUE", "pm.use_pass_error"),
    RenderPass(
        "combined", "Noisy Image", "Noisy Image", "RGBA", "COLOR", "pm.use_pass_denoising"
    ),
    RenderPass(
        "end_albedo", "Denoising Albedo", "Denoising Albedo", "RGB", "COLOR",
        "pm.use_pass_denoising",
    ),
    RenderPass(
        "end_normal", "Denoising Normal", "Denoising Normal", "XYZ", "VECTOR",
        "pm.use_pass_denoising",
    ),
    RenderPass(
        "end_depth", "Denoising Depth", "Denoising Depth", "Z", "VALUE",
        "pm.use_pass_denoising",
    ),
)  # fmt: skip

#: Cryptomatte, ranked names by two in each pass: the first of them.
MATTES: tuple[RenderPass, ...] = (
    RenderPass(
        "matte_object", "CryptoObject", "CryptoObject", "rgba", "COLOR",
        "use_pass_cryptomatte_object",
    ),
    RenderPass(
        "matte_material", "CryptoMaterial", "CryptoMaterial", "rgba", "COLOR",
        "use_pass_cryptomatte_material",
    ),
    RenderPass(
        "matte_asset", "CryptoAsset", "CryptoAsset", "rgba", "COLOR",
        "use_pass_cryptomatte_asset",
    ),
)  # fmt: skip


#: Light groups; the group's name follows.
GROUPS: tuple[RenderPass, ...] = (
    RenderPass("combined", "Combined_", "Combined_", "RGB", "COLOR", ""),
    RenderPass("caustics", "Caustics_", "Caustics_", "RGB", "COLOR", "pm.use_pass_caustics"),
)


#: Values of the user's own, colours with how much has one, or numbers: by the user's name.
AOVS: tuple[RenderPass, ...] = (
    RenderPass("aov", "Shader AOV", "Shader AOV", "RGBA", "COLOR", ""),
    RenderPass("aov", "Shader AOV", "Shader AOV", "X", "VALUE", ""),
)


def pass_name(entry: RenderPass) -> str:
    """The name in the running Blender."""
    return entry.name if bpy.app.version >= (5, 0, 0) else entry.old_name


def matte_ranks(view_layer: Any) -> int:
    """Names kept per pixel: an even number, as two of them share a pass."""
    return 2 * ((min(16, int(view_layer.pass_cryptomatte_depth)) + 1) // 2)


def active_passes(view_layer: Any) -> Iterator[RenderPass]:
    """The passes that ``view_layer`` asks for."""
    for entry in PASSES:
        owner, toggle = view_layer, entry.toggle
        if toggle.startswith("pm."):
            owner, toggle = view_layer.photon_map, toggle.removeprefix("pm.")
        if not toggle or getattr(owner, toggle):
            yield entry
    for entry in MATTES:
        if getattr(view_layer, entry.toggle):
            for k in range(matte_ranks(view_layer) // 2):
                name = f"{entry.name}{k:02d}"
                yield entry._replace(name=name, old_name=name, first=4 * k)
    yield from _group_passes(view_layer)
    yield from _aov_passes(view_layer)


def wanted_aovs(view_layer: Any) -> dict[str, str]:
    """The AOVs of ``view_layer`` that have a pass: "COLOR" or "VALUE" by name."""
    return {aov.name: aov.type for aov in view_layer.aovs if aov.is_valid}


def _aov_passes(view_layer: Any) -> Iterator[RenderPass]:
    """The values of AOV Output nodes."""
    wanted = wanted_aovs(view_layer)
    if not wanted:
        return
    from ..core import aov_layer

    for entry in AOVS:
        for name in (name for name, kind in wanted.items() if kind == entry.kind):
            yield entry._replace(layer=aov_layer(name), name=name, old_name=name)


def _group_passes(view_layer: Any) -> Iterator[RenderPass]:
    """The light of each light group, and its caustics where these are asked for at all."""
    if not view_layer.lightgroups:
        return
    from ..core import group_layer

    for group in view_layer.lightgroups:
        for entry in GROUPS:
            caustics = entry.layer == "caustics"
            if not caustics or view_layer.photon_map.use_pass_caustics:
                name = entry.name + group.name
                layer = group_layer(group.name, caustics)
                yield entry._replace(layer=layer, name=name, old_name=name)


def _light_groups(depsgraph: Any) -> tuple[LightGroup, ...]:
    """The lights, glowing objects and world of each light group of the view layer."""
    names = [group.name for group in depsgraph.view_layer_eval.lightgroups]
    if not names:
        return ()
    from ..core import LightGroup

    lamps: dict[str, set[str]] = {name: set() for name in names}
    objects: dict[str, set[str]] = {name: set() for name in names}
    for instance in depsgraph.object_instances:
        obj = instance.object
        if obj.lightgroup in lamps:
            found = lamps if obj.type == "LIGHT" else objects
            found[obj.lightgroup].add(obj.name)
    world = depsgraph.scene_eval.world
    around = world.lightgroup if world is not None else ""
    return tuple(
        LightGroup(name, tuple(sorted(lamps[name])), tuple(sorted(objects[name])),
                   name == around)
        for name in names
    )  # fmt: skip


def asked_settings(depsgraph: Any) -> dict[str, Any]:
    """The core's settings for what it renders only when it is asked for."""
    from ..core import FIRST_HIT_LAYERS, KIND_COLORS, KIND_LAYERS

    view_layer = depsgraph.view_layer_eval
    asked = {entry.layer for entry in active_passes(view_layer)}
    if "vector" in asked:
        asked.add("place")
    light_kinds = bool(asked & set(KIND_LAYERS))
    if light_kinds:
        asked |= set(KIND_COLORS)
    return {
        "first_hit": tuple(layer for layer in FIRST_HIT_LAYERS if layer in asked),
        "matte_ranks": matte_ranks(view_layer),
        "light_kinds": light_kinds,
        "light_groups": _light_groups(depsgraph),
        "aovs": tuple(wanted_aovs(view_layer)),
    }


def register_passes(engine: Any, scene: Any, view_layer: Any) -> None:
    """Register what ``view_layer`` asks for with Blender."""
    for entry in active_passes(view_layer):
        engine.register_pass(
            scene, view_layer, pass_name(entry), len(entry.channels), entry.channels, entry.kind
        )
