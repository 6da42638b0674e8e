"""What an object does in caustics, at ``Object.photon_map``."""

# No "from __future__ import annotations" here: Blender reads the annotations as properties.
import bpy
from bpy.props import BoolProperty, StringProperty

from .tagging import tag_owner


class PhotonMapObjectProperties(bpy.types.PropertyGroup):
    """Settings of one object."""

    casts_caustics: BoolProperty(  # type: ignore[valid-type]
        name="Cast Caustics",
        description="Send photons to this object when its material is a mirror, clear glass or "
        "nearly so. Without, its caustics are missing and photons go to other objects",
        default=True,
        update=tag_owner,
    )
    shows_caustics: BoolProperty(  # type: ignore[valid-type]
        name="Receive Caustics",
        description="Show the caustics that fall on this object; other light stays as it is",
        default=True,
        update=tag_owner,
    )
    answer: StringProperty(  # type: ignore[valid-type]
        name="Answer",
        description="What the last look for a missing caustic found",
        options={"HIDDEN", "SKIP_SAVE"},
    )
