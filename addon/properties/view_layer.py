"""Passes of our own, at ``ViewLayer.photon_map``."""

# No "from __future__ import annotations" here: Blender reads the annotations as properties.
import bpy
from bpy.props import BoolProperty


def _passes_changed(self: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    """Have Blender ask the engine for its passes again, for the compositor's sockets."""
    for layer in self.id_data.view_layers:
        layer.update_render_passes()


class PhotonMapViewLayerProperties(bpy.types.PropertyGroup):
    """Which of the engine's own passes a view layer has."""

    use_pass_caustics: BoolProperty(  # type: ignore[valid-type]
        name="Caustics",
        description="Light that reached the surface through glass or mirrors",
        default=True,
        update=_passes_changed,
    )
    use_pass_denoising: BoolProperty(  # type: ignore[valid-type]
        name="Denoising Data",
        description=(
            "Colour, normal and depth of what is seen through mirrors and clear glass, for the "
            "Denoise node, and the image as it is without denoising: four passes"
        ),
        default=False,
        update=_passes_changed,
    )
    use_pass_photon_density: BoolProperty(  # type: ignore[valid-type]
        name="Photon Density",
        description=(
            "Photons per square metre that a pass stores around what the camera sees, also "
            "through glass and by mirrors: where it is low, light is guessed from few photons"
        ),
        default=False,
        update=_passes_changed,
    )
    use_pass_error: BoolProperty(  # type: ignore[valid-type]
        name="Error",
        description=(
            "How far Combined is expected to be from the truth, noise and bias together, "
            "as radiance, averaged over 5 x 5 pixels"
        ),
        default=False,
        update=_passes_changed,
    )
