"""Panels: our own, and Blender's that also make sense for this engine."""

from __future__ import annotations

import bpy

from . import (
    light,
    material,
    object,
    plan,
    presets,
    preview,
    render,
    stock,
    view_layer,
    world,
)

CLASSES = (
    *presets.CLASSES,
    plan.PHOTONMAP_RENDER_PT_warnings,
    *render.PANELS,
    *plan.PANELS,
    *view_layer.PANELS,
    *object.PANELS,
    *light.PANELS,
    *material.PANELS,
    *preview.PANELS,
    *world.PANELS,
)


def register() -> None:
    """Register our panels and join the stock ones."""
    for panel in CLASSES:
        bpy.utils.register_class(panel)
    presets.register()
    stock.join()
    preview.join()


def unregister() -> None:
    """Leave the stock panels and unregister ours."""
    preview.leave()
    stock.leave()
    presets.unregister()
    for panel in reversed(CLASSES):
        bpy.utils.unregister_class(panel)
