"""What a material is to this engine, at ``Material.photon_map``."""

# No "from __future__ import annotations" here: Blender reads the annotations as properties.
import bpy
from bpy.props import IntProperty

from .tagging import tag_owner


class PhotonMapMaterialProperties(bpy.types.PropertyGroup):
    """Settings of one material."""

    priority: IntProperty(  # type: ignore[valid-type]
        name="Priority",
        description=(
            "Where bodies of glass or liquid overlap, the one with the larger number fills "
            "the space: let a drink reach a little into its glass and give the glass 1"
        ),
        default=0,
        min=-100,
        max=100,
        update=tag_owner,
    )
