"""The row types of a scene's tables: what a material, a lobe and a light are made of.

Kernels read these rows; only ``bsdf/dispatch.py`` and ``lights/dispatch.py`` look at
``model`` and ``kind``. All lengths are metres, all colours scene-linear.
"""

from __future__ import annotations

from enum import IntEnum, IntFlag

import numpy as np


class Model(IntEnum):
    """Scattering model of one lobe."""

    DIFFUSE = 0
    PHONG = 1
    CONDUCTOR = 2
    DIELECTRIC = 3
    REFRACTION = 4
    OREN_NAYAR = 5
    GGX = 6
    GGX_DIELECTRIC = 7
    GGX_REFRACTION = 8
    TRANSPARENT = 9
    TRANSLUCENT = 10
    SHEEN = 11
    #: BRDFs of others, see ``bsdf/added``.
    ADDED_1 = 12
    ADDED_2 = 13


#: Models whose scattering is a Dirac delta: no photon is stored for them.
SPECULAR_MODELS = (Model.CONDUCTOR, Model.DIELECTRIC, Model.REFRACTION, Model.TRANSPARENT)


class Fresnel(IntEnum):
    """How the reflectance of a reflecting lobe grows towards grazing."""

    NONE = 0
    DIELECTRIC = 1
    F82 = 2
    SCHLICK = 3


class ClosureKind(IntEnum):
    """Shader node that a closure comes from."""

    DIFFUSE = 0
    GLOSSY = 1
    GLASS = 2
    REFRACTION = 3
    TRANSPARENT = 4
    TRANSLUCENT = 5
    EMISSION = 6
    PRINCIPLED = 7
    SHEEN = 8
    METALLIC = 9


class Channel(IntEnum):
    """What of a texture's colour a parameter takes."""

    COLOR = 0
    ALPHA = 1
    LUMINANCE = 2
    RED = 3
    GREEN = 4
    BLUE = 5


class Extension(IntEnum):
    """What an image shows outside of its square."""

    REPEAT = 0
    EXTEND = 1
    CLIP = 2
    MIRROR = 3


class ImageKind(IntEnum):
    """How an image's texels are stored: linear or sRGB, bytes or float32."""

    BYTES = 0
    SRGB_BYTES = 1
    FLOATS = 2
    SRGB_FLOATS = 3


class LightKind(IntEnum):
    """Shape of a lamp."""

    POINT = 0
    SPOT = 1
    SUN = 2
    RECTANGLE = 3
    DISK = 4


class Visibility(IntFlag):
    """Which rays see an object, or the shape of a lamp (a lamp never blocks a ray).

    The last three are no rays: an object that casts no caustics, one that shows none, and
    one that cuts a hole into what the camera sees.
    """

    CAMERA = 1
    DIFFUSE = 2
    GLOSSY = 4
    TRANSMISSION = 8
    SHADOW = 16
    ALL = 31
    CASTS_NONE = 32
    SHOWS_NONE = 64
    HOLDOUT = 128


#: One scattering lobe. ``weight`` is its albedo per channel, mix factors included; ``ior``
#: is absolute (DIELECTRIC, REFRACTION); ``exponent`` belongs to PHONG. ``roughness``: alpha
#: of GGX, or what OREN_NAYAR and SHEEN call roughness. ``eta``: n transmitted / n incident
#: as seen from ``wo`` for rough glass, set when the lobe is resolved at a hit. ``fresnel``
#: with ``f0`` and ``f90`` (F82: the tint at 82 degrees; SCHLICK: at 90) scales reflection;
#: GGX_DIELECTRIC tints what it transmits by ``f90``; OREN_NAYAR has its facets' albedo in
#: ``f0``, SHEEN its shape (only resolved lobes have one). ``share``: estimate of
#: what the lobe scatters, by which it is drawn.
LOBE = np.dtype(
    [
        ("model", "i4"),
        ("fresnel", "i4"),
        ("weight", "f8", 3),
        ("share", "f8"),
        ("ior", "f8"),
        ("exponent", "f8"),
        ("roughness", "f8"),
        ("eta", "f8"),
        ("f0", "f8", 3),
        ("f90", "f8", 3),
    ],
    align=True,
)

#: A parameter of a shader node: ``value`` times what ``channel`` of ``texture`` says
#: (-1: ``value`` alone). Numbers stand in ``value[0]``.
PARAM = np.dtype([("value", "f8", 3), ("texture", "i4"), ("channel", "i4")], align=True)

#: A value of the user's own on the surfaces of a material; ``known``: 0 where it has none.
AOV = np.dtype([("param", PARAM), ("known", "i4")], align=True)

#: A mix factor on the way to a shader node; ``invert``: 1 - factor counts.
FACTOR = np.dtype([("param", PARAM), ("invert", "i4")], align=True)

