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


#: Models whose scattering is a Dirac delta: no photon is stored for them.
SPECULAR_MODELS = (Model.CONDUCTOR, Model.DIELECTRIC, Model.REFRACTION)


class LightKind(IntEnum):
    """Shape of a lamp."""

    POINT = 0
    SPOT = 1
    SUN = 2
    RECTANGLE = 3
    DISK = 4


class Visibility(IntFlag):
    """Which rays see the shape of a lamp (a lamp never blocks a ray)."""

    CAMERA = 1
    DIFFUSE = 2
    GLOSSY = 4
    TRANSMISSION = 8
    ALL = 15


#: One scattering lobe. ``weight`` is its albedo per channel, mix factors included;
#: ``ior`` is absolute (DIELECTRIC, REFRACTION); ``exponent`` belongs to PHONG.
LOBE = np.dtype(
    [("model", "i4"), ("weight", "f8", 3), ("ior", "f8"), ("exponent", "f8")], align=True
)

#: One material: a slice of the lobe table and what it emits (radiance, both sides).
#: ``ior`` is that of the medium behind the surface, 0 when there is no medium.
MATERIAL = np.dtype(
    [
        ("lobe_start", "i4"),
        ("lobe_count", "i4"),
        ("emission", "f8", 3),
        ("ior", "f8"),
    ],
    align=True,
)

#: One lamp. It shines along ``-axis_z``; ``axis_x`` carries ``size_x``, ``axis_y``
#: ``size_y`` (full sizes). ``emission`` per channel means, by kind: POINT and SPOT radiant
#: intensity on the axis [W/sr], SUN irradiance on a facing plane [W/m^2], RECTANGLE and
#: DISK radiance [W/(m^2 sr)]. ``angle``: SUN full diameter [rad]; ``cos_outer`` and
#: ``blend``: SPOT cone; ``visibility``: ``Visibility`` bits.
LIGHT = np.dtype(
    [
        ("kind", "i4"),
        ("visibility", "i4"),
        ("position", "f8", 3),
        ("axis_x", "f8", 3),
        ("axis_y", "f8", 3),
        ("axis_z", "f8", 3),
        ("emission", "f8", 3),
        ("size_x", "f8"),
        ("size_y", "f8"),
        ("radius", "f8"),
        ("angle", "f8"),
        ("cos_outer", "f8"),
        ("blend", "f8"),
    ],
    align=True,
)
