"""Properties that the add-on adds to Blender's data, one file per ID type."""

from __future__ import annotations

import bpy

from .light import PhotonMapLightProperties
from .material import PhotonMapMaterialProperties
from .object import PhotonMapObjectProperties
from .scene import PhotonMapSceneProperties
from .view_layer import PhotonMapViewLayerProperties

#: ID type, property group: each is found at ``<ID>.photon_map``.
GROUPS = (
    (bpy.types.Scene, PhotonMapSceneProperties),
    (bpy.types.Object, PhotonMapObjectProperties),
    (bpy.types.Light, PhotonMapLightProperties),
    (bpy.types.Material, PhotonMapMaterialProperties),
    (bpy.types.ViewLayer, PhotonMapViewLayerProperties),
)


def register() -> None:
    """Register the groups and attach them."""
    for owner, group in GROUPS:
        bpy.utils.register_class(group)
        owner.photon_map = bpy.props.PointerProperty(type=group)


def unregister() -> None:
    """Detach the groups and unregister them."""
    for owner, group in reversed(GROUPS):
        del owner.photon_map
        bpy.utils.unregister_class(group)