#: Mix factors that one closure can have.
MOST_FACTORS = 4

#: One shader node with its place in the tree: weighed by the product of its factors.
#: ``emission`` carries colour times strength; ``distribution``: 0 GGX, 1 multiscatter GGX.
CLOSURE = np.dtype(
    [
        ("kind", "i4"),
        ("factor_count", "i4"),
        ("factors", FACTOR, MOST_FACTORS),
        ("color", PARAM),
        ("roughness", PARAM),
        ("metallic", PARAM),
        ("transmission", PARAM),
        ("alpha", PARAM),
        ("emission", PARAM),
        ("ior", "f8"),
        ("specular_level", "f8"),
        ("specular_tint", "f8", 3),
        ("coat", "f8"),
        ("coat_roughness", "f8"),
        ("coat_ior", "f8"),
        ("coat_tint", "f8", 3),
        ("sheen", "f8"),
        ("sheen_roughness", "f8"),
        ("sheen_tint", "f8", 3),
        ("diffuse_roughness", "f8"),
        ("distribution", "i4"),
    ],
    align=True,
)

#: Fields of ``CLOSURE`` that a texture can drive.
PARAM_NAMES = ("color", "roughness", "metallic", "transmission", "alpha", "emission")

#: One material. Its lobes are a slice of the lobe table; a material with closures has them
#: resolved at every hit instead. ``emission``: radiance of both sides (the mean one where
#: closures emit). ``ior`` is that of the medium behind the surface, 0 when there is none;
#: ``absorption`` [1/m] inside it; of overlapping media the one with the larger
#: ``priority`` counts. ``passes``: a ray may go straight through. ``normal_texture`` and
#: ``bump_texture``: rows of the texture table, -1 without. ``index``: a number of the user's.
MATERIAL = np.dtype(
    [
        ("lobe_start", "i4"),
        ("lobe_count", "i4"),
        ("closure_start", "i4"),
        ("closure_count", "i4"),
        ("emission", "f8", 3),
        ("ior", "f8"),
        ("absorption", "f8", 3),
        ("priority", "i4"),
        ("passes", "i4"),
        ("index", "i4"),
        ("normal_texture", "i4"),
        ("bump_texture", "i4"),
        ("normal_strength", "f8"),
        ("bump_strength", "f8"),
        ("bump_distance", "f8"),
    ],
    align=True,
)

#: One use of an image. ``uv``: which set of coordinates; ``to_image``: affine map (2, 3)
#: from them to the image's unit square; ``interpolation``: 0 linear, 1 closest;
#: ``unassociate``: colours are divided by alpha, which the texels have multiplied in.
TEXTURE = np.dtype(
    [
        ("image", "i4"),
        ("uv", "i4"),
        ("to_image", "f8", (2, 3)),
        ("extension", "i4"),
        ("interpolation", "i4"),
        ("unassociate", "i4"),
    ],
    align=True,
)

#: One image: rows from the bottom, RGBA texels from ``start`` on in the table of its kind.
IMAGE = np.dtype(
    [("start", "i8"), ("width", "i4"), ("height", "i4"), ("kind", "i4")], align=True
)

#: One lamp. It shines along ``-axis_z``; ``axis_x`` carries ``size_x``, ``axis_y``
#: ``size_y`` (full sizes). ``emission`` per channel means, by kind: POINT and SPOT radiant
#: intensity on the axis [W/sr], SUN irradiance on a facing plane [W/m^2], RECTANGLE and
#: DISK radiance along the axis times ``spread``'s share, so that it stays the mean over the
#: hemisphere [W/(m^2 sr)]. ``angle``: SUN full diameter [rad]; ``spread``: RECTANGLE and
#: DISK full angle of the slats [rad], pi without; ``cos_outer`` and ``blend``: SPOT cone,
#: stretched by ``size_x`` and ``size_y``; ``soft``: POINT and SPOT of a radius are discs that
#: face who looks, not spheres; ``shadow``: 0 when nothing blocks its direct light;
#: ``visibility``: ``Visibility`` bits.
LIGHT = np.dtype(
    [
        ("kind", "i4"),
        ("visibility", "i4"),
        ("soft", "i4"),
        ("shadow", "i4"),
        ("position", "f8", 3),
        ("axis_x", "f8", 3),
        ("axis_y", "f8", 3),
        ("axis_z", "f8", 3),
        ("emission", "f8", 3),
        ("size_x", "f8"),
        ("size_y", "f8"),
        ("radius", "f8"),
        ("angle", "f8"),
        ("spread", "f8"),
        ("cos_outer", "f8"),
        ("blend", "f8"),
    ],
    align=True,
)
