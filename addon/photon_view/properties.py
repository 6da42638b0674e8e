"""How photons are shown. Kept at the window manager: turning them on renders nothing anew."""

# No "from __future__ import annotations" here: Blender reads the annotations as properties.
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, PointerProperty

from .look import redraw


def _redraw(_: Any, __: Any) -> None:
    redraw()


class PhotonMapPhotonViewProperties(bpy.types.PropertyGroup):
    """At ``WindowManager.photon_map_photons``."""

    colour: EnumProperty(  # type: ignore[valid-type]
        name="Color",
        description="What the colors of the photons tell",
        items=(
            ("power", "Power", "Dark to bright, over the 2nd to 98th percentile", 0),
            ("bounce", "Bounce", "Surfaces that scattered the photon before", 1),
            ("caster", "Caster", "The object that its path met first", 2),
            ("light", "Light", "The lamp that it came from", 3),
        ),
        default="power",
        update=_redraw,
    )
    kind: EnumProperty(  # type: ignore[valid-type]
        name="Kind",
        description="Which photons are shown",
        items=(
            ("ALL", "All", "Both maps", 0),
            ("CAUSTIC", "Caustic", "Those that came by mirrors and glass alone", 1),
            ("GLOBAL", "Global", "Those of the map that final gathering asks", 2),
        ),
        default="ALL",
        update=_redraw,
    )
    source: EnumProperty(  # type: ignore[valid-type]
        name="From",
        description="Whose photons are shown",
        items=(
            ("SCENE", "Scene", "The photons that a render of the scene would trace now", 0),
            ("BAKED", "Baked Maps", "The photons in the file beside the .blend", 1),
        ),
        default="SCENE",
    )
    number: IntProperty(  # type: ignore[valid-type]
        name="Pass",
        description="Pass of the render, counted from 0: each has photons of its own, and "
        "smaller gather discs than the one before",
        default=0,
        min=0,
        max=1_000_000,
    )
    size: IntProperty(  # type: ignore[valid-type]
        name="Size",
        description="Size of a photon's point",
        default=2,
        min=1,
        max=20,
        subtype="PIXEL",
        update=_redraw,
    )
    in_front: BoolProperty(  # type: ignore[valid-type]
        name="In Front",
        description="Show photons and paths through what lies before them",
        default=False,
        update=_redraw,
    )
    paths: BoolProperty(  # type: ignore[valid-type]
        name="Paths",
        description="Show the ways of the photons in the picked disc from their lamps",
        default=True,
        update=_redraw,
    )


def register() -> None:
    """Attach the group."""
    bpy.utils.register_class(PhotonMapPhotonViewProperties)
    bpy.types.WindowManager.photon_map_photons = PointerProperty(
        type=PhotonMapPhotonViewProperties
    )


def unregister() -> None:
    """Detach it."""
    del bpy.types.WindowManager.photon_map_photons
    bpy.utils.unregister_class(PhotonMapPhotonViewProperties)
