"""Render settings of a scene, at ``Scene.photon_map``.

Names, ranges and defaults are those of ``core.settings.Settings``. Numbers of enum items
are explicit, because files store the number and not the name.
"""

# No "from __future__ import annotations" here: Blender reads the annotations as properties.
import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty

from ...core.settings import Settings

_DEFAULT = Settings()


class PhotonMapSceneProperties(bpy.types.PropertyGroup):
    """What a user may choose about a render."""

    passes: IntProperty(  # type: ignore[valid-type]
        name="Passes",
        description="Render at most so many passes, each one of photons and one of the camera",
        default=_DEFAULT.passes,
        min=1,
        soft_max=4096,
        max=10_000_000,
    )
    viewport_passes: IntProperty(  # type: ignore[valid-type]
        name="Viewport Passes",
        description="Passes of the rendered viewport",
        default=32,
        min=1,
        max=10_000_000,
        soft_max=1024,
    )
    seconds: FloatProperty(  # type: ignore[valid-type]
        name="Time Limit",
        unit="TIME_ABSOLUTE",
        description="Stop after so many seconds of rendering, one pass is always made; "
        "0 for no limit",
        default=_DEFAULT.seconds,
        min=0.0,
        max=1e9,
        soft_max=3600.0,
        precision=1,
        step=100,
    )
    error_goal: FloatProperty(  # type: ignore[valid-type]
        name="Error Goal",
        description="Stop when the estimated relative error of a typical pixel is as small "
        "as this, for example 0.05 for 5 %; 0 for no goal",
        default=_DEFAULT.error_goal,
        min=0.0,
        max=10.0,
        soft_max=1.0,
        precision=4,
        step=1,
    )
    photons_automatic: BoolProperty(  # type: ignore[valid-type]
        name="Automatic",
        description="Photons a pass by the size of the image (half as many as it has pixels, "
        "8192 at least), caustic photons, light samples and gather rays by where the noise "
        "comes from",
        default=True,
    )
    photons_caustic: IntProperty(  # type: ignore[valid-type]
        name="Caustic Photons",
        description="Photons emitted in each pass towards glass and mirrors; 0 for none",
        default=100_000,
        min=0,
        max=100_000_000,
        soft_max=1_000_000,
    )
    photons_global: IntProperty(  # type: ignore[valid-type]
        name="Global Photons",
        description="Photons emitted in each pass for indirect light; 0 for none",
        default=100_000,
        min=0,
        max=100_000_000,
        soft_max=1_000_000,
    )
    light_samples: IntProperty(  # type: ignore[valid-type]
        name="Light Samples",
        description="Points on lights that are asked for direct light from each place that the "
        "camera sees",
        default=_DEFAULT.lights_each,
        min=1,
        max=1024,
        soft_max=16,
    )
    gather_rays: IntProperty(  # type: ignore[valid-type]
        name="Gather Rays",
        description="Final-gather rays for indirect light from each place that the camera sees",
        default=_DEFAULT.rays_each,
        min=1,
        max=1024,
        soft_max=64,
    )
    caustic_radius: FloatProperty(  # type: ignore[valid-type]
        name="Caustic Radius",
        description="Radius of the caustic estimate in the first pass, in pixels of the image; "
        "smaller is sharper and noisier",
        subtype="PIXEL",
        default=_DEFAULT.caustic_radius,
        min=0.1,
        max=1000.0,
        soft_max=20.0,
    )
    alpha: FloatProperty(  # type: ignore[valid-type]
        name="Radius Shrinking",
        description="How slowly radii shrink from pass to pass; 1 keeps them",
        default=_DEFAULT.alpha,
        min=0.01,
        max=1.0,
    )
    camera_depth: IntProperty(  # type: ignore[valid-type]
        name="Camera Depth",
        description="Most surfaces that a path from the camera may meet; a glass ball takes "
        "two of them",
        default=_DEFAULT.camera_depth,
        min=1,
        max=1024,
        soft_max=128,
    )
    photon_depth: IntProperty(  # type: ignore[valid-type]
        name="Photon Depth",
        description="Most surfaces that a photon may meet; the caustic of a glass ball takes "
        "three of them",
        default=_DEFAULT.photon_depth,
        min=1,
        max=1024,
        soft_max=128,
    )
    min_throughput: FloatProperty(  # type: ignore[valid-type]
        name="Throughput Limit",
        description="End camera paths that carry less than this part of their light",
        default=_DEFAULT.min_throughput,
        min=0.0,
        max=1.0,
        precision=5,
        step=0.01,
    )
    photon_memory: IntProperty(  # type: ignore[valid-type]
        name="Photon Memory",
        description="Most memory in megabytes that the photons of a pass, and of the passes "
        "under way, may take. Where it is too little, passes have fewer photons, and a warning "
        "says how many",
        default=_DEFAULT.photon_memory,
        min=16,
        max=1_000_000,
        soft_max=65_536,
    )
    adaptive: BoolProperty(  # type: ignore[valid-type]
        name="Adaptive Sampling",
        description="Passes have more camera paths where the picture is noisy, up to about "
        "four a pixel, and fewer elsewhere, one every other pass at least; as many in all as "
        "one a pixel",
        default=_DEFAULT.adaptive,
    )
    split_depth: IntProperty(  # type: ignore[valid-type]
        name="Split at Glass",
        description="So many first events of a camera path are followed both ways, reflected "
        "and refracted, if they are at smooth glass; at others one is chosen at random",
        default=_DEFAULT.split_depth,
        min=0,
        max=16,
    )
    split_least: FloatProperty(  # type: ignore[valid-type]
        name="Least Weight",
        description="Ways that would carry less of the pixel's light than this are followed at "
        "random, and then carry so much",
        default=_DEFAULT.split_least,
        min=1e-6,
        max=1.0,
        precision=3,
        step=1,
    )
    shadow_photons: IntProperty(  # type: ignore[valid-type]
        name="Shadow Photons",
        description="Straight paths from the lamps, once a render, that spare shadow rays "
        "where they tell enough; 0 for none, which is faster",
        default=_DEFAULT.shadow_photons,
        min=0,
        max=100_000_000,
        soft_max=1_000_000,
    )
    shadow_lit: FloatProperty(  # type: ignore[valid-type]
        name="Lit Below",
        description="Share of shadow photons around a place below which it counts as lit",
        default=_DEFAULT.shadow_lit,
        min=0.0,
        max=1.0,
    )
    shadow_dark: FloatProperty(  # type: ignore[valid-type]
        name="Dark Above",
        description="Share of shadow photons around a place above which it counts as dark",
        default=_DEFAULT.shadow_dark,
        min=0.0,
        max=1.0,
    )
    seed: IntProperty(  # type: ignore[valid-type]
        name="Seed",
        description="Another seed gives another noise pattern. All frames of an animation have "
        "the same, so that its noise stands still, unless the seed has keys or a driver",
        default=_DEFAULT.seed,
        min=0,
        max=2**31 - 1,
    )
    use_denoise: BoolProperty(  # type: ignore[valid-type]
        name="Denoise",
        description="Take the noise off the finished image with Open Image Denoise, which "
        "comes with Blender. Caustics stay as they are: sharp, with what noise they have",
        default=False,
    )
    exposure: FloatProperty(  # type: ignore[valid-type]
        name="Exposure",
        description="Factor on the light in the image and its passes",
        default=_DEFAULT.exposure,
        min=0.0,
        max=10.0,
    )
    pixel_filter: EnumProperty(  # type: ignore[valid-type]
        name="Pixel Filter",
        description="How samples are weighted into pixels",
        items=(
            ("BOX", "Box", "Plain average", 0),
            ("GAUSSIAN", "Gaussian", "Smooth", 1),
            ("BLACKMAN_HARRIS", "Blackman-Harris", "Smooth and compact", 2),
        ),
        default=_DEFAULT.pixel_filter,
    )
