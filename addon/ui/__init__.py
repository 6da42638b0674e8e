"""Panels: our own, and Blender's that also make sense for this engine."""

from __future__ import annotations

import bpy

from . import light, material, render, stock, view_layer

CLASSES = (*render.PANELS, *view_layer.PANELS, *light.PANELS, *material.PANELS)


def register() -> None:
    """Register our panels and join the stock ones."""
    for panel in CLASSES:
        bpy.utils.register_class(panel)
    stock.join()


def unregister() -> None:
    """Leave the stock panels and unregister ours."""
    stock.leave()
    for panel in reversed(CLASSES):
        bpy.utils.unregister_class(panel)
