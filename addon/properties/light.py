"""How many photons a lamp sends, at ``Light.photon_map``."""

# No "from __future__ import annotations" here: Blender reads the annotations as properties.
import bpy
from bpy.props import FloatProperty

from .tagging import tag_owner


class PhotonMapLightProperties(bpy.types.PropertyGroup):
    """Settings of one lamp."""

    photons: FloatProperty(  # type: ignore[valid-type]
        name="Photon Share",
        description="How many photons this lamp gets, as a factor on the share that suits its "
        "power: 2 gives twice as many as without. The light stays the same, its caustics get "
        "less noisy and those of other lamps noisier",
        default=1.0,
        min=0.01,
        max=100.0,
        soft_min=0.1,
        soft_max=10.0,
        update=tag_owner,
    )
