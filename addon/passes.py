"""The one table that says which layer of the film is which pass in Blender."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import bpy


class RenderPass(NamedTuple):
    """A layer of the film, and the pass it becomes."""

    layer: str  #: name in ``core.film``
    name: str  #: name in Blender 5.0 and later
    old_name: str  #: name before 5.0
    channels: str  #: one letter per channel
    kind: str  #: Blender's socket type: COLOR, VECTOR or VALUE
    toggle: str  #: property of the view layer, "" = always on; "pm." = our own group


#: Blender's "direct" and "indirect" diffuse passes are light without the surface colour;
#: here they hold the estimators' terms at the first non-specular surface with its colour
#: and every lobe included: "direct" is light straight from lamps, "indirect" light that
#: has met a non-specular surface before. Emission + direct + caustics + indirect is
#: Combined.
PASSES: tuple[RenderPass, ...] = (
    RenderPass("combined", "Combined", "Combined", "RGBA", "COLOR", ""),
    RenderPass("depth", "Depth", "Depth", "Z", "VALUE", "use_pass_z"),
    RenderPass("normal", "Normal", "Normal", "XYZ", "VECTOR", "use_pass_normal"),
    RenderPass(
        "direct", "Diffuse Direct", "DiffDir", "RGB", "COLOR", "use_pass_diffuse_direct"
    ),
    RenderPass(
        "indirect", "Diffuse Indirect", "DiffInd", "RGB", "COLOR", "use_pass_diffuse_indirect"
    ),
    RenderPass("emission", "Emission", "Emit", "RGB", "COLOR", "use_pass_emit"),
    RenderPass("caustics", "Caustics", "Caustics", "RGB", "COLOR", "pm.use_pass_caustics"),
    RenderPass(
        "albedo",
        "Denoising Albedo",
        "Denoising Albedo",
        "RGB",
        "COLOR",
        "pm.use_pass_denoising_albedo",
    ),
    RenderPass("error", "Error", "Error", "X", "VALUE", "pm.use_pass_error"),
)


def pass_name(entry: RenderPass) -> str:
    """The name in the running Blender."""
    return entry.name if bpy.app.version >= (5, 0, 0) else entry.old_name


def active_passes(view_layer: Any) -> Iterator[RenderPass]:
    """The passes that ``view_layer`` asks for."""
    for entry in PASSES:
        owner, toggle = view_layer, entry.toggle
        if toggle.startswith("pm."):
            owner, toggle = view_layer.photon_map, toggle.removeprefix("pm.")
        if not toggle or getattr(owner, toggle):
            yield entry


def register_passes(engine: Any, scene: Any, view_layer: Any) -> None:
    """Register what ``view_layer`` asks for with Blender."""
    for entry in active_passes(view_layer):
        engine.register_pass(
            scene, view_layer, pass_name(entry), len(entry.channels), entry.channels, entry.kind
        )
